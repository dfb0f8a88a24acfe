"""The flights of the campaign: every trial at every onset with every seed, and quiet ones for false alarms."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from firmware_py.error_text import quoted
from firmware_py.run.usage_error import UsageError
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
    """Return the trials of these titles.

    Raises:
        UsageError: there is none of a title; it says which is meant probably.
    """
    for title in titles:
        if title not in TRIALS:
            near = difflib.get_close_matches(title, TRIALS, n=3)
            meant = f"did you mean {' or '.join(map(quoted, near))}?" if near else "--trial list names them all"
            raise UsageError(f"--trial {quoted(title)}: is unknown; {meant}")
    return [TRIALS[title] for title in dict.fromkeys(titles)]


def jobs(seeds: range, short: bool, titles: Sequence[str] = ()) -> list[Job]:
    """Return every flight, seed by seed, so that a campaign that was broken off has all faults.

    With `titles` those of some trials alone, without quiet flights.
    """
    chosen = trials_of(titles)
    found = list(_short(seeds, chosen)) if short else list(_full(seeds, chosen))
    every = max(1, len(found) // (_SHORT_REPLAYS if short else _REPLAYS))
    return [job._replace(replay=i % every == every - 1) for i, job in enumerate(found)]


def _full(seeds: range, chosen: Sequence[Trial]) -> Iterator[Job]:
    for seed in seeds:
        for trial in chosen or TRIALS.values():
            for onset in trial.onsets:
                yield Job(trial.title, onset, seed, keep=seed == seeds.start)
    if chosen:
        return
    for k in range(min(_QUIET_FLIGHTS, -(-_QUIET_FLIGHTS * len(seeds) // SEEDS))):
        yield Job("", -1, seeds.start + k, QUIET, keep=k == 0)


def _short(seeds: range, chosen: Sequence[Trial]) -> Iterator[Job]:
    """These trials, or those of the short form, each at one onset: shallow, in the middle, deep, and so on."""
    for i, trial in enumerate(chosen or [trial for trial in TRIALS.values() if trial.short]):
        yield Job(trial.title, trial.onsets[i % len(trial.onsets)], seeds[i % len(seeds)], keep=True)
    if chosen:
        return
    for k in range(_SHORT_FLIGHTS):
        yield Job("", -1, seeds.start + k, _QUIET_SHORT, keep=True)
