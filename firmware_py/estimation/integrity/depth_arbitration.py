"""Who is wrong when pressure and carried depth went apart: what decides it is the bottom, and propeller and pitch.

- **Bottom**: altitude + depth, or altitude + D, is the depth of the bottom; of the two the one that changed is wrong,
  if the bottom was flat before.
- **Model**: propeller and pitch make a vertical velocity likely; the one that left it is wrong. Heave, eddies, and what
  u is off by, are a metre or two in 5 s.

Where neither tells, the deeper one is the safer.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.records.health import SourceFault

_CLEAR = 0.5
"""One of the two is wrong, if the other changed less than this share of it."""
_ROUGH = 0.2
"""The bottom is no witness, where it rose or fell by more than this before, m, or by more than _CLEAR of the change."""
_BLIND = 0.3
"""So much longer without DVL, or without the model, s, and a window does not count as carried by it."""
_SUDDEN, _HEAVE = math.radians(2.5), 0.35
"""A pitch off by more than this, rad, cannot come in a second without the gyros; eddies heave a hull by less, m/s."""
_SLIP = 0.4
"""Of two that differ it is the DVL, if its u is above model and current by more than this, m/s."""
_GYRO_OFF = math.radians(1.3)
"""A pitch that is as far from the gyros is what is wrong, if DVL and pitch are contradicted."""
_MODEL_TIME = 5.0
"""The model's threshold is for so long, s, and grows from there in proportion to the time."""


class Accused(enum.Enum):
    """Who is wrong when pressure and carried depth differ."""

    NOBODY = enum.auto()
    PRESSURE_STEP = enum.auto()
    PRESSURE_DRIFT = enum.auto()
    CARRIED = enum.auto()
    """DVL or pitch."""
    SHALLOW_PRESSURE = enum.auto()
    """Not decided, and the pressure is less deep: the carried depth holds."""
    SHALLOW_CARRIED = enum.auto()
    """Not decided, and the pressure is deeper: it holds."""


class Entry(NamedTuple):
    """What is known at one time.

    Attributes:
        residual: depth less carried depth, running mean, m.
        carried: depth that DVL and pitch carry, without DVL the model, m.
        altitude: m; NaN if unknown.
        blind: time that it was carried without DVL, s.
        depth: by the pressure, m.
        raw: depth that the DVL alone carries, believed or not, m.
        model: depth that propeller and pitch alone carry, m.
        vague: time for which these could not tell, s.
        t: the time, s.
    """

    residual: float
    carried: float
    altitude: float
    blind: float
    depth: float
    raw: float
    model: float
    vague: float
    t: float


def arbitrate(now: Entry, then: Entry, history: Sequence[Entry], window: int, model_limit: float) -> Accused:
    """Return who is wrong.

    Args:
        now: when pressure and carried depth differ.
        then: when they did not.
        history: the entries up to when they went apart.
        window: how many entries before its end `then` is.
        model_limit: what propeller and pitch may be off by in 5 s, m.
    """
    change = now.residual - then.residual
    blind = now.blind - then.blind > _BLIND
    if blind:
        return Accused.PRESSURE_DRIFT if change < 0.0 else Accused.SHALLOW_CARRIED
    if _flat(history, window, change):
        by_carried = abs(now.altitude + now.carried - then.altitude - then.carried)
        by_pressure = abs(now.altitude + now.depth - then.altitude - then.depth)
        if by_carried < _CLEAR * by_pressure:
            return Accused.PRESSURE_DRIFT
        if by_pressure < _CLEAR * by_carried:
            return Accused.CARRIED
    if now.vague - then.vague <= _BLIND:
        limit = model_limit * max(1.0, (now.t - then.t) / _MODEL_TIME)
        modelled = now.model - then.model
        by_carried, by_pressure = abs(now.carried - then.carried - modelled), abs(now.depth - then.depth - modelled)
        if by_pressure > limit and by_carried < _CLEAR * by_pressure:
            return Accused.PRESSURE_DRIFT
        if by_carried > limit and by_pressure < _CLEAR * by_carried:
            return Accused.CARRIED
    return Accused.SHALLOW_PRESSURE if change < 0.0 else Accused.SHALLOW_CARRIED


def _flat(history: Sequence[Entry], window: int, change: float) -> bool:
    """Return whether the bottom lay flat before the last `window` entries, over as long a time at least."""
    before = len(history) - window
    if before < window:
        return False
    rough = max(_ROUGH, _CLEAR * abs(change))
    for i in range(0, before - window, max(1, window // 2)):
        one, other = history[i], history[i + window]
        if not abs(other.altitude + other.carried - one.altitude - one.carried) <= rough:
            return False
    return True


def accuse_carried(
    t: float, ahrs: SourceWatch, dvl: SourceWatch, off: float, heave: float, slip: float, implied: float, proven: bool
) -> None:
    """Accuse DVL or pitch, or both where nothing tells; the depth is by the pressure then, and needs neither.

    Args:
        t: the time, s.
        ahrs: the watch of the pitch.
        dvl: the watch of the DVL.
        off: what the pitch is off by the gyros, rad: a pitch that leaves them is wrong.
        heave: running mean of the DVL's w, m/s.
        slip: what its u leaves model and current by, m/s.
        implied: what the pitch would have had to change by in a second, rad; gyros would show it.
        proven: whether they agreed before: what was there from the start the gyros cannot show.
    """
    if off > _GYRO_OFF:
        ahrs.accuse(SourceFault.CONTRADICTED, t)
        dvl.acquit()
    elif not dvl.believed or abs(heave) > _HEAVE or slip > _SLIP or (proven and implied > _SUDDEN + 2.0 * off):
        dvl.accuse(SourceFault.DRIFT, t)
        ahrs.acquit()
    else:
        dvl.accuse(SourceFault.UNDECIDED, t)
        ahrs.accuse(SourceFault.UNDECIDED, t)
