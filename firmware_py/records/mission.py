"""A mission: the items that are flown one after another."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.params import ParamError, param


class Waypoint(NamedTuple):
    """A place to pass: x, y (m, local NED), depth z (m), speed u (m/s, 0 the cruising speed).

    `above`: z is how high above the bottom, m.
    """

    x: float
    y: float
    z: float
    u: float
    above: bool = False


class Loiter(NamedTuple):
    """A circle about x, y at z, with speed u, all as a `Waypoint` has it, until one of `turns` and `duration` is over.

    `radius`, m, is positive to starboard, negative to port; 0 leaves it to the guidance, which may also widen it.
    `turns` are counted and `duration`, s, runs from where the circle is joined; 0 sets no end.
    """

    x: float
    y: float
    z: float
    u: float
    above: bool
    radius: float
    turns: float
    duration: float


class Jump(NamedTuple):
    """Go on with item `to`, counted from 0, so many `times`, then with the next one; -1 times is for ever."""

    to: int
    times: int


class Surface(NamedTuple):
    """The end of the mission, whatever comes behind it; `rally`: first where RETURN goes."""

    rally: bool = False


class ManoeuvreKind(enum.IntEnum):
    """What a learning manoeuvre does with stern planes and rudder."""

    ZIGZAG = enum.auto()
    """They are put over each time pitch, or heading, has gone so far off."""
    DOUBLETS = enum.auto()
    """There and back with the stern planes, then with the rudder."""
    PRBS = enum.auto()
    """To one side or the other at each clock, as a pseudo-random binary sequence has it."""


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """A learning manoeuvre, flown where the mission has come to, about the depth and course of its beginning.

    The numbers are chosen by the Cramér-Rao bound of NPS AUV II's ten coefficients after 60 s, mean and worst relative
    sigma (`python -m sternplane.identification.excitation`). PRBS of 15 deg and 2 s: 0.50 and 1.8 % from register 33,
    0.49 to 0.62 % from 15 others, three of which have to wait; of 5 deg 1.7 and 5.6 %; of 20 deg 0.39 and
    1.4 %, which leaves the laws too little of the travel. Zigzag of 15 deg at 4 and 20 deg: 0.62 and 2.6 %. Doublets
    want 6 s: 0.92 and 3.1 %.
    """

    kind: ManoeuvreKind
    duration: float = param(120.0, unit="s", low=1.0, high=1e4, doc="How long the fins move; waits come on top.")
    delta_s: float = param(15.0, unit="deg", low=0.0, high=90.0, doc="Amplitude of the stern planes, added to the law.")
    delta_r: float = param(15.0, unit="deg", low=0.0, high=90.0, doc="Amplitude of the rudder, added to the law.")
    clock: float = param(2.0, unit="s", low=0.1, high=100.0, doc="PRBS, doublets: how long an angle is held at least.")
    register: int = param(33, low=1, high=127, doc="PRBS: what its shift register begins with.")
    pitch: float = param(4.0, unit="deg", low=1.0, high=45.0, doc="Zigzag: pitch at which stern planes are put over.")
    heading: float = param(20.0, unit="deg", low=1.0, high=90.0, doc="Zigzag: deviation at which rudder is put over.")
    speed: float = param(0.0, unit="m/s", low=0.0, high=10.0, doc="To fly it with; 0 is the cruising speed.")

    def __post_init__(self) -> None:
        if not self.delta_s + self.delta_r > 0.0:
            raise ParamError("delta_s_deg and delta_r_deg are both 0: nothing would move; give one of them an angle")


MissionItem = Waypoint | Loiter | Jump | Surface | Manoeuvre
"""An item of a mission."""


def is_above(item: MissionItem | None) -> bool:
    """Return whether the depth of an item is one above the bottom."""
    return isinstance(item, Waypoint | Loiter) and item.above


def leads_nowhere(items: Sequence[MissionItem]) -> bool:
    """Return whether there are items, and none but jumps is ever come to."""
    seen: set[int] = set()
    todo = [0] if items else []
    while todo:
        at = todo.pop()
        if at in seen or at >= len(items):
            continue
        seen.add(at)
        item = items[at]
        if not isinstance(item, Jump):
            return False
        todo += [at + 1] if item.times >= 0 else []
        todo += [item.to] if item.times else []
    return bool(items)


@dataclass(frozen=True, slots=True)
class Mission:
    """What is flown, item after item; at the end the vehicle surfaces."""

    items: tuple[MissionItem, ...] = ()

    @property
    def waypoints(self) -> tuple[Waypoint, ...]:
        """Those of the items that are places."""
        return tuple(item for item in self.items if isinstance(item, Waypoint))

    @property
    def above(self) -> bool:
        """Whether any of its depths is one above the bottom."""
        return any(is_above(item) for item in self.items)
