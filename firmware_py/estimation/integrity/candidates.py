"""The devices of one role: what each of them says in a frame, and what is remembered of those that are not believed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, NamedTuple

from firmware_py.estimation.navigation.depth import DepthParams
from firmware_py.marine import GRAVITY, clip, wrap
from firmware_py.records.health import Role, SourceFault
from firmware_py.records.sensing import ROLES, Heard, SensorFrame

SPARES = tuple(f"spare_{role}" for role in ROLES)
_all_spares = attrgetter(*SPARES)
SAFER = (Role.PRESSURE, Role.ALTITUDE)
"""Of these the safer one of two holds that differ: the deeper pressure, the nearer bottom."""
_SETTLED = 0.5
"""Two that differed agree again at this share of the limit."""
_MEAN = 0.1
"""Of a new difference in the mean one, ten times a second: 1 s."""


class Slot(NamedTuple):
    """One candidate of a role; `number` 0 is the first in priority."""

    role: Role
    number: int


def slots_of(frame: SensorFrame) -> tuple[Slot, ...]:
    """Return the candidates of every role that has more than one."""
    counts = zip(Role, map(len, _all_spares(frame)), strict=True)
    return tuple([Slot(role, number) for role, spares in counts if spares for number in range(spares + 1)])


def heard_of(frame: SensorFrame, slot: Slot) -> Heard[Any]:
    """Return what a candidate says in a frame."""
    role, number = slot
    heard: Heard[Any] = getattr(frame, ROLES[role]) if number == 0 else getattr(frame, SPARES[role])[number - 1]
    return heard


def in_front(frame: SensorFrame, believed: tuple[int, ...]) -> SensorFrame:
    """Return a frame in which these candidates, a number for each role, have the fields of their roles."""
    if not any(believed):
        return frame
    pairs = zip(Role, believed, strict=True)
    others: dict[str, Any] = {ROLES[role]: heard_of(frame, Slot(role, number)) for role, number in pairs if number}
    return replace(frame, **others)


def safer_by(role: Role, value: Any, other: Any, per_metre: float) -> float:
    """Return by how much a device's reading is safer than another's, m: it is deeper, or its bottom nearer.

    Of attitudes (rad) and velocities (m/s) none is safer: the greatest difference, below zero. A metre of water is
    `per_metre` Pa.
    """
    worst: float
    if role is Role.AHRS:
        worst = max(abs(wrap(angle - its)) for angle, its in zip(other[:3], value[:3], strict=True))
        return -worst
    if role is Role.DVL:
        worst = max(abs(speed - its) for speed, its in zip(other[:3], value[:3], strict=True))
        return -worst
    more: float = value - other
    return more / per_metre if role is Role.PRESSURE else -more


@dataclass(slots=True)
class Contender:
    """What is remembered of one candidate; times in s.

    Attributes:
        t_ok: when it last told a value that it vouches for.
        t_steady: since when it does so without a long gap.
        better_since: since when it has been better than the one that is believed; inf: it is not.
        fit_since: since when nothing has spoken against believing it again; inf: something does.
        differs: mean of how much safer its readings are than those of the believed one (`safer_by`).
        disputed: whether that is too much, though nothing speaks against either.
        left: why another one was believed in its place last.
    """

    t_ok: float = -math.inf
    t_steady: float = math.inf
    better_since: float = math.inf
    fit_since: float = math.inf
    differs: float = 0.0
    disputed: bool = False
    left: SourceFault = SourceFault.NONE

    def hear(self, t: float, gap: float) -> None:
        """Take note of such a value; after a longer gap than this, s, it begins anew."""
        if not t - self.t_ok <= gap:
            self.t_steady = t
        self.t_ok = t

    def compare(self, safer_by: float, limit: float) -> None:
        """Take a difference of readings into the mean; both in m. A single one that is far off does not count more."""
        self.differs += _MEAN * (clip(safer_by, -2.0 * limit, 2.0 * limit) - self.differs)
        self.disputed = abs(self.differs) > (_SETTLED * limit if self.disputed else limit)

    def settle(self) -> None:
        """Take note that the two cannot be compared, for it is known which of them is wrong."""
        self.differs, self.disputed = 0.0, False

    def begin(self) -> None:
        """Begin anew, with another one that is believed."""
        self.better_since = self.fit_since = math.inf


class PressureZeros(NamedTuple):
    """By how much more each pressure sensor shows than the first one in air, Pa.

    Sensors differ by half a metre as they are bought, and navigation has one zero, which rests once the vehicle was
    armed (`navigation.depth`): so does this. One that was not heard before is taken as it is.
    """

    off: tuple[float, ...]
    counts: tuple[int, ...]
    zeroing: bool

    def learned(self, params: DepthParams, frame: SensorFrame, armed: bool, dt: float) -> PressureZeros:
        """Return what is known after a frame, dt s after the one before; only in air, and before the first arming."""
        first = frame.pressure
        if armed or not self.zeroing:
            return self if not self.zeroing else self._replace(zeroing=False)
        if not (params.zero_window > 0.0 and _in_air(params, first)):
            return self
        off, counts = list(self.off), list(self.counts)
        for i, heard in enumerate(frame.spare_pressure):
            if _in_air(params, heard, wide=True):
                counts[i] += 1
                off[i] += max(1.0 / counts[i], dt / (params.tau_zero + dt)) * (heard.value - first.value - off[i])
        return PressureZeros(tuple(off), tuple(counts), True)

    def applied(self, frame: SensorFrame) -> SensorFrame:
        """Return the frame with every pressure as the first sensor would show it."""
        if not any(self.off):
            return frame
        pairs = zip(frame.spare_pressure, self.off, strict=True)
        return replace(frame, spare_pressure=tuple([replace(heard, value=heard.value - off) for heard, off in pairs]))


def _in_air(params: DepthParams, heard: Heard[float], wide: bool = False) -> bool:
    """Return whether a reading may be the air's; `wide`: of a sensor that has no zero yet."""
    window = _ZERO_MOST if wide else params.zero_window
    return heard.ok and heard.t_valid > -math.inf and abs(heard.value - params.surface_pressure) <= window


_ZERO_MOST = 1000.0 * GRAVITY
"""A sensor that is off by more than this in air, Pa, is no sensor for depth."""
