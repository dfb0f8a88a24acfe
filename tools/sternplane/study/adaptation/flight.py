"""One flight of the adaptation study: a vehicle file that is wrong, a course to follow, and the errors by the truth."""

from __future__ import annotations

import enum
import math
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from firmware_py.marine import wrap
from firmware_py.records.adoption import Refusal, Source
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode
from sim_bridge.truth_sample import TruthSample
from sternplane.logs.tracking import Array
from sternplane.sitl import simulation_recorder
from sternplane.sitl.flight import FlightRequest, fly, prepare
from sternplane.sitl.taken_settings import beside
from sternplane.study.laid_settings import settings_now
from sternplane.study.setups import CONFIG, starts
from sternplane.study.wrong_vehicle import Factors, coefficients, overlay

LONG_ERROR = 10.0
"""An error that is too large for so long, s, is a failure."""
DEPTH_MOST, HEADING_MOST = 2.0, math.radians(30.0)
"""What is too large, m and rad."""
FIRST_MINUTE = 60.0


class Design(enum.Enum):
    """What the laws of a flight are designed from."""

    ORACLE = enum.auto()
    """The truth."""
    FIXED = enum.auto()
    """The wrong vehicle file; the filter runs, and nobody reads it."""
    ADAPTIVE = enum.auto()
    """The wrong vehicle file, and what is learned."""


class Course(NamedTuple):
    """What is flown: the text of a scenario with {adoption} in it, and from when its end figures count, s."""

    name: str
    scenario: str
    settled: float


class Errors(NamedTuple):
    """The errors of a flight over its ticks; not a number while it is disarmed or in MANUAL.

    Attributes:
        t: s, (ticks,).
        depth: true depth minus reference, m, (ticks,).
        heading: true heading minus reference, rad, (ticks,).
        travel: way that all fins have moved, over the number of fins, rad, (ticks,).
        adopted: when both laws were designed from learned values alone, s; infinite if never.
        completed: whether the scenario was.
    """

    t: Array
    depth: Array
    heading: Array
    travel: Array
    adopted: float
    completed: bool

    @property
    def failed(self) -> bool:
        """Whether the flight was not completed, or an error was too large for too long after the first minute."""
        late, step = self.t > FIRST_MINUTE, self.t[1] - self.t[0]
        large = (np.abs(self.depth) > DEPTH_MOST) | (np.abs(self.heading) > HEADING_MOST)
        return not self.completed or bool(_longest(large & late) * step > LONG_ERROR)

    def figures(self, begin: float, end: float = math.inf) -> dict[str, float]:
        """Return RMS and greatest errors between two times, m and deg, and the fins' travel, deg/s.

        The heading's RMS is that about its mean: a bias of the AHRS is no law's doing.
        """
        part = (self.t >= begin) & (self.t < end) & np.isfinite(self.depth)
        depth, heading, t = self.depth[part], np.degrees(self.heading[part]), self.t[part]
        if len(t) < 2:
            return dict.fromkeys(("depth", "heading", "depth_most", "heading_most", "travel"), math.nan)
        travel = np.degrees(self.travel[part])
        return {
            "depth": float(np.sqrt(np.mean(depth**2))),
            "heading": float(np.std(heading)),
            "depth_most": float(np.max(np.abs(depth))),
            "heading_most": float(np.max(np.abs(heading))),
            "travel": float((travel[-1] - travel[0]) / (t[-1] - t[0])),
        }


class Witness:
    """Takes down what `Errors` needs."""

    done = False

    def __init__(self) -> None:
        self._rows: list[tuple[float, float, float]] = []
        self._fins: tuple[float, ...] = ()
        self._travel: list[float] = []
        self.adopted = math.inf

    def see(self, cycle: Cycle, truth: TruthSample) -> None:
        """Take one cycle and the truth at its tick."""
        t, reference, eta = cycle.tick.t, cycle.reference, truth.eta
        steered = cycle.mode.mode not in (Mode.DISARMED, Mode.MANUAL, Mode.SURFACE)
        errors = (eta.z - reference.z_d, wrap(eta.psi - reference.psi_d)) if steered else (math.nan, math.nan)
        self._rows.append((t, *errors))
        fins = cycle.applied.fins
        moved = sum(abs(a - b) for a, b in zip(fins, self._fins, strict=True)) / len(fins) if self._fins else 0.0
        self._fins = fins
        self._travel.append((self._travel[-1] if self._travel else 0.0) + moved)
        laws = cycle.adopted.depth, cycle.adopted.heading
        if all(law.source is Source.LEARNED and law.refusal in (Refusal.NONE, Refusal.BOUND) for law in laws):
            self.adopted = min(self.adopted, t)

    def errors(self, completed: bool) -> Errors:
        """Return what was seen."""
        t, depth, heading = np.array(self._rows).T
        return Errors(t, depth, heading, np.array(self._travel), self.adopted, completed)


def flown(
    course: Course,
    seed: int,
    wrong: float,
    design: Design,
    faults: tuple[str, ...] = (),
    witness: Witness | None = None,
) -> Errors:
    """Fly a course with a vehicle file whose ten coefficients are off by `wrong`, to sides that the seed draws.

    `faults` are as the command line takes them; a `witness` of one's own sees every cycle.
    """
    factors = starts(seed, wrong) if design is not Design.ORACLE else {}
    return flown_as(course, seed, coefficients(factors), design is Design.ADAPTIVE, "", faults, witness)


def flown_as(
    course: Course,
    seed: int,
    factors: Factors,
    adoption: bool,
    laws: str = "",
    faults: tuple[str, ...] = (),
    witness: Witness | None = None,
    config: Path = CONFIG,
) -> Errors:
    """Fly a course.

    Args:
        course: what is flown.
        seed: of the noise.
        factors: make the vehicle file wrong.
        adoption: whether the laws are designed from what is learned.
        laws: tables of the autopilot's configuration that are not as shipped, TOML.
        faults: as the command line takes them.
        witness: one's own, which sees every cycle; None makes one.
        config: the vehicle's folder.
    """
    witness = witness or Witness()
    text = course.scenario.format(adoption=str(adoption).lower())
    return witness.errors(fly_seen(text + laws + overlay(factors), seed, witness, faults, config))


def fly_seen(
    scenario: str,
    seed: int,
    witness: simulation_recorder.Witness,
    faults: tuple[str, ...] = (),
    config: Path = CONFIG,
) -> bool:
    """Fly the text of a scenario before a witness, without a log, and return whether it was completed."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "study.toml"
        path.write_text(scenario, encoding="utf-8")
        settings = beside(scenario, settings_now())
        request = FlightRequest(scenario=str(path), config=config, seed=seed, faults=faults, settings=settings)
        flight = prepare(request, {})
        outcome = fly(flight, None, witness=witness)
        if outcome.reason == "interrupted":
            raise KeyboardInterrupt
        return outcome.completed


def _longest(flags: Array) -> int:
    """Return the greatest number of flags in a row."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    return int(np.max(edges[1::2] - edges[::2], initial=0))
