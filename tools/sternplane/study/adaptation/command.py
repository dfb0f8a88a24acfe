"""`sternplane study adaptation`: flies wrong vehicle files with adoption and without, beside the truth."""

from __future__ import annotations

import argparse

from sternplane.sitl.taken_settings import Takes
from sternplane.study.adaptation import other_wrong, rivals, steps, straight
from sternplane.study.adaptation.cases import CASES
from sternplane.study.adaptation.damage import DAMAGE_CASES
from sternplane.study.adaptation.navigation import NAVIGATION_CASES
from sternplane.study.command import run_study
from sternplane.study.rows import Study

SEEDS = 40
"""How many seeds, unless told otherwise."""
ADAPTATION = Study(
    "Adaptation study",
    "What a vehicle gains whose laws are designed from what it learns, beside one whose laws know the truth.",
    (*CASES, *DAMAGE_CASES, *NAVIGATION_CASES, *rivals.CASES, *other_wrong.CASES, *steps.CASES, *straight.CASES),
)

TAKES = Takes(
    ("autopilot", "sensors", "io"),
    "the adaptation study sets vehicle, truth and sea itself; it takes keys of autopilot, sensors and io",
    ("autopilot.control.law", "autopilot.control.adoption.enabled"),
)


def command(options: argparse.Namespace) -> int:
    """Run the study; return 0 if every target is met, 1 if one is missed."""
    return run_study(ADAPTATION, options, SEEDS, TAKES)
