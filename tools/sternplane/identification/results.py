"""What was found, as a document for programs, a table for a terminal, and a comment for the vehicle file."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from firmware_py.estimation.model.state import MOTIONS
from sternplane.identification.assessment import Assessment
from sternplane.identification.estimate import LARGE, WHITE, Estimated, Identification
from sternplane.identification.recording import Recording
from sternplane.identification.remedies import remedies
from sternplane.logs.learned import believed
from sternplane.logs.run import Run
from sternplane.logs.true_coefficients import truth

DIRECTIONS = 3
"""So many of the weakest directions are document."""
APART = 5.0
"""Two estimates from the same measurements differ by far less than this many sigmas if both are right."""
CONSISTENT = (0.8, 1.2)
"""The filter's mean NIS, were its model right."""


def result_document(log: Run, recording: Recording, found: Identification, assessment: Assessment) -> dict[str, Any]:
    """All of it in plain numbers; None where there is none."""
    true, names = truth(log.header, believed(log.header), recording.t), found.names
    changed = [name for name in names if name in true and np.ptp(true[name])]
    by_name = {}
    for i, name in enumerate(names):
        by_name[name] = {
            "believed": float(found.believed[i]),
            "filter": _known(found.filtered, i),
            "likelihood": {**_known(found.likelihood, i), "widened": float(found.widening[i]), "valid": found.white},
            "truth": float(true[name][0]) if name in true and name not in changed else None,
            "identifiable": name not in assessment.unknown,
        }
    return {
        "log": str(log.path.resolve()),  # runs/latest is another one tomorrow
        "scenario": log.header.get("scenario"),
        "revision": log.header.get("git"),
        "vehicle": log.header["configuration"]["files"]["vehicle"],
        "from": float(recording.t[0]),
        "to": float(recording.t[-1]),
        "dropped": dict(recording.dropped),
        "taken": "likelihood" if found.white else "filter",
        "coefficients": by_name,
        "correlation": np.round(_correlation(found.taken), 4).tolist(),
        "weak": [
            {"direction": one.words, "sigma": one.sigma, "weights": dict(zip(names, one.weights.tolist(), strict=True))}
            for one in assessment.weak
        ],
        "current": [None if math.isnan(x) else float(x) for x in (*found.current, *found.current_std)],
        "turbulence": found.turbulence,
        "nis": dict(zip(("dvl", "gyro", "attitude"), found.nis, strict=True)),
        "residuals": {
            name: {
                "std": float(found.fit.std[i]),
                "over_sensor": float(found.size[i]),
                "autocorrelation": float(found.confidence.whiteness[i]),
            }
            for i, name in enumerate(MOTIONS)
        },
        "steps": found.fit.steps,
        "at_rest": found.fit.found,
        "not_identifiable": list(assessment.sentences),
        "remedies": remedies(recording, names, found.white, bool(assessment.sentences)),
        "remarks": [
            *([f"The log is {log.lost}."] if log.lost else []),
            *([f"A fault changes the truth of {', '.join(changed)} meanwhile: it is not shown."] if changed else []),
            *remarks(recording, found),
        ],
    }


def remarks(recording: Recording, found: Identification) -> list[str]:
    """What a reader has to know of the figures."""
    said = [
        f"{lost} readings of the {name.upper()} were not used: not finite or wild, not vouched for (a DVL "
        "without bottom lock), from the future, or older than one before."
        for name, lost in recording.dropped.items()
        if lost
    ]
    if found.white:
        said.append(
            "The residuals of maximum likelihood are the sensors' noise; its values are taken. It flies the model "
            "without process noise, and its intervals know nothing of errors in what was not estimated."
        )
        apart = np.abs(found.filtered.values - found.likelihood.values) / found.filtered.std
        if apart.max() > APART:
            said.append(
                f"The filter is {apart.max():.0f} of its sigmas away from that in {found.names[int(apart.argmax())]}: "
                "it has lost its way in this log, and its intervals are not to be believed."
            )
        return said
    rest = "" if found.fit.found else "has not come to rest, and "
    worst, grown = np.abs(found.confidence.whiteness).max(), found.widening.max()
    said.append(
        f"Maximum likelihood {rest}leaves residuals that are not the sensors' noise: {found.size.min():.1f} to "
        f"{found.size.max():.1f} times as large, with autocorrelation "
        f"up to {worst:.2f} (noise alone: below {LARGE:g} and {WHITE:g}). It "
        f"knows no turbulence. Its intervals were widened, up to {grown:.1f} times, by that autocorrelation, and may "
        "still be far too narrow: the filter's values are taken."
    )
    if not all(CONSISTENT[0] <= nis <= CONSISTENT[1] for nis in found.nis):
        dvl, gyro, attitude = found.nis
        said.append(
            f"The filter does not explain the log either: its mean NIS is {dvl:.2f} for the DVL, {gyro:.2f} for the "
            f"gyros, {attitude:.2f} for attitude, where 1 is right. The model lacks something that no interval shows."
        )
    return said


def print_results(console: Console, document: dict[str, Any]) -> None:
    """The table, the weak directions and the assessment."""
    table = Table(box=None, pad_edge=True)
    true = any(one["truth"] is not None for one in document["coefficients"].values())
    for head in ("", "believed", "filter", "±3σ", "likelihood", "±3σ", "taken ±3σ", *(["truth"] if true else [])):
        table.add_column(head, justify="left" if not head else "right", no_wrap=True)
    for name, one in document["coefficients"].items():
        filtered, likely = one["filter"], one["likelihood"]
        share = 300.0 * one[document["taken"]]["std"] / abs(one[document["taken"]]["value"] or one["believed"])
        cells = [f"{one['believed']:.5f}", f"{filtered['value']:.5f}", f"{3.0 * filtered['std']:.5f}"]
        cells += [f"{likely['value']:.5f}", f"{3.0 * likely['std']:.5f}" if likely["valid"] else "not valid"]
        cells.append(f"{share:.2f} %" if one["identifiable"] else "as believed")
        table.add_row(name, *cells, *([f"{one['truth']:.5f}"] if one["truth"] is not None else []))
    console.print(table)
    for one in document["weak"][:DIRECTIONS]:
        console.print(f"  {one['direction']}: known to {100.0 * one['sigma']:.2g} % (1 sigma)", highlight=False)
    for sentence in document["remarks"]:
        console.print(f"  {sentence}", highlight=False)
    for sentence in document["not_identifiable"]:
        console.print(f"  not identifiable: {sentence}", highlight=False, style="bold red")
    for sentence in document["remedies"]:
        console.print(f"  try: {sentence}", highlight=False)


def origin(first: str, document: dict[str, Any]) -> str:
    """The comment at the top of the vehicle file."""
    method = "the filter"
    if document["taken"] == "likelihood":
        method = "maximum likelihood, whose intervals know nothing of errors in what was not estimated"
    lines = [
        f"{first} from {document['log']} ({document['scenario']}, revision {document['revision']}),",
        f"{document['from']:.2f} to {document['to']:.2f} s,",
        f"by {method};",
        f"all else is as in {document['vehicle']}. With 3 sigma:",
        "",
    ]
    for name, one in document["coefficients"].items():
        if one["identifiable"]:
            known = one[document["taken"]]
            lines.append(f"{name} = {known['value']:.6g} +- {3.0 * known['std']:.2g} (was {one['believed']:.6g})")
        else:
            lines.append(f"{name} is not identifiable from this log and stays {one['believed']:.6g}")
    return "\n".join(lines)


def _known(known: Estimated, i: int) -> dict[str, float]:
    return {"value": float(known.values[i]), "std": float(known.std[i])}


def _correlation(known: Estimated) -> Any:
    return known.covariance / np.outer(known.std, known.std)
