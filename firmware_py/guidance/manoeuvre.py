"""Learning manoeuvres in flight: how long, how firmly the laws hold meanwhile, and where the manoeuvre has to wait.

It is flown on the spot: depth and course of its beginning are its base, and the laws go on holding them, more softly,
so that they do not undo what the fins do. Where the boat is about to leave the limits the manoeuvre waits, with the
laws alone at full strength, until they have brought it well inside. It then goes on where it stopped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.guidance.excitation import Sides, sides
from firmware_py.marine import body_to_ned, euler_rates, wrap
from firmware_py.params import param
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.order import Kind, Manoeuvre, Setpoint


@dataclass(frozen=True, slots=True)
class ManoeuvreParams:
    """The limits of learning manoeuvres, and how firmly the laws hold meanwhile. All ours.

    A firm hold undoes the excitation: with the PRBS of `Manoeuvre` the mean relative sigma of the ten coefficients
    after 60 s (`sternplane.identification.excitation`) is 1.12 % at grip 1, 0.71 at 0.6, 0.50 at 0.3, 0.46 at 0.2 and
    at 0; below 0.2 the boat runs into the limits and waits.
    """

    grip: float = param(
        0.3, low=0.0, high=1.0, doc="Share of the laws' fin angles that is given meanwhile.", mav="GRIP"
    )
    depth_band: float = param(
        5.0, unit="m", low=0.5, high=100.0, doc="It stays as near to the depth it began at.", mav="BAND"
    )
    depth_margin: float = param(
        5.0, unit="m", low=0.0, high=100.0, doc="It keeps off the surface and depth_max.", mav="Z_MARGIN"
    )
    altitude_margin: float = param(
        5.0, unit="m", low=0.0, high=100.0, doc="It keeps as far above altitude_min.", mav="ALT_MARG"
    )
    pitch_max: float = param(25.0, unit="deg", low=1.0, high=60.0, doc="Steepest pitch, up and down.", mav="PITCH")
    depth_lead: float = param(
        5.0, unit="s", low=0.0, high=20.0, doc="How far ahead depth and altitude are judged.", mav="Z_LEAD"
    )
    pitch_lead: float = param(
        2.0, unit="s", low=0.0, high=20.0, doc="How far ahead in time pitch is judged.", mav="P_LEAD"
    )
    resume: float = param(0.5, low=0.0, high=1.0, doc="It goes on once inside this share of the limits.", mav="RESUME")
    patience: float = param(60.0, unit="s", low=1.0, high=1e4, doc="A wait as long as this ends it.", mav="PATIENCE")


class Dither(NamedTuple):
    """Fin angles (rad) to be added to the share `grip` of what the laws ask."""

    delta_s: float
    delta_r: float
    grip: float


STILL = Dither(0.0, 0.0, 1.0)


class Course(NamedTuple):
    """How far a manoeuvre has come: steps flown, steps of this wait and of all waits, and the sides of the fins."""

    kind: Kind
    flown: int
    waiting: int
    waited: int
    sides: Sides


class ManoeuvreGuidance:
    """Remembers a `Course`, or None while nothing is learned. `events` are the sentences of the last update.

    The supervisor's limits `depth_max` and `altitude_min` (m) are given, so that the manoeuvre waits long before they
    end it.
    """

    def __init__(self, params: ManoeuvreParams, depth_max: float = math.inf, altitude_min: float = 0.0) -> None:
        self._params = params
        self._deepest, self._lowest = depth_max - params.depth_margin, altitude_min
        self._memory: Course | None = None
        self._over: Kind | None = None
        self.events: tuple[str, ...] = ()

    @property
    def begun(self) -> bool:
        """Whether a manoeuvre is under way."""
        return self._memory is not None

    def update(self, manoeuvre: Manoeuvre, base: Setpoint, state: StateEstimate, dt: float) -> Dither:
        """What the fins do in this tick, the first one beginning the manoeuvre; after the last `begun` is False.

        Args:
            manoeuvre: what is flown, until it is over.
            base: the depth and course about which it is.
            state: finite in position, attitude and velocity.
            dt: step, s.
        """
        self.events = ()
        if self._memory is None:
            self._say(manoeuvre, f"begins: {manoeuvre.duration:g} s about {base.z_d:.1f} m")
        course = self._memory or Course(manoeuvre.kind, 0, 0, 0, Sides(1.0, 1.0))
        if why := self._breach(base.z_d, state, self._params.resume if course.waiting else 1.0):
            return self._wait(manoeuvre, course, why, dt)
        if course.waiting:
            self._say(manoeuvre, "goes on")
        at = sides(manoeuvre, course.flown, dt, course.sides, state.eta.theta, wrap(state.eta.psi - base.psi_d))
        self._memory = course._replace(flown=course.flown + 1, waiting=0, sides=at)
        if (course.flown + 1) * dt >= manoeuvre.duration:
            self.reset()
            self._say(manoeuvre, f"done: {manoeuvre.duration:g} s, and {course.waited * dt:.1f} s of waiting")
        return Dither(manoeuvre.delta_s * at.s, manoeuvre.delta_r * at.r, self._params.grip)

    def reset(self) -> None:
        """Ends it, or breaks it off: what is flown next begins anew."""
        if self._memory:
            self._over = self._memory.kind
        self._memory = None

    def taught(self, words: str) -> tuple[str, ...]:
        """The sentence on what a manoeuvre taught that has ended since this was last asked; `words` are `Learned`'s."""
        over, self._over = self._over, None
        return (f"{over.name.lower()}: {words}",) if over is not None and words else ()

    def freeze(self) -> Course | None:
        """All it remembers."""
        return self._memory

    def thaw(self, memory: Course | None) -> None:
        """Takes up again what `freeze` gave."""
        self._memory = memory

    def _wait(self, manoeuvre: Manoeuvre, course: Course, why: str, dt: float) -> Dither:
        if not course.waiting:
            self._say(manoeuvre, f"waits: {why}")
        self._memory = course._replace(waiting=course.waiting + 1, waited=course.waited + 1)
        if (course.waiting + 1) * dt >= self._params.patience:
            self.reset()
            self._say(manoeuvre, f"given up after {course.flown * dt:.1f} s: {why}")
        return STILL

    def _breach(self, base: float, state: StateEstimate, share: float) -> str:
        """Which of the limits, drawn in to that share, the boat is beyond or about to pass; "" if none.

        An altitude that is not known breaks none.
        """
        params = self._params
        _, _, z, phi, theta, psi = state.eta
        u, v, w, p, q, r = state.nu
        way = params.depth_lead * body_to_ned(phi, theta, psi, u, v, w)[2]
        top = base + share * (max(base - params.depth_band, params.depth_margin) - base)
        floor = base + share * (min(base + params.depth_band, self._deepest) - base)
        if max(z, z + way) > floor or min(z, z + way) < top:
            return f"depth {z:.1f} m, soon {z + way:.1f} m, limits {top:.1f} and {floor:.1f} m"
        lowest = self._lowest + (2.0 - share) * params.altitude_margin
        if min(state.altitude, state.altitude - way) < lowest:
            return f"altitude {state.altitude:.1f} m, soon {state.altitude - way:.1f} m, limit {lowest:.1f} m"
        steepest = share * params.pitch_max
        soon = theta + params.pitch_lead * euler_rates(phi, theta, p, q, r)[1]
        if max(abs(theta), abs(soon)) > steepest:
            angles = (math.degrees(angle) for angle in (theta, soon, steepest))
            return "pitch {:.0f} deg, soon {:.0f} deg, limit {:.0f} deg".format(*angles)
        return ""

    def _say(self, manoeuvre: Manoeuvre, sentence: str) -> None:
        self.events = (*self.events, f"{manoeuvre.kind.name.lower()} {sentence}")
