"""`sternplane study tuning`: searches the gains of the rivals of the adaptation study, and leaves them as files."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.table import Table

from firmware_py.run.run_folders import run_folder
from sternplane.campaign.files import write
from sternplane.plain_console import PlainConsole
from sternplane.sitl.taken_settings import Takes, taken, told
from sternplane.study.command import refuse_values
from sternplane.study.laid_settings import laid
from sternplane.study.tuning.closed_loop import ClosedLoop
from sternplane.study.tuning.search import (
    BEGIN,
    DURATION,
    GENERATIONS,
    SEARCHES,
    SEEDS,
    SIZE,
    Figures,
    Judge,
    as_toml,
    drawn,
    recorded,
    tuned,
    words,
)

TAKES = Takes(
    ("autopilot", "vehicle", "truth", "sensors", "io"),
    "the tuning study sets course and sea itself; it takes keys of autopilot, vehicle, truth, sensors and io",
    (
        "autopilot.control.law",
        "autopilot.control.adoption.enabled",
        "autopilot.estimation.learning.enabled",
        *sorted({f"autopilot.control.{space.table}" for search in SEARCHES for space in search.spaces}),
    ),
)
_SETS = 10
"""So many sets of gains are flown both ways."""


def command(options: argparse.Namespace) -> int:
    """Search, write a file for each search, and show that both ways of flying rank gains alike; return 0."""
    settings = taken(options.settings, TAKES)
    refuse_values(settings, options.config)
    with laid(settings):
        return _search(run_folder(options.out), options.config, told(settings))


def _search(folder: Path, config: Path, notes: Sequence[str]) -> int:
    """Search gains of a configuration, with settings laid; `notes` stand in each file."""
    console = PlainConsole()
    judge = Judge(config=config)
    shipped = judge.figures(judge.shipped)

    def tell(generation: int, figures: Figures) -> None:
        """Say how far a search is."""
        text = f"{generation + 1} of {GENERATIONS}: {'; '.join(words(figures, shipped))}"
        console.print(text, highlight=False, soft_wrap=True)

    for search in SEARCHES:
        console.print(search.name)
        params = tuned(search, judge, tell)
        comments = (
            f"Found by `sternplane study tuning` on the nominal vehicle of {config.resolve().name!r};",
            "beside the shipped sliding-mode laws:",
            *words(judge.figures(params), shipped),
            *notes,
            f"Track, {BEGIN:g} to {DURATION:g} s, seeds {SEEDS}; differential evolution, {SIZE} x {GENERATIONS}.",
        )
        write(folder / f"{search.name}.toml", as_toml(search, params, comments))
    console.print(_ranking(judge, config))
    console.print(str(folder), highlight=False, soft_wrap=True)
    return 0


def _ranking(judge: Judge, config: Path) -> Table:
    """Fly sets of PID gains whole, and as the search does; return how well the figures agree."""
    search, both = SEARCHES[0], []
    for params in drawn(search, judge.shipped, _SETS):
        with tempfile.TemporaryDirectory() as name:
            whole = ClosedLoop(
                *recorded(Path(name), SEEDS[0], f"\n{as_toml(search, params)}", config), BEGIN
            ).recorded()
        both.append((np.ravel(judge.loops[0].fly(params)), np.ravel(whole)))
    table = Table("figure", "correlation", "of ranks", "greatest difference", box=None)
    found, true = np.array(both).transpose(1, 2, 0)
    for name, a, b in zip(("depth RMS", "stern travel", "heading RMS", "rudder travel"), found, true, strict=True):
        ranks = np.corrcoef(a.argsort().argsort(), b.argsort().argsort())[0, 1]
        off = 100.0 * float(np.max(np.abs(a / b - 1.0)))
        table.add_row(name, f"{np.corrcoef(a, b)[0, 1]:.4f}", f"{ranks:.4f}", f"{off:.2f} %")
    return table
