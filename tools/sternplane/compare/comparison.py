"""The comparison of runs as a document: who they are, what differs, their figures, and what to be careful of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from firmware_py.params import to_toml_value
from sternplane.compare.compared_run import ComparedRun, until
from sternplane.compare.settings import DIGEST, MISSING, Difference, differences, may_differ_unseen
from sternplane.logs.summary import Summary, summarise
from sternplane.logs.summary_text import key_figures, outcome, unlogged
from sternplane.report.steering_text import control_of, gains_text

_SAME_LENGTH = 1.0
"""Runs that differ by less, s, are as long as each other."""
_LONG = ("events", "losses", "losses_seen_s", "received")
"""Lists of a summary that a comparison leaves out."""

Rows = list[list[str]]


@dataclass(frozen=True)
class Comparison:
    """Runs side by side; every row has a label and a text for each run."""

    runs: Sequence[ComparedRun]

    @cached_property
    def identity(self) -> Rows:
        """Return who the runs are, which laws steered them with which gains, and how they ended."""
        headers = [run.log.header for run in self.runs]
        controls = [control_of(header) for header in headers]
        configurations = [header.get("configuration", {}) for header in headers]
        return [
            ["scenario", *(_named(header.get("scenario")) for header in headers)],
            ["vehicle", *(_named(one.get("vehicle", {}).get("name")) for one in configurations)],
            ["configuration", *(_named(one.get("files", {}).get("autopilot")) for one in configurations)],
            ["law", *(MISSING if one is None else to_toml_value(one.law, 1.0) for one in controls)],
            ["gains", *(MISSING if one is None else gains_text(one) for one in controls)],
            ["outcome", *(outcome(run.summary) for run in self.runs)],
            ["log", *(str(run.log.path) for run in self.runs)],
        ]

    @cached_property
    def differences(self) -> list[Difference]:
        """Return the settings that are not the same in all runs."""
        return differences([run.log for run in self.runs])

    @cached_property
    def figures(self) -> dict[str, Rows]:
        """Return the key figures of each whole run, by group."""
        return _side_by_side([run.summary for run in self.runs])

    @property
    def shortest(self) -> float:
        """Return how long the shortest run is, s."""
        return min(run.length for run in self.runs)

    @cached_property
    def common(self) -> list[Summary]:
        """Return the summaries up to the end of the shortest run; empty where all are as long."""
        if max(run.length for run in self.runs) - self.shortest < _SAME_LENGTH:
            return []
        return [summarise(until(run.log, self.shortest)) for run in self.runs]

    @cached_property
    def common_figures(self) -> Rows:
        """Return the accuracy over the time that all runs have; nothing where all are as long."""
        groups = _side_by_side(self.common) if self.common else {}
        return next((rows for title, rows in groups.items() if title.startswith("accuracy")), [])

    @cached_property
    def warnings(self) -> list[str]:
        """Return what makes the runs less comparable than they look."""
        return [*self._warnings()]

    def _warnings(self) -> Iterator[str]:
        blind = [run.name for run in self.runs if not run.has_truth]
        if blind:
            yield (
                f"No truth in {', '.join(blind)}: lines and figures there are what the vehicle believed, and an error "
                "of its estimate does not show."
            )
        scenarios = {run.log.header.get("scenario") for run in self.runs}
        if len(scenarios) > 1:
            yield "The scenarios differ: each run is judged by its own orders, mission and sea."
        if any(DIGEST in one.key for one in self.differences):
            yield "Files of the simulation are not the same, as their digests tell; the logs do not have what they say."
        if may_differ_unseen([run.log for run in self.runs]):
            yield (
                "What scenario, truth.toml and sensors.toml hold is not in the logs, only what --set laid upon them: "
                "these runs may differ in it."
            )
        if self.common:
            lengths = ", ".join(f"{run.name} {run.length:.1f} s" for run in self.runs)
            yield (
                f"The runs are not as long as each other: {lengths}. Figures are of each whole run; those of the first "
                f"{self.shortest:.1f} s, which all have, stand in a table of their own."
            )
        for run in self.runs:
            if run.summary.get("after_log"):
                yield f"{run.name}: {unlogged(run.summary)}."
            elif run.log.lost:
                yield f"{run.name}: the log is {run.log.lost}."

    def document(self) -> dict[str, Any]:
        """Return all of it for a program: figures are those of summary.json."""
        return {
            "runs": [
                {"name": run.name, **{row[0]: row[1 + i] for row in self.identity}, "summary": _brief(run.summary)}
                for i, run in enumerate(self.runs)
            ],
            "differences": {one.key: one.values for one in self.differences},
            "common_s": self.shortest if self.common else None,
            "common": [_brief(one) for one in self.common] or None,
            "warnings": self.warnings,
        }


def _side_by_side(summaries: Sequence[Summary]) -> dict[str, Rows]:
    """Return the rows of each group of key figures, in the order of the first run that has them."""
    groups = [{_plain(title): dict(rows) for title, rows in key_figures(one).items()} for one in summaries]
    found: dict[str, Rows] = {}
    for title in dict.fromkeys(title for one in groups for title in one):
        own = [one.get(title, {}) for one in groups]
        labels = dict.fromkeys(label for rows in own for label in rows)
        found[title] = [[label, *(rows.get(label, MISSING) for rows in own)] for label in labels]
    return found


def _plain(title: str) -> str:
    """Return the title of a group without what it says of one run; `warnings` says it."""
    return title.removesuffix(", while logged").removesuffix(" by the estimate")


def _brief(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return a summary without its long lists."""
    return {key: value for key, value in summary.items() if key not in _LONG}


def _named(text: Any) -> str:
    return str(text) if text else MISSING
