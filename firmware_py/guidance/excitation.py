"""What a learning manoeuvre does with the fins, step by step: pure functions of the step's number, and for the zigzag
of how far the boat has gone off.

The laws hold depth and heading meanwhile; these angles are added to theirs. Stern planes and rudder never move as one,
or their effects could not be told apart: doublets take turns, and a PRBS is flown half a period apart.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.mission import Manoeuvre, ManoeuvreKind

BITS = 7
PERIOD = 2**BITS - 1
"""Length of the sequence, in clocks."""


class Sides(NamedTuple):
    """To which side, and how far of their way in [-1, 1], stern planes and rudder are put over."""

    s: float
    r: float


def _registers() -> list[int]:
    """Every state of a shift register with feedback x^7 + x^6 + 1, which is primitive, in order, beginning with 1."""
    states = [1]
    while len(states) < PERIOD:
        last = states[-1]
        states.append((last << 1 | (last >> 6 ^ last >> 5) & 1) & PERIOD)
    return states


_REGISTERS = _registers()
_PLACES = {register: place for place, register in enumerate(_REGISTERS)}


def prbs(k: int, clock_steps: int, register: int) -> float:
    """A pseudo-random binary sequence of maximal length (Golomb 1967), at step k: 1 or -1.

    Over a period its correlation with itself, shifted by any number of clocks, is -1/127.

    Args:
        k: step, from 0.
        clock_steps: how many steps a value is held for, at least 1.
        register: what the shift register holds at k = 0, in [1, 127]: where in the sequence it begins.
    """
    return 1.0 if _REGISTERS[(_PLACES[register] + k // clock_steps) % PERIOD] & 1 else -1.0


def opposite(register: int) -> int:
    """The register half a period later. Sequences that begin in both have nothing in common for 63 clocks."""
    place: int = (_PLACES[register] + PERIOD // 2) % PERIOD
    return _REGISTERS[place]


def doublets(k: int, clock_steps: int) -> Sides:
    """The sides at step k: there and back with the stern planes, a clock each, then with the rudder."""
    return (Sides(1.0, 0.0), Sides(-1.0, 0.0), Sides(0.0, 1.0), Sides(0.0, -1.0))[k // clock_steps % 4]


def put_over(side: float, deviation: float, limit: float) -> float:
    """The side of a zigzag's fin: it goes against pitch, or heading, once that has gone `limit` (rad) off.

    Positive fin angles lower both.
    """
    return math.copysign(1.0, deviation) if abs(deviation) >= limit else side


def sides(manoeuvre: Manoeuvre, k: int, dt: float, before: Sides, pitch: float, heading: float) -> Sides:
    """Where the fins are at step k of dt (s), k = 0 being the first.

    Args:
        manoeuvre: what is flown.
        k: steps since its beginning.
        dt: step, s.
        before: the sides one step ago.
        pitch: how far the boat is off the level, rad.
        heading: how far it is off the base course, rad.
    """
    clock_steps = max(1, round(manoeuvre.clock / dt))
    if manoeuvre.kind is ManoeuvreKind.PRBS:
        register = manoeuvre.register
        return Sides(prbs(k, clock_steps, register), prbs(k, clock_steps, opposite(register)))
    if manoeuvre.kind is ManoeuvreKind.DOUBLETS:
        return doublets(k, clock_steps)
    return Sides(put_over(before.s, pitch, manoeuvre.pitch), put_over(before.r, heading, manoeuvre.heading))
