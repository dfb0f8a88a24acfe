"""The sub-commands `study` and `paper`: their options."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from firmware_py.run import options as vehicle
from sternplane.cli.hardware_commands import Lazily

KERNELS = ("firmware_py", "sim_bridge", "sternplane")
"""Whose kernels they need, and identification; a flight needs none of the tools' own."""
_EXAMPLE = "autopilot.estimation.coefficients.turbulence=[0,0.07]"
"""What each study and the paper take, which have vehicles of their own."""


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
    _add_seeds(estimation, "1000:1400", "fewer seeds, same cases")
    _add_leaving(estimation, "autopilot.estimation.coefficients")
    estimation.set_defaults(run=lazily("sternplane.study.command", kernels=KERNELS, draws=True))

    adaptation = studies.add_parser(
        "adaptation",
        help="laws designed from what is learned, beside laws that know the truth",
        description="Flies vehicle files that are wrong, on all cores, with laws designed from the truth, from the "
        "wrong file and from what is learned; judges them by the truth, and leaves report.html, results.json and "
        "the runs. These are some 2,750 flights, five and a half hours of one processor; the short form has some 40 "
        "flights, 5 minutes on two cores. A second start with the same --out goes on where the first was broken off.",
        epilog="Exit status 0 if every target is met, 1 if not (what is missed is named), 2 for bad input.",
    )
    _add_seeds(adaptation, "1000:1040", "one to three seeds of most cases")
    _add_leaving(adaptation, "autopilot, sensors or io")
    adaptation.set_defaults(run=lazily("sternplane.study.adaptation.command", kernels=KERNELS, draws=True))

    tuning = studies.add_parser(
        "tuning",
        help="gains by an optimiser, for the laws that adaptation is compared with",
        description="Searches the gains of PID and of sliding-mode laws on the nominal vehicle, in one process, and "
        "leaves a file for each search, as the adaptation study reads them.",
    )
    vehicle.add_folder(tuning, f"vehicle and autopilot, {vehicle.FOLDER} [npsauv2]", vehicle.CONFIG)
    tuning.add_argument("--out", type=Path, metavar="DIR", help="where they are left [runs/<stamp>]")
    vehicle.add_settings(tuning, "autopilot, vehicle, truth, sensors or io")
    tuning.set_defaults(run=lazily("sternplane.study.tuning.command", kernels=KERNELS))

    safety = studies.add_parser(
        "safety",
        help="every fault at several depths, judged by the truth",
        description="Flies every fault at three onsets with every seed on all cores, judges the flights by the truth, "
        "and leaves report.html, results.json, flights.jsonl and logs. These are 4,788 flights, some 300 h under water "
        "and a day of one processor; the short form has 40 flights, some 2 h under water. A second start with the same "
        "--out goes on where the first was broken off.",
        epilog="Exit status 0 if no flight is unsafe and every target is met, 1 if not (what is missed is named), "
        "2 for bad input.",
    )
    _add_seeds(safety, "1000:1008", "some faults, one onset and seed each")
    safety.add_argument(
        "--trial",
        action="append",
        default=[],
        metavar="TITLE",
        help="this trial alone, as the report names it, such as off:dvl; may be repeated; quiet is a flight "
        "without a fault with each seed; list prints all of them",
    )
    _add_leaving(safety, "autopilot, vehicle, truth, sensors or io")
    safety.set_defaults(run=lazily("sternplane.study.safety.command", kernels=KERNELS, draws=True))

    paper = commands.add_parser(
        "paper",
        help="every experiment of the source paper, flown again",
        description="Repeats the paper's estimation, design and flights, and leaves report.html, results.json and the "
        "figures as PNG files. Takes a few minutes.",
        epilog="Exit status 0 if every EKF row of Table 1 is at or under the paper's, 1 if not, 2 for bad input.",
    )
    paper.add_argument("--out", type=Path, metavar="DIR", help="where to leave them [runs/<stamp>]")
    vehicle.add_settings(paper, "autopilot, sensors or io, of the flights", _EXAMPLE)
    _add_no_report(paper, "results.json, and make no report.html and no figures")
    paper.set_defaults(run=lazily("sternplane.paper.command", kernels=KERNELS, draws=True))


def _add_seeds(study: argparse.ArgumentParser, counted: str, short: str) -> None:
    """Add which seeds are flown, `counted` unless told otherwise, and the form for CI."""
    study.add_argument(
        "--seeds",
        metavar="A:B",
        help=f"seeds A to B - 1 [{counted}]; settings were tuned on seeds below 1000, so figures on them prove nothing",
    )
    study.add_argument("--short", action="store_true", help=f"{short}: the form for CI")


def _add_leaving(study: argparse.ArgumentParser, keys: str) -> None:
    """Add where a study leaves its files, which `keys` may be set, and whether there is a report."""
    study.add_argument("--out", type=Path, metavar="DIR", help="where they are left [runs/<stamp>]")
    vehicle.add_settings(study, keys, _EXAMPLE)
    _add_no_report(study)


def _add_no_report(command: argparse.ArgumentParser, leaves: str = "results.json, and make no report.html") -> None:
    command.add_argument("--no-report", action="store_true", help=f"leave {leaves}")
