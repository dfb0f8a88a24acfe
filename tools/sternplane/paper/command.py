"""`sternplane paper`."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

from rich.table import Table

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.params import load
from firmware_py.run.run_folders import run_folder
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.truth_file import read_truth
from sternplane.paper import control, design, drawings, estimation, figures
from sternplane.paper.page import page
from sternplane.paper.printed import TABLE_1
from sternplane.paper.progress import ExperimentProgress
from sternplane.paper.tables import percent
from sternplane.plain_console import PlainConsole
from sternplane.sitl.flight import CONFIG, FlightRequest, prepare
from sternplane.sitl.taken_settings import Takes, plain, taken

_FLIGHT = 130.0
"""Vehicle time of a flight, s."""
TAKES = Takes(
    ("autopilot", "sensors", "io"),
    "the paper says vehicle and sea; its flights take keys of autopilot, sensors and io",
    ("autopilot.control.law",),
)
_PARTS = 3
"""Of the estimation, as it tells them."""


def command(options: argparse.Namespace) -> int:
    """Do every experiment and write the report; return 1 if an EKF row is above the paper's, or a flight failed."""
    settings = taken(options.settings, TAKES)
    if settings:  # what no vehicle can fly with is refused before anything is computed
        for scenario in control.SCENARIOS.values():
            prepare(FlightRequest(scenario, settings=settings), {})
    folder = run_folder(options.out)
    truth = read_truth(CONFIG / "truth.toml")
    vehicle: Vehicle = load(Vehicle, read_toml(CONFIG / "vehicle.toml"), str(CONFIG / "vehicle.toml"))
    who = {"fig9": tuple(figures.BY), "fig10": (*figures.BY, control.IDEAL)}
    total = (_PARTS + 2) * ExperimentProgress.REST + sum(map(len, who.values())) * _FLIGHT
    try:
        with ExperimentProgress(total, PlainConsole(stderr=True)) as steps:
            found = estimation.estimate(truth, vehicle, steps.done)
            by_whom = estimates(found, vehicle)
            rows = design.compare(vehicle, by_whom)
            made = control.vehicles(folder / "vehicles", by_whom)
            flown: dict[str, dict[str, control.StepFlight]] = {}
            for name, scenario in control.SCENARIOS.items():
                flown[name] = {}
                for one in who[name]:
                    words = f"{scenario}, {one}"
                    steps.begin(words)
                    place = folder / "flights" / f"{name}-{one}"
                    flown[name][one] = control.fly_step(scenario, made[one], place, steps.watch, settings)
                    steps.done(words, _FLIGHT)
            steps.begin("the figures")
            drawn = [] if options.no_report else figures.all_figures(found, vehicle, flown)
            text = "" if options.no_report else page(found, rows, flown, drawn, settings)
            files = _leave(folder, drawn, text, {"settings": plain(settings), **_results(found, rows, flown)}, steps)
    except control.FlightError as error:
        print(f"sternplane: {error}", file=sys.stderr)
        return 1
    console = PlainConsole()
    console.print(_table(found))
    console.print(
        "The paper's SMO has a constant gain: in steady motion it rests on a hyperplane of coefficients, and the start "
        "says where on it. The report shows that, and the SMO whose gain the regressor weights.",
        highlight=False,
        soft_wrap=True,
    )
    for path in files:
        console.print(f"  {path}", highlight=False, soft_wrap=True)
    return 0 if estimation.under(found.learned["ekf"], "ekf") else 1


def estimates(found: estimation.Estimation, vehicle: Vehicle) -> dict[str, dict[str, float]]:
    """Return the values of the coefficients, by estimator and name."""
    learned = {who: found.learned[who].values[-1].tolist() for who in control.LEARNED}
    true = [getattr(vehicle.coefficients, name) for name in TEN]
    return {who: dict(zip(TEN, values, strict=True)) for who, values in {**learned, "truth": true}.items()}


def _results(
    found: estimation.Estimation, rows: list[design.Comparison], flown: dict[str, dict[str, control.StepFlight]]
) -> dict[str, Any]:
    return {
        **estimation.document(found),
        "equations": design.document(rows),
        **{name: {who: one.figures for who, one in by.items()} for name, by in flown.items()},
    }


def _leave(
    folder: Path, drawn: list[figures.Figure], text: str, results: dict[str, Any], steps: ExperimentProgress
) -> list[Path]:
    """Write the files, no report where `text` is empty, and return their places.

    Raises:
        LogError: the folder cannot be written.
    """
    try:
        pictures = [drawings.draw(figure, folder) for figure in drawn]
        steps.done("the figures")
        document = json.dumps(_plain(results), indent=2, ensure_ascii=False, allow_nan=False)
        written = {"report.html": text, "results.json": f"{document}\n"}
        files = {folder / name: content for name, content in written.items() if content}
        for path, content in files.items():
            write_atomically(path, content.encode())
    except OSError as error:
        raise LogError(f"{folder}: the report cannot be written ({error.strerror}); choose another --out") from None
    steps.done("the report")
    return [*files, *pictures]


def _plain(value: Any) -> Any:
    """Replace what is not finite by None: an observer may diverge, and JSON has no such number."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _table(found: estimation.Estimation) -> Table:
    table = Table(title="Table 1: steady-state error, %", title_justify="left", box=None, padding=(0, 2))
    for head in ("", "EKF", "paper", "SMO", "paper", "SMO, weighted, PRBS"):
        table.add_column(head, justify="right" if head else "left")
    for name in TEN:
        ekf, smo, prbs = (found.learned[who].errors[name] for who in ("ekf", "smo", "smo_prbs"))
        paper = (f"{TABLE_1[who][name]:g}" for who in ("ekf", "smo"))
        table.add_row(name, percent(ekf), next(paper), percent(smo), next(paper), percent(prbs))
    return table
