"""Learning manoeuvres in flight: duration, reduced grip of the laws, and limits at which a manoeuvre waits.

Depth and course at the beginning are the base. The laws go on holding them with a reduced grip, so that they do not
cancel the excitation. Where the vehicle is about to leave the limits the manoeuvre waits, with the laws alone at full
grip, until the vehicle is well inside; then it resumes where it stopped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from firmware_py.guidance.excitation import Sides, sides
from firmware_py.marine import body_to_ned, euler_rates, wrap
from firmware_py.params import param
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import Cause, Event, EventKind, event
from firmware_py.records.mission import Manoeuvre, ManoeuvreKind
from firmware_py.records.order import Setpoint


@dataclass(frozen=True, slots=True)
class ManoeuvreParams:
    """The limits of learning manoeuvres, and the grip of the laws meanwhile. All ours.

    A firm grip cancels the excitation: with the PRBS of `Manoeuvre` the mean relative sigma of the ten coefficients
    after 60 s (`sternplane.identification.excitation`) is 1.12 % at grip 1, 0.71 at 0.6, 0.50 at 0.3, 0.46 at 0.2 and
    at 0; below 0.2 the vehicle reaches the limits and waits.
    """

    grip: float = param(
        0.3, low=0.0, high=1.0, doc="Share of the laws' fin angles that is given meanwhile.", mav="GRIP"
    )
    depth_band: float = param(
        5.0,
        unit="m",
        low=0.5,
        high=100.0,
        doc="A learning manoeuvre stays so near to the depth that it began at.",
        mav="BAND",
    )
    depth_margin: float = param(
        5.0,
        unit="m",
        low=0.0,
        high=100.0,
        doc="A learning manoeuvre keeps so far off the surface and depth_max.",
        mav="Z_MARGIN",
    )
    altitude_margin: float = param(
        5.0, unit="m", low=0.0, high=100.0, doc="A learning manoeuvre keeps so far above altitude_min.", mav="ALT_MARG"
    )
    pitch_max: float = param(
        25.0, unit="deg", low=1.0, high=60.0, doc="Steepest pitch of a learning manoeuvre, up and down.", mav="PITCH"
    )
    depth_lead: float = param(
        5.0, unit="s", low=0.0, high=20.0, doc="How far ahead depth and altitude are judged.", mav="Z_LEAD"
    )
    pitch_lead: float = param(
        2.0, unit="s", low=0.0, high=20.0, doc="How far ahead in time pitch is judged.", mav="P_LEAD"
    )
    resume: float = param(
        0.5, low=0.0, high=1.0, doc="A manoeuvre that paused goes on inside this share of its limits.", mav="RESUME"
    )
    patience: float = param(60.0, unit="s", low=1.0, high=1e4, doc="A wait as long as this ends it.", mav="PATIENCE")


class Excitation(NamedTuple):
    """Fin angles (rad) added to the share `grip` of the laws' angles."""

    delta_s: float
    delta_r: float
    grip: float


NO_EXCITATION = Excitation(0.0, 0.0, 1.0)


class ManoeuvreProgress(NamedTuple):
    """Progress of a manoeuvre: steps flown, steps of this wait and of all waits, and the sides of the fins."""

    kind: ManoeuvreKind
    flown: int
    waiting: int
    waited: int
    sides: Sides


class ManoeuvreMemory(NamedTuple):
    """What is remembered: the manoeuvre in progress, and the one that ended in this tick and awaits its report."""

    progress: ManoeuvreProgress | None
    over: ManoeuvreKind | None


class ManoeuvreLimit(NamedTuple):
    """The limit at which a manoeuvre waits, as cause of an event with its numbers."""

    cause: Cause
    numbers: tuple[float, ...]


class ManoeuvreGuidance:
    """The manoeuvre in progress, if any. `events` are those of the last update.

    `depth_max` and `altitude_min` (m) are the supervisor's limits: the manoeuvre waits well before they end it.
    """

    def __init__(self, params: ManoeuvreParams, depth_max: float = math.inf, altitude_min: float = 0.0) -> None:
        self._params = params
        self._deepest, self._lowest = depth_max - params.depth_margin, altitude_min
        self._memory: ManoeuvreProgress | None = None
        self._over: ManoeuvreKind | None = None
        self.events: tuple[Event, ...] = ()

    @property
    def begun(self) -> bool:
        """Whether a manoeuvre is in progress."""
        return self._memory is not None

    def update(self, manoeuvre: Manoeuvre, base: Setpoint, state: StateEstimate, dt: float) -> Excitation:
        """Return the excitation of this tick. The first call begins the manoeuvre; after the last `begun` is False.

        Args:
            manoeuvre: the same one until it is over.
            base: depth and course to hold.
            state: finite in position, attitude and velocity.
            dt: step, s.
        """
        self.events = ()
        if self._memory is None:
            self._add_event(manoeuvre, EventKind.MANOEUVRE_BEGUN, numbers=(manoeuvre.duration, base.z_d))
        course = self._memory or ManoeuvreProgress(manoeuvre.kind, 0, 0, 0, Sides(1.0, 1.0))
        breach = self._breach(base.z_d, state, self._params.resume if course.waiting else 1.0)
        if breach is not None:
            return self._wait(manoeuvre, course, breach, dt)
        if course.waiting:
            self._add_event(manoeuvre, EventKind.MANOEUVRE_RESUMED)
        at = sides(manoeuvre, course.flown, dt, course.sides, state.eta.theta, wrap(state.eta.psi - base.psi_d))
        self._memory = course._replace(flown=course.flown + 1, waiting=0, sides=at)
        if (course.flown + 1) * dt >= manoeuvre.duration:
            self.reset()
            self._add_event(manoeuvre, EventKind.MANOEUVRE_DONE, numbers=(manoeuvre.duration, course.waited * dt))
        return Excitation(manoeuvre.delta_s * at.s, manoeuvre.delta_r * at.r, self._params.grip)

    def reset(self) -> None:
        """End the manoeuvre: the next one begins anew."""
        if self._memory:
            self._over = self._memory.kind
        self._memory = None

    def report_events(self, report: tuple[Event, ...]) -> tuple[Event, ...]:
        """Return the report on what a manoeuvre taught that has ended since this was last asked; see `Learned`."""
        over, self._over = self._over, None
        return tuple(replace(event, manoeuvre=over) for event in report) if over is not None else ()

    def freeze(self) -> ManoeuvreMemory:
        """Return the whole memory."""
        return ManoeuvreMemory(self._memory, self._over)

    def thaw(self, memory: ManoeuvreMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory, self._over = memory

    def _wait(self, manoeuvre: Manoeuvre, course: ManoeuvreProgress, breach: ManoeuvreLimit, dt: float) -> Excitation:
        if not course.waiting:
            self._add_event(manoeuvre, EventKind.MANOEUVRE_WAITS, breach.cause, breach.numbers)
        self._memory = course._replace(waiting=course.waiting + 1, waited=course.waited + 1)
        if (course.waiting + 1) * dt >= self._params.patience:
            self.reset()
            flown = course.flown * dt
            self._add_event(manoeuvre, EventKind.MANOEUVRE_GIVEN_UP, breach.cause, (flown, *breach.numbers))
        return NO_EXCITATION

    def _breach(self, base: float, state: StateEstimate, share: float) -> ManoeuvreLimit | None:
        """Return the limit, drawn in to that share, that the vehicle is beyond or about to pass; None if there is none.

        An altitude that is not known breaks none.
        """
        params = self._params
        _, _, z, phi, theta, psi = state.eta
        u, v, w, p, q, r = state.nu
        way = params.depth_lead * body_to_ned(phi, theta, psi, u, v, w)[2]
        top = base + share * (max(base - params.depth_band, params.depth_margin) - base)
        floor = base + share * (min(base + params.depth_band, self._deepest) - base)
        if max(z, z + way) > floor or min(z, z + way) < top:
            return ManoeuvreLimit(Cause.MANOEUVRE_DEPTH, (z, z + way, top, floor))
        lowest = self._lowest + (2.0 - share) * params.altitude_margin
        if min(state.altitude, state.altitude - way) < lowest:
            return ManoeuvreLimit(Cause.MANOEUVRE_ALTITUDE, (state.altitude, state.altitude - way, lowest))
        steepest = share * params.pitch_max
        soon = theta + params.pitch_lead * euler_rates(phi, theta, p, q, r)[1]
        if max(abs(theta), abs(soon)) > steepest:
            return ManoeuvreLimit(Cause.MANOEUVRE_PITCH, (theta, soon, steepest))
        return None

    def _add_event(
        self, manoeuvre: Manoeuvre, kind: EventKind, cause: Cause = Cause.NONE, numbers: tuple[float, ...] = ()
    ) -> None:
        self.events = (*self.events, event(kind, cause, numbers, manoeuvre=manoeuvre.kind))
