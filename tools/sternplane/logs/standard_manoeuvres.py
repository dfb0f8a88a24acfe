"""Standard manoeuvres of a vehicle steered by hand: the turning circle and the zigzag (ITTC 7.5-04-02-01)."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from firmware_py.records.order import Mode
from sternplane.logs.reading import Columns, Piece
from sternplane.logs.tracking import Array, pose_of


class TurningCircleResult(NamedTuple):
    """Steady turning: over the last full turn, less the drift of its centre."""

    diameter: float
    """m."""
    rate: float
    """rad/s, positive to starboard."""


class ZigzagResult(NamedTuple):
    """What a zigzag is judged by."""

    first_overshoot: float
    """How far the heading went on in its old sense after the second execute, rad."""
    second_overshoot: float
    """The same after the third."""
    period: float
    """From the second execute to the fourth, s."""


class StandardManoeuvres:
    """Finds them in a run; it is shown the pieces of the log one after the other.

    It keeps the cycles in which the rudder is put over by hand, and the first one after each such time.
    """

    def __init__(self) -> None:
        self._kept: list[Array] = []
        self._psi = 0.0
        self._over = False

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        pose, rudder = pose_of(piece), _rudder(piece.columns)
        psi = (
            np.unwrap(np.concatenate(([self._psi], pose["eta.psi"])))[1:] if piece.begin else np.unwrap(pose["eta.psi"])
        )
        over = rudder != 0.0
        kept = over | np.concatenate(([self._over], over[:-1]))
        kept[0] |= not piece.begin
        self._psi, self._over = float(psi[-1]), bool(over[-1])
        columns = (piece.columns["t"], rudder, psi, pose["eta.x"], pose["eta.y"])
        self._kept.append(np.stack([column[kept] for column in columns]))

    def circle(self) -> TurningCircleResult | None:
        """The turning circle of the longest turn under one rudder angle in MANUAL; None below one and a half turns.

        The first half turn is taken for the way into it.
        """
        t, rudder, psi, *place = np.concatenate(self._kept, axis=1)
        edges = [0, *_moves(rudder), len(rudder)]
        spells = [(a, b - 1) for a, b in itertools.pairwise(edges) if rudder[a] != 0.0]
        begin, end = max(spells, key=lambda spell: abs(psi[spell[1]] - psi[spell[0]]), default=(0, 0))
        if not abs(psi[end] - psi[begin]) >= 3.0 * math.pi:
            return None
        begin += int(np.flatnonzero(np.abs(psi[end] - psi[begin:end]) >= math.tau)[-1])
        t = t[begin : end + 1]
        share = (t - t[0]) / (t[-1] - t[0])
        x, y = (_without_drift(axis[begin : end + 1], share) for axis in place)
        diameter = 2.0 * math.sqrt(np.var(x) + np.var(y))
        return TurningCircleResult(diameter, float((psi[end] - psi[begin]) / (t[-1] - t[0])))

    def zigzag(self) -> ZigzagResult | None:
        """The zigzag of a run whose rudder was put over from side to side in MANUAL; None before the fourth execute."""
        t, rudder, psi, *_ = np.concatenate(self._kept, axis=1)
        executes = _moves(rudder)[:4]
        angles = rudder[executes]
        if len(executes) < 4 or not angles[0] or not np.array_equal(angles[1:], -angles[:-1]):
            return None
        first, second, third, fourth = executes
        return ZigzagResult(
            _overshoot(psi[second:third], psi[second] - psi[first]),
            _overshoot(psi[third:fourth], psi[third] - psi[second]),
            float(t[fourth] - t[second]),
        )


def _rudder(c: Columns) -> Array:
    """The rudder angle that was asked for by hand, rad; 0 in every other mode."""
    rudder: Array = np.where(c["mode.mode"] == Mode.MANUAL, c["demand.delta_r"], 0.0)
    return rudder


def _moves(rudder: Array) -> list[int]:
    """Where a new angle begins."""
    return [int(i) + 1 for i in np.flatnonzero(np.diff(rudder))]


def _overshoot(psi: Array, way: float) -> float:
    return float(np.max(math.copysign(1.0, way) * (psi - psi[0])))


def _without_drift(x: Array, share: Array) -> Array:
    still: Array = x - share * (x[-1] - x[0])
    return still
