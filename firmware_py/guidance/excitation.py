"""Excitation signals of learning manoeuvres: pure functions of the step, for the zigzag of the deviation too.

The laws hold depth and heading meanwhile; these angles are added. Stern planes and rudder never move in the same way,
for their effects must be separable: doublets alternate, and the two PRBS are half a period apart.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.mission import Manoeuvre, ManoeuvreKind

BITS = 7
PERIOD = 2**BITS - 1
"""Length of the sequence, in clocks."""


class Sides(NamedTuple):
    """Excitation of stern planes and rudder as shares of their amplitudes, in [-1, 1]."""

    s: float
    r: float


def _registers() -> list[int]:
    """Return every state of a shift register with feedback x^7 + x^6 + 1 (primitive), in order from state 1."""
    states = [1]
    while len(states) < PERIOD:
        last = states[-1]
        states.append((last << 1 | (last >> 6 ^ last >> 5) & 1) & PERIOD)
    return states


_REGISTERS = _registers()
_PLACES = {register: place for place, register in enumerate(_REGISTERS)}


def prbs(k: int, clock_steps: int, register: int) -> float:
    """Return a pseudo-random binary sequence of maximal length (Golomb 1967) at step k: 1 or -1.

    Over a period its correlation with itself, shifted by any number of clocks, is -1/127.

    Args:
        k: step, from 0.
        clock_steps: how many steps a value is held for, at least 1.
        register: what the shift register holds at k = 0, in [1, 127]: where in the sequence it begins.
    """
    return 1.0 if _REGISTERS[(_PLACES[register] + k // clock_steps) % PERIOD] & 1 else -1.0


def opposite(register: int) -> int:
    """Return the register half a period later: the two sequences are uncorrelated for 63 clocks."""
    place: int = (_PLACES[register] + PERIOD // 2) % PERIOD
    return _REGISTERS[place]


def doublets(k: int, clock_steps: int) -> Sides:
    """Return the sides at step k: a doublet of the stern planes, then one of the rudder, a clock for each side."""
    return (Sides(1.0, 0.0), Sides(-1.0, 0.0), Sides(0.0, 1.0), Sides(0.0, -1.0))[k // clock_steps % 4]


def put_over(side: float, deviation: float, limit: float) -> float:
    """Return the side of a zigzag's fin: it is reversed when pitch, or heading, deviates by `limit` (rad).

    Positive fin angles lower both.
    """
    return math.copysign(1.0, deviation) if abs(deviation) >= limit else side


def sides(manoeuvre: Manoeuvre, k: int, dt: float, before: Sides, pitch: float, heading: float) -> Sides:
    """Return the sides of the fins at step k of dt (s), from 0.

    Args:
        manoeuvre: what is flown.
        k: steps since its beginning.
        dt: step, s.
        before: the sides one step ago.
        pitch: pitch angle, rad.
        heading: deviation from the base course, rad.
    """
    clock_steps = max(1, round(manoeuvre.clock / dt))
    if manoeuvre.kind is ManoeuvreKind.PRBS:
        register = manoeuvre.register
        return Sides(prbs(k, clock_steps, register), prbs(k, clock_steps, opposite(register)))
    if manoeuvre.kind is ManoeuvreKind.DOUBLETS:
        return doublets(k, clock_steps)
    return Sides(put_over(before.s, pitch, manoeuvre.pitch), put_over(before.r, heading, manoeuvre.heading))
