"""The fins: where each sits, how far it goes, and what its angle is worth in stern plane and rudder.

A fin's `hinge` is the angle of its hinge axis in the y-z plane. Over the stern fins delta_s = sum 1/2 cos(hinge) d and
delta_r = sum 1/2 sin(hinge) d: both stern planes of a + layout have 0, both rudders 90 deg, the fins of an X 45, 135,
45, 135. A bow plane (hinge 0) counts by its pitching moment, by which it steers depth: M_db / M_ds of delta_s.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from firmware_py.params import ParamError, param

MOST = 15
"""As many fins as one command on the bus can carry."""
_WORTHLESS = 1e-6


class Station(enum.Enum):
    """Where along the hull a fin sits."""

    STERN = enum.auto()
    BOW = enum.auto()


@dataclass(frozen=True, slots=True)
class Fin:
    """One fin and its servo's limits."""

    name: str
    hinge: float = param(unit="deg", low=-360.0, high=360.0, doc="Angle of the hinge axis in the y-z plane.")
    station: Station = Station.STERN
    delta_max: float = param(23.0, unit="deg", low=1.0, high=90.0, doc="Travel to either side.")
    rate_max: float = param(60.0, unit="deg/s", low=1.0, high=1000.0, doc="Highest speed that is asked of the servo.")

    def __post_init__(self) -> None:
        """Refuses a fin without a name."""
        if not self.name.strip():
            raise ParamError("name is empty; every fin needs a name of its own")


@dataclass(frozen=True, slots=True)
class Effectiveness:
    """What fin angles d are worth: delta_s = s . d and delta_r = r . d; `*_max` with every fin at its limit, rad."""

    s: tuple[float, ...]
    r: tuple[float, ...]
    delta_s_max: float
    delta_r_max: float


def sums(fins: tuple[Fin, ...]) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Three rows that make delta_s, delta_r (of the stern fins) and delta_b (the sum of the bow planes) of fin angles.

    These are the angles that the coefficients of stern planes, rudders and one bow plane multiply.
    """
    stern = [fin.station is Station.STERN for fin in fins]
    return (
        tuple(0.5 * round(math.cos(fin.hinge), 12) if at else 0.0 for fin, at in zip(fins, stern, strict=True)),
        tuple(0.5 * round(math.sin(fin.hinge), 12) if at else 0.0 for fin, at in zip(fins, stern, strict=True)),
        tuple(0.0 if at else round(math.cos(fin.hinge), 12) for fin, at in zip(fins, stern, strict=True)),
    )


def effectiveness(fins: tuple[Fin, ...], bow_worth: float) -> Effectiveness:
    """The two rows of a layout; `bow_worth` is M_db / M_ds.

    Raises:
        ParamError: no fins or too many, two of one name, a bow plane not level, or nothing that acts on pitch or yaw.
    """
    if not fins:
        raise ParamError("fins is empty; a vehicle needs fins that act on pitch and on yaw")
    if len(fins) > MOST:
        raise ParamError(f"fins: {len(fins)} are too many; one command holds {MOST}")
    names = [fin.name for fin in fins]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ParamError(f"fins: {twice!r} occurs {names.count(twice)} times; every fin needs a name of its own")
    for fin in fins:
        if fin.station is Station.BOW and abs(math.sin(fin.hinge)) > _WORTHLESS:
            raise ParamError(f"fins: bow plane {fin.name!r} has hinge_deg {math.degrees(fin.hinge):g}; only 0 is known")
    stern = [fin.station is Station.STERN for fin in fins]
    s = tuple((0.5 if at else bow_worth) * round(math.cos(fin.hinge), 12) for fin, at in zip(fins, stern, strict=True))
    r = tuple((0.5 if at else 0.0) * round(math.sin(fin.hinge), 12) for fin, at in zip(fins, stern, strict=True))
    if not any(abs(worth) > _WORTHLESS for worth in s):
        raise ParamError("fins: none acts on delta_s; one needs a hinge_deg other than 90 or 270")
    if not any(abs(worth) > _WORTHLESS for worth in r):
        raise ParamError("fins: none acts on delta_r; a stern fin needs a hinge_deg other than 0 or 180")
    if _determinant(s, r) < _WORTHLESS:
        raise ParamError("fins: delta_s and delta_r cannot be asked for apart; the hinges must not all be parallel")
    limits = [fin.delta_max for fin in fins]
    return Effectiveness(s, r, _reach(s, limits), _reach(r, limits))


def _determinant(s: tuple[float, ...], r: tuple[float, ...]) -> float:
    ss, rr, sr = sum(a * a for a in s), sum(a * a for a in r), sum(a * b for a, b in zip(s, r, strict=True))
    return (ss * rr - sr * sr) / (ss * rr)


def _reach(worth: tuple[float, ...], limits: list[float]) -> float:
    return sum(abs(a) * limit for a, limit in zip(worth, limits, strict=True))
