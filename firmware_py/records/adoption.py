"""What the laws are designed from: coefficients in force, where they come from, and why."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import NamedTuple


class Source(enum.IntEnum):
    """Where the coefficients of a law come from."""

    FILE = 0
    """vehicle.toml: nothing was learned yet, or adoption is switched off."""
    PASSPORT = 1
    """An earlier flight of the same vehicle."""
    LEARNED = 2
    """What the filter learns, as it learns it."""
    LAST_GOOD = 3
    """What was learned earlier; what is learned now is refused, or nothing is."""
    NOMINAL = 4
    """vehicle.toml again: what was learned did not hold."""


class Refusal(enum.IntEnum):
    """Why what is learned is not in force, or not all of it."""

    NONE = 0
    OFF = 1
    """An operator switched adoption off, or nothing is learned."""
    UNCERTAIN = 2
    """The 1 sigma of some is too large."""
    BOUND = 3
    """Some is farther from vehicle.toml than is believed, and held at the bound."""
    DESIGN = 4
    """No law can be designed from it, or the fins would do far less, or far more, than by vehicle.toml."""
    RESIDUALS = 5
    """In closed loop the vehicle moves otherwise: vehicle.toml explains it better."""


class AxisDesign(NamedTuple):
    """The design of one law, of depth or of heading.

    Attributes:
        source: where its coefficients come from.
        refusal: why what is learned is not in force.
        s_b: s'b at the trim speed, which scales the switching term.
        authority: angular acceleration of the vehicle with the fins at their limit, at the trim speed, rad/s^2.
        poles: of the motion on the sliding surface at the trim speed, 1/s.
        evidence: log-likelihood ratio of the coefficients in force against vehicle.toml, nats.
    """

    source: Source
    refusal: Refusal
    s_b: float
    authority: float
    poles: tuple[float, float]
    evidence: float


@dataclass(frozen=True, slots=True)
class Adopted:
    """What the laws are designed from in this tick.

    `diving` and `steering` are the coefficients of the linear models, as `vehicle.linear_models` names them; `depth`
    and `heading` the laws that are designed from them. `caution` is 1 while too little is known for fast manoeuvres, 0
    once enough is, and between them on the way.
    """

    diving: tuple[float, ...]
    steering: tuple[float, ...]
    depth: AxisDesign
    heading: AxisDesign
    caution: float
    held_diving: tuple[float, ...] = ()
    """What held of `diving` for a while, and"""
    held_steering: tuple[float, ...] = ()
    """of `steering`; not a number before anything did. What fins do is judged by it."""
    refuted: tuple[bool, bool] = (False, False)
    """Whether the motion has refuted vehicle.toml in pitch, in yaw, while nothing else has held."""
    proven: tuple[bool, bool] = (False, False)
    """Whether damping and fins of `held_diving`, of `held_steering` agree with values that were valid: then fins of the
    axis are judged by them, however little is known of the other one."""
    halved: tuple[bool, bool] = (False, False)
    """Whether valid values say that the fins of pitch, of yaw, do no more than half of what they did in this flight:
    what held is that of before."""


_SOURCES = {
    Source.FILE: "designed from the vehicle file",
    Source.PASSPORT: "designed from what an earlier flight learned",
    Source.LEARNED: "designed from what is learned",
    Source.LAST_GOOD: "keeps what was learned earlier",
    Source.NOMINAL: "back to the vehicle file",
}
_REFUSALS = {
    Refusal.NONE: "all of it is known well enough",
    Refusal.OFF: "adoption is off",
    Refusal.UNCERTAIN: "not all of it is known well enough",
    Refusal.BOUND: "some of it is held at a bound",
    Refusal.DESIGN: "no law can be designed from what is learned",
    Refusal.RESIDUALS: "the vehicle does not move as was learned",
}


def design_text(source: float, refusal: float) -> str:
    """Return a clause on what a law is designed from, and why."""
    return f"{_SOURCES[Source(int(source))]}; {refusal_text(Refusal(int(refusal)))}"


def refusal_text(refusal: Refusal) -> str:
    """Return why what is learned is not in force, as a clause."""
    return _REFUSALS[refusal]
