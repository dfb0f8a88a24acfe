"""The judge of a flight: what happened, by the truth of the plant, and what the vehicle said of it."""

from __future__ import annotations

import enum
import math
from dataclasses import asdict, dataclass, field
from typing import Any

from firmware_py.records.command import AscentStage
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import INTENDED_CAUSES, Cause, Event, EventKind
from firmware_py.records.health import ActuatorFault, SourceFault
from firmware_py.records.order import Mode
from sim_bridge.plant.environment import EnvironmentParams
from sim_bridge.truth_sample import TruthSample

SURFACE = 1.0
"""Less deep than this is the surface, m."""
TOO_DEEP = 3.0
"""A flight may pass the limit by this, m."""
_REST = 60.0
"""A vehicle that has been disarmed for so long, s, and does not rise, does nothing more."""
_RISE = 0.2
_AT_REST = 1.0
"""A vehicle that has been disarmed at the surface for so long, s, is up."""
_SOURCES = (EventKind.SENSOR_SUSPECT, EventKind.SENSOR_LOST)
_CLIMBS = 0.75
"""Of the patience, from the begin of SURFACE: its own clock runs for 120 s and a slow climb; then the weight goes."""
_SINKS_AGAIN = 30.0
"""So long, s, has a vehicle that lies disarmed as "surfaced" to find out that it sinks."""
_WEIGHT = (EventKind.WEIGHT_NOT_RELEASED, EventKind.WEIGHT_SILENT)
_WHY_BELOW = (Cause.SURFACING_LONG.name, Cause.HARDPOINT_HOLDS.name, Cause.HARDPOINT_SILENT.name)
"""Causes that tell an operator that it does not come up: it has tried for so long, or its weight does not go."""
_RULES = (EventKind.MODE_CHANGED, EventKind.RULE_HOLDS, EventKind.RULE_WARNS)


class Ending(enum.Enum):
    """How a flight ended, from the best to the worst."""

    FLOWN = "flown"
    """The mission was flown, and the vehicle came up."""
    UP = "up"
    """A rule brought it up."""
    DROPPED = "dropped"
    """It came up without its drop weight."""
    BELOW = "below"
    """It is below the surface, has released the weight, or tried to come up and says that it does not."""
    LOST = "lost"
    """It is below the surface, with its weight, and does not say why, or says that it has surfaced."""
    DEEP = "deep"
    """It was deeper than the limit by more than `TOO_DEEP`."""
    AGROUND = "aground"
    NOT_FINITE = "not finite"
    """A command was no number."""

    @property
    def unsafe(self) -> bool:
        """Whether it must not be."""
        return self in (Ending.LOST, Ending.DEEP, Ending.AGROUND, Ending.NOT_FINITE)


@dataclass
class Found:
    """What was found in one flight; times in s from its start unless said, depths in m, angles in deg.

    Attributes:
        t_end: when it ended.
        deepest: greatest true depth.
        bottom: least distance from the bottom to the hull's lowest point.
        pitch: greatest true pitch, up or down, from the fault on.
        depth_error: greatest difference of estimated and true depth, from the fault on.
        not_finite: cycles with a command that is no number.
        aground: whether it touched the bottom.
        said: (t, name, fault) of each sensor or actuator that was found faulty.
        rules: (t, cause) of each rule that took hold or warned.
        modes: (t, mode, cause).
        stages: (t, stage) of coming up.
        t_drop: when the weight fell; infinite if it did not.
        t_surfacing: when SURFACE began for the last time; infinite if it never did.
        t_up: since when it has been at the surface; infinite if it is not.
        t_down: since when it has been below; infinite if it is not.
        end_depth: true depth at the end.
        end_estimate: estimated depth at the end.
        end_mode: the mode at the end.
        end_cause: why that mode was entered.
        end_fix: whether a position fix was heard at the end.
    """

    t_end: float = 0.0
    deepest: float = -math.inf
    bottom: float = math.inf
    pitch: float = 0.0
    depth_error: float = 0.0
    not_finite: int = 0
    aground: bool = False
    said: list[tuple[float, str, str]] = field(default_factory=list)
    rules: list[tuple[float, str]] = field(default_factory=list)
    modes: list[tuple[float, str, str]] = field(default_factory=list)
    stages: list[tuple[float, str]] = field(default_factory=list)
    t_drop: float = math.inf
    t_surfacing: float = math.inf
    t_up: float = math.inf
    t_down: float = math.inf
    end_depth: float = math.nan
    end_estimate: float = math.nan
    end_mode: str = ""
    end_cause: str = ""
    end_fix: bool = False

    @property
    def brought_up(self) -> bool:
        """Return whether it surfaced for the last time because a rule asked for it."""
        causes = [cause for _, mode, cause in self.modes if mode == Mode.SURFACE.name]
        return bool(causes) and Cause[causes[-1]] not in INTENDED_CAUSES

    def ending(self, depth_max: float) -> Ending:
        """Return how it ended; `depth_max` is the rule's limit, m."""
        if self.not_finite:
            return Ending.NOT_FINITE
        if self.aground:
            return Ending.AGROUND
        if not self.deepest <= depth_max + TOO_DEEP:
            return Ending.DEEP
        if math.isfinite(self.t_up):
            if math.isfinite(self.t_drop):
                return Ending.DROPPED
            return Ending.UP if self.brought_up else Ending.FLOWN
        if self.end_cause == Cause.SURFACED.name and self.end_mode == Mode.DISARMED.name:
            return Ending.BELOW if self.t_end - self.t_down <= _SINKS_AGAIN else Ending.LOST
        told = any(t >= self.t_surfacing and cause in _WHY_BELOW for t, cause in self.rules)
        return Ending.BELOW if told or math.isfinite(self.t_drop) else Ending.LOST

    def plain(self) -> dict[str, Any]:
        """Return it for JSON, where a number that is not finite is null."""
        return {name: None if value != value or value in _ENDLESS else value for name, value in asdict(self).items()}


_ENDLESS = (math.inf, -math.inf)


class Judge:
    """Sees every cycle of a flight and the truth; `found` is what it has seen, `done` that no more can come.

    Args:
        sea: where the bottom is.
        onset: when the fault begins, s.
        length: of the hull, m.
        height: of the hull, m.
        watch: for so long it is watched once it lies disarmed at the surface, s: it may sink again.
        patience: a vehicle that is not done by then is given up, s; one that still flies its mission, so long after it
            ended that. It may be slow: without DVL it does not learn, is cautious, and goes round once more for a
            waypoint that it has missed in depth. One that begins to come up before then, for the first time or again,
            has three quarters of it from there; and so has one that is coming up again when it is given up, until it is
            at the surface.
    """

    def __init__(
        self,
        sea: EnvironmentParams,
        onset: float,
        length: float,
        height: float,
        watch: float = 0.0,
        patience: float = math.inf,
    ) -> None:
        self.found = Found()
        self.done = False
        self._sea = sea
        self._onset = onset
        self._watch = max(watch, _AT_REST)
        self._patience = self._given_up = patience
        self._half_length, self._half_height = 0.5 * length, 0.5 * height
        self._mode: Mode | None = None
        self._armed = False
        self._rest = (math.inf, math.nan)
        """Since when, and at which depth, it has been disarmed."""

    def see(self, cycle: Cycle, truth: TruthSample) -> None:
        """Take one cycle and the truth at its tick."""
        found, t, eta = self.found, cycle.tick.t, truth.eta
        found.t_end, found.end_depth, found.end_estimate = t, eta.z, cycle.state.eta.z
        found.deepest = max(found.deepest, eta.z)
        reach = self._half_length * abs(math.sin(eta.theta)) + self._half_height * math.cos(eta.theta)
        found.bottom = min(found.bottom, self._sea.bottom_at(eta.x) - eta.z - reach)
        if t >= self._onset:
            found.pitch = max(found.pitch, abs(math.degrees(eta.theta)))
            found.depth_error = max(found.depth_error, abs(cycle.state.eta.z - eta.z))
        applied = cycle.applied
        found.not_finite += not math.isfinite(sum(applied.fins) + applied.n)
        if not truth.drop_weight:
            found.t_drop = min(found.t_drop, t)
        if not eta.z < SURFACE:
            found.t_up, found.t_down = math.inf, min(found.t_down, t)
        else:
            found.t_down = math.inf
            if t >= self._onset:
                found.t_up = min(found.t_up, t)
        for event in cycle.events:
            self._hear(t, event)
        if cycle.mode.mode is not self._mode:
            self._enter(t, cycle)
        found.end_fix = cycle.frame.fix.ok and cycle.frame.fix.age(t) < 3.0
        self.done = self._over(t, eta.z)

    def _hear(self, t: float, event: Event) -> None:
        found, kind = self.found, event.kind
        if kind in _SOURCES:
            found.said.append((t, event.names[0], SourceFault(int(event.numbers[0])).name))
        elif kind is EventKind.ACTUATOR_FAULT:
            found.said.append((t, event.names[0], ActuatorFault(int(event.numbers[0])).name))
        elif kind is EventKind.ASCENT_STAGE:
            found.stages.append((t, AscentStage(int(event.numbers[0])).name))
        elif kind in _WEIGHT:
            found.said.append((t, "drop weight", event.cause.name if event.cause is not Cause.NONE else kind.name))
            if kind is EventKind.WEIGHT_NOT_RELEASED:
                found.rules.append((t, event.cause.name))
        elif kind in _RULES and event.cause not in (*INTENDED_CAUSES, Cause.NONE):
            found.rules.append((t, event.cause.name))

    def _enter(self, t: float, cycle: Cycle) -> None:
        found, mode = self.found, cycle.mode.mode
        self._mode = mode
        self._armed = self._armed or mode is not Mode.DISARMED
        found.modes.append((t, mode.name, cycle.mode.cause.name))
        found.end_mode, found.end_cause = mode.name, cycle.mode.cause.name
        if mode is Mode.SURFACE:
            if t < self._patience:
                self._given_up = max(self._given_up, t + _CLIMBS * self._patience)
            found.t_surfacing = t
        self._rest = (t, self.found.end_depth) if mode is Mode.DISARMED and self._armed else (math.inf, math.nan)

    def _over(self, t: float, depth: float) -> bool:
        since, before = self._rest
        if t >= self._patience and self._mode is Mode.MISSION:
            self._given_up = t + self._patience
        if t >= self._given_up:
            tries = self._mode is Mode.SURFACE and t < self.found.t_surfacing + _CLIMBS * self._patience
            return depth < SURFACE or not tries
        if t < since:
            return False
        if depth < SURFACE:
            return t - since >= self._watch
        if abs(depth - before) > _RISE:
            self._rest = t, depth
            return False
        return t - since >= _REST
