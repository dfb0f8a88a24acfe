"""What the vehicle could do by the coefficients in force and what was left of its fins: turns, dives, least speed."""

from __future__ import annotations

import numpy as np

from firmware_py.records.manoeuvrability import Manoeuvrability
from sternplane.logs.reading import Columns, Piece
from sternplane.logs.tracking import Array

_HERE = "left"
FIGURES = {
    "turn_radius_m": "radius of the tightest turn that is flown, m",
    "slope_max_deg": "steepest dive that is flown, deg",
    "least_speed_m_s": "least speed that is flown, m/s",
    "turn_left_pct": "of turning, left by the fins, %",
    "dive_left_pct": "of diving, left by the fins, %",
}
"""What they are, for people."""
_WORST = {"turn_radius_m": np.fmax, "least_speed_m_s": np.fmax}
"""How the worse of two is found, where it is not the smaller one."""


def limits(c: Columns) -> dict[str, Array]:
    """Return `FIGURES` over the cycles; empty for a log that knows of none."""
    if f"{_HERE}.turn" not in c:
        return {}
    fields = np.stack([c[f"{_HERE}.{name}"].astype(float) for name in Manoeuvrability._fields], axis=1)
    rows, where = np.unique(fields, axis=0, return_inverse=True)  # it changes ten times a second at most
    found = np.array([_figures(Manoeuvrability(*map(float, row))) for row in rows])[where.reshape(-1)]
    return {name: found[:, i] for i, name in enumerate(FIGURES)}


class LimitFigures:
    """The limits at the beginning of a run, at their worst and at its end; shown the pieces of the log in order."""

    def __init__(self) -> None:
        self._found: dict[str, list[float]] = {}

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        for name, values in limits(piece.columns).items():
            worse = _WORST.get(name, np.fmin)
            begin, worst, _ = self._found.get(name, (float(values[0]), float(values[0]), 0.0))
            self._found[name] = [begin, float(worse(worst, worse.reduce(values))), float(values[-1])]

    @property
    def summary(self) -> dict[str, dict[str, float | None]] | None:
        """Return begin, worst and end by name; None for a log that knows of none.

        No number stands for a radius when the vehicle cannot turn to one side, and for a dive that nothing limits.
        """
        if not self._found:
            return None
        return {
            name: {
                word: value if np.isfinite(value) else None
                for word, value in zip(("begin", "worst", "end"), values, strict=True)
            }
            for name, values in self._found.items()
        }


def _figures(left: Manoeuvrability) -> tuple[float, ...]:
    shares = (100.0 * left.turn_left, 100.0 * left.dive_left)
    return left.turn_radius, float(np.degrees(left.slope)), left.speed, *shares
