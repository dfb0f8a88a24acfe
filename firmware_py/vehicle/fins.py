"""The fins: where each sits, how far it moves, and how its angle contributes to delta_s and delta_r.

A fin's `hinge` is the angle of its hinge axis in the y-z plane. Over the stern fins, with angles d,
delta_s = sum 1/2 cos(hinge) d and delta_r = sum 1/2 sin(hinge) d: the two stern planes of a + layout have hinge 0, the
two rudders 90 deg, the fins of an X 45, 135, 45, 135 deg. A bow plane (hinge 0) contributes M_db / M_ds of its angle to
delta_s, in the ratio of the pitching moments.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from firmware_py.error_text import quoted
from firmware_py.params import ParamError, param

MAX_FINS = 15
"""As many fins as fit into one actuator command on the bus."""
_PER_FIN = 0.5
"""Share of one stern fin: the coefficients of stern planes and rudders are those of a pair that moves together."""
_DECIMALS = 12
"""Sine and cosine are rounded, so that hinges of 0 and 90 deg give exact zeros."""
_NEGLIGIBLE = 1e-6


class FinStation(enum.Enum):
    """Where along the hull a fin sits."""

    STERN = enum.auto()
    BOW = enum.auto()


@dataclass(frozen=True, slots=True)
class Fin:
    """One fin and the limits of its servo."""

    name: str = param(doc="Name of the fin, unique in this file; it appears in logs, events and fault names.")
    hinge: float = param(
        unit="deg", low=-360.0, high=360.0, doc="Angle of the hinge axis in the y-z plane: 0 stern plane, 90 rudder."
    )
    station: FinStation = FinStation.STERN
    delta_max: float = param(
        23.0, unit="deg", low=1.0, high=45.0, doc="Greatest fin angle to either side; a fin stalls beyond 45 deg."
    )
    rate_max: float = param(60.0, unit="deg/s", low=1.0, high=300.0, doc="Greatest fin rate that is commanded.")

    def __post_init__(self) -> None:
        """Refuse a fin without a name."""
        if not self.name.strip():
            raise ParamError("name is empty; every fin needs a name of its own")


@dataclass(frozen=True, slots=True)
class Effectiveness:
    """Control effectiveness of the fins: delta_s = s . d and delta_r = r . d for fin angles d, rad.

    Attributes:
        s: one entry per fin.
        r: one entry per fin.
        delta_s_max: delta_s with every fin at its limit, rad.
        delta_r_max: delta_r with every fin at its limit, rad.
    """

    s: tuple[float, ...]
    r: tuple[float, ...]
    delta_s_max: float
    delta_r_max: float


def deflection_rows(fins: tuple[Fin, ...]) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Return the rows, shape (3, number of fins), that turn fin angles into delta_s, delta_r and delta_b.

    delta_s and delta_r are those of the stern fins alone; delta_b is the sum over the bow planes. The coefficients of
    stern planes, rudders and one bow plane multiply these angles.
    """
    return (
        tuple(_PER_FIN * _cos(fin.hinge) if _at_stern(fin) else 0.0 for fin in fins),
        tuple(_PER_FIN * _sin(fin.hinge) if _at_stern(fin) else 0.0 for fin in fins),
        tuple(0.0 if _at_stern(fin) else _cos(fin.hinge) for fin in fins),
    )


def effectiveness(fins: tuple[Fin, ...], bow_ratio: float) -> Effectiveness:
    """Return the effectiveness of a fin layout; `bow_ratio` is M_db / M_ds.

    Raises:
        ParamError: no fins or too many, two with one name, a bow plane that is not level, or pitch and yaw cannot be
            controlled independently.
    """
    if not fins:
        raise ParamError("fins is empty; a vehicle needs fins that act on pitch and on yaw")
    if len(fins) > MAX_FINS:
        raise ParamError(f"fins: {len(fins)} are too many; one command holds {MAX_FINS}")
    names = [fin.name for fin in fins]
    repeated = next((name for name in names if names.count(name) > 1), None)
    if repeated is not None:
        raise ParamError(
            f"fins: {quoted(repeated)} occurs {names.count(repeated)} times; every fin needs a name of its own"
        )
    for fin in fins:
        if fin.station is FinStation.BOW and abs(math.sin(fin.hinge)) > _NEGLIGIBLE:
            raise ParamError(
                f"fins: bow plane {quoted(fin.name)} has hinge_deg {math.degrees(fin.hinge):g}; only 0 is supported"
            )
    s = tuple((_PER_FIN if _at_stern(fin) else bow_ratio) * _cos(fin.hinge) for fin in fins)
    r = tuple((_PER_FIN if _at_stern(fin) else 0.0) * _sin(fin.hinge) for fin in fins)
    if not any(abs(entry) > _NEGLIGIBLE for entry in s):
        raise ParamError("fins: none acts on delta_s; one needs a hinge_deg other than 90 or 270")
    if not any(abs(entry) > _NEGLIGIBLE for entry in r):
        raise ParamError("fins: none acts on delta_r; a stern fin needs a hinge_deg other than 0 or 180")
    if _relative_determinant(s, r) < _NEGLIGIBLE:
        raise ParamError("fins: delta_s and delta_r are not independent; the hinges must not all be parallel")
    limits = [fin.delta_max for fin in fins]
    return Effectiveness(s, r, _greatest(s, limits), _greatest(r, limits))


def _at_stern(fin: Fin) -> bool:
    return fin.station is FinStation.STERN


def _cos(angle: float) -> float:
    return round(math.cos(angle), _DECIMALS)


def _sin(angle: float) -> float:
    return round(math.sin(angle), _DECIMALS)


def _relative_determinant(s: tuple[float, ...], r: tuple[float, ...]) -> float:
    """Return det(B B') over the product of its diagonal, for B = (s, r): 0 where the rows are parallel."""
    ss, rr, sr = sum(a * a for a in s), sum(a * a for a in r), sum(a * b for a, b in zip(s, r, strict=True))
    return (ss * rr - sr * sr) / (ss * rr)


def _greatest(row: tuple[float, ...], limits: list[float]) -> float:
    """Return the greatest row . d for fin angles d within +-limits."""
    return sum(abs(a) * limit for a, limit in zip(row, limits, strict=True))
