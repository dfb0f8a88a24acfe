"""The flights of the campaign: every trial at every onset with every seed, and quiet ones for false alarms."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.error_text import quoted
from firmware_py.run.usage_error import UsageError
from sim_bridge.faults.catalogue import likely_targets
from sternplane.study.safety import mission_trials, other_vehicle_trials, sensor_trials, vehicle_trials
from sternplane.study.safety.mission import QUIET
from sternplane.study.safety.trial import Group, Trial

_TABLES = (sensor_trials, vehicle_trials, mission_trials, other_vehicle_trials)
GROUPS: tuple[Group, ...] = tuple(group for table in _TABLES for group in table.GROUPS)
TRIALS = {trial.title: trial for group in GROUPS for trial in group.trials}
LEFT_OUT = {
    "jump:clock": "needs ticks that keep the time of a clock: --pace realtime, a flight of minutes each",
}
"""Kinds of the catalogue that no trial has, and why."""
QUIET_FLIGHTS = "quiet"
"""What stands for the flights without a fault among the titles of trials."""
LISTED = (*TRIALS, QUIET_FLIGHTS)
SEEDS = 8
"""How many seeds, unless told otherwise."""
_QUIET_FLIGHTS = 100
_QUIET_SHORT, _SHORT_FLIGHTS = 150.0, 2
_REPLAYS, _SHORT_REPLAYS = 30, 2
_TURNS, _LEARNING = 4, 2
"""Of so many seeds so many learn, with eddies and without; the others fly by the vehicle file, for half the time."""


class Job(NamedTuple):
    """One flight.

    Attributes:
        trial: its title; "" for a quiet flight.
        onset: its number; -1 for a quiet flight.
        seed: of everything random; odd ones have eddies of 0.1 m/s.
        duration: of a quiet flight, s.
        replay: whether it is replayed afterwards.
        keep: whether its log is kept if nothing is wrong.
    """

    trial: str
    onset: int
    seed: int
    duration: float = 0.0
    replay: bool = False
    keep: bool = False

    @property
    def key(self) -> str:
        """Return what names the flight in the file of results."""
        return f"{self.trial or f'quiet, {self.duration:g} s'} / {self.onset} / {self.seed}"

    @property
    def eddies(self) -> float:
        """Return the turbulence, 1 sigma, m/s."""
        return 0.1 * (self.seed % 2)

    @property
    def learning(self) -> bool:
        """Return whether the coefficients are learned in it."""
        return self.seed % _TURNS < _LEARNING or not self.trial

    @property
    def file(self) -> str:
        """Return the name of its log."""
        return f"{TRIALS[self.trial].name if self.trial else 'quiet'}.{self.onset}.{self.seed}.mcap"


def trials_of(titles: Sequence[str]) -> list[Trial]:
    """Return the trials of these titles, without the quiet flights.

    Raises:
        UsageError: there is none of a title; it says which is meant probably.
    """
    for title in titles:
        if title not in LISTED:
            kind, _, target = title.partition(":")
            likely = [f"{kind}:{one}" for one in likely_targets(kind, target)] if target else []
            near = [one for one in likely if one in TRIALS] or difflib.get_close_matches(title, LISTED, n=3)
            meant = f"did you mean {' or '.join(map(quoted, near))}?" if near else "--trial list names them all"
            raise UsageError(f"--trial {quoted(title)}: is unknown; {meant}")
    return [TRIALS[title] for title in dict.fromkeys(titles) if title != QUIET_FLIGHTS]


def jobs(seeds: range, short: bool, titles: Sequence[str] = ()) -> list[Job]:
    """Return every flight, seed by seed, so that a campaign that was broken off has all faults.

    With `titles` those of some trials alone; `QUIET_FLIGHTS` among them stands for a quiet flight with each seed.
    """
    chosen = trials_of(titles)
    if short:
        found = _short(seeds, chosen if titles else [trial for trial in TRIALS.values() if trial.short])
        count, duration = _SHORT_FLIGHTS, _QUIET_SHORT
    else:
        found = _full(seeds, chosen if titles else [*TRIALS.values()])
        count, duration = min(_QUIET_FLIGHTS, -(-_QUIET_FLIGHTS * len(seeds) // SEEDS)), QUIET
    if titles:
        count = len(seeds) if QUIET_FLIGHTS in titles else 0
    found += [Job("", -1, seeds.start + k, duration, keep=short or k == 0) for k in range(count)]
    every = max(1, len(found) // (_SHORT_REPLAYS if short else _REPLAYS))
    return [job._replace(replay=i % every == every - 1) for i, job in enumerate(found)]


def _full(seeds: range, trials: Sequence[Trial]) -> list[Job]:
    return [
        Job(trial.title, onset, seed, keep=seed == seeds.start)
        for seed in seeds
        for trial in trials
        for onset in trial.onsets
    ]


def _short(seeds: range, trials: Sequence[Trial]) -> list[Job]:
    """Return each trial at one onset: shallow, in the middle, deep, and so on."""
    return [
        Job(trial.title, trial.onsets[i % len(trial.onsets)], seeds[i % len(seeds)], keep=True)
        for i, trial in enumerate(trials)
    ]
