"""The sub-commands `study` and `paper`: their options."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from firmware_py.run import options as vehicle
from sternplane.cli.hardware_commands import Lazily


def add_studies(commands: Any, lazily: Lazily) -> None:
    """Add `study` and `paper` to the sub-commands."""
    study = commands.add_parser("study", help="how well something is done, over many seeds, beside what is possible")
    studies = study.add_subparsers(required=True, metavar="STUDY")
    estimation = studies.add_parser(
        "estimation",
        help="the coefficient filter beside the Cramér-Rao bound",
        description="Flies and judges every case on all cores, and leaves report.html, results.json and the runs. A "
        "second start with the same --out goes on where the first was broken off.",
        epilog="Exit status 0 if every target is met, 1 if not (what is missed is named), 2 for bad input.",
    )
    estimation.add_argument(
        "--seeds", metavar="A:B", help="seeds A to B - 1; tune below 1000 [1000:1400, for the figures that count]"
    )
    estimation.add_argument("--short", action="store_true", help="fewer seeds, same cases: the form for CI")
    estimation.add_argument("--out", type=Path, metavar="DIR", help="where they are left [runs/<stamp>]")
    vehicle.add_settings(estimation, "autopilot.estimation.coefficients")
    _add_no_report(estimation)
    estimation.set_defaults(run=lazily("sternplane.study.command", draws=True))

    adaptation = studies.add_parser(
        "adaptation",
        help="laws designed from what is learned, beside laws that know the truth",
        description="Flies vehicle files that are wrong, on all cores, with laws designed from the truth, from the "
        "wrong file and from what is learned; judges them by the truth, and leaves report.html, results.json and "
        "the runs. A second start with the same --out goes on where the first was broken off.",
        epilog="Exit status 0 if every target is met, 1 if not (what is missed is named), 2 for bad input.",
    )
    adaptation.add_argument(
        "--seeds", metavar="A:B", help="seeds A to B - 1; tune below 1000 [1000:1040, for the figures that count]"
    )
    adaptation.add_argument("--short", action="store_true", help="one or two seeds, same cases: the form for CI")
    adaptation.add_argument("--out", type=Path, metavar="DIR", help="where they are left [runs/<stamp>]")
    vehicle.add_settings(adaptation, "autopilot, sensors or io")
    _add_no_report(adaptation)
    adaptation.set_defaults(run=lazily("sternplane.study.adaptation.command", draws=True))

    tuning = studies.add_parser(
        "tuning",
        help="gains by an optimiser, for the laws that adaptation is compared with",
        description="Searches the gains of PID and of sliding-mode laws on the nominal vehicle, in one process, and "
        "leaves a file for each search, as the adaptation study reads them.",
    )
    tuning.add_argument(
        "--config", type=Path, default=vehicle.CONFIG, metavar="DIR", help="vehicle and autopilot [configs/npsauv2]"
    )
    tuning.add_argument("--out", type=Path, metavar="DIR", help="where they are left [runs/<stamp>]")
    vehicle.add_settings(tuning, "autopilot, vehicle, truth, sensors or io")
    tuning.set_defaults(run=lazily("sternplane.study.tuning.command"))

    safety = studies.add_parser(
        "safety",
        help="every fault at several depths, judged by the truth",
        description="Flies every fault at three onsets with every seed on all cores, judges the flights by the truth, "
        "and leaves report.html, results.json, flights.jsonl and logs. These are 4,084 flights, some 260 h under water "
        "and a day of one processor; the short form has 35 flights, some 2 h under water. A second start with the same "
        "--out goes on where the first was broken off.",
        epilog="Exit status 0 if no flight is unsafe and every target is met, 1 if not (what is missed is named), "
        "2 for bad input.",
    )
    safety.add_argument(
        "--seeds", metavar="A:B", help="seeds A to B - 1; tune below 1000 [1000:1008, for the figures that count]"
    )
    safety.add_argument("--short", action="store_true", help="some faults, one onset and seed each: the form for CI")
    safety.add_argument(
        "--trial",
        action="append",
        default=[],
        metavar="TITLE",
        help="this trial alone, as the report names it, such as off:dvl, without quiet flights; may be repeated",
    )
    safety.add_argument("--out", type=Path, metavar="DIR", help="where they are left [runs/<stamp>]")
    vehicle.add_settings(safety, "autopilot, vehicle, truth, sensors or io")
    _add_no_report(safety)
    safety.set_defaults(run=lazily("sternplane.study.safety.command", draws=True))

    paper = commands.add_parser(
        "paper",
        help="every experiment of the source paper, flown again",
        description="Repeats the paper's estimation, design and flights, and leaves report.html, results.json and the "
        "figures as PNG files. Takes a few minutes.",
        epilog="Exit status 0 if every EKF row of Table 1 is at or under the paper's, 1 if not, 2 for bad input.",
    )
    paper.add_argument("--out", type=Path, metavar="DIR", help="where to leave them [runs/<stamp>]")
    vehicle.add_settings(paper, "autopilot, sensors or io, of the flights")
    _add_no_report(paper, "results.json, and make no report.html and no figures")
    paper.set_defaults(run=lazily("sternplane.paper.command", draws=True))


def _add_no_report(command: argparse.ArgumentParser, leaves: str = "results.json, and make no report.html") -> None:
    command.add_argument("--no-report", action="store_true", help=f"leave {leaves}")
