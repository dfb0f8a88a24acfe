"""Fins that a drive or servo turns by positions in counts, whatever the protocol: angles to counts and back."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from typing import Protocol, TypeVar

from firmware_py.marine import clip
from firmware_py.params import ParamError
from firmware_py.tick import Rate

_TURN = 2.0 * math.pi


class AtRest(enum.Enum):
    """What a drive does while the vehicle is disarmed."""

    OFF = enum.auto()
    """Its motor has no power."""
    CENTRE = enum.auto()
    HOLD = enum.auto()
    """It stays at the last angle of before, at the start where it is found."""


class Entry(Protocol):
    """An entry of an io file that is about one fin."""

    @property
    def name(self) -> str:
        """Return the name of the fin."""


E = TypeVar("E", bound=Entry)


class FinPositions:
    """Tells a drive the angles of its fin, and understands its positions.

    Args:
        key: of the fin's entry in the io file, for errors.
        counts_per_turn: of the fin's shaft.
        middle: counts where the drive itself is at 0.
        zero: angle of the drive's position, from there, where the fin is at 0, rad of the fin's shaft.
        travel: where targets stop, to either side of the fin's 0, rad.
        speed: fastest that it turns the fin, rad/s.
        against: whether the drive turns against the fin.
    """

    def __init__(
        self, key: str, counts_per_turn: float, middle: int, zero: float, travel: float, speed: float, *, against: bool
    ) -> None:
        self.key, self.travel, self._speed = key, travel, speed
        self._counts = counts_per_turn / _TURN * (-1.0 if against else 1.0)
        self._zero = middle + zero / _TURN * counts_per_turn

    def counts(self, angle: float) -> int:
        """Return the position of a fin angle, rad; one beyond the travel stops at its end."""
        return round(self._zero + self._counts * clip(angle, -self.travel, self.travel))

    def angle(self, counts: float) -> float:
        """Return the fin angle of a position, rad."""
        return (counts - self._zero) / self._counts

    @property
    def ends(self) -> tuple[int, int]:
        """Return the least and the greatest position that is told."""
        low, high = sorted((self.counts(-self.travel), self.counts(self.travel)))
        return low, high

    @property
    def reach(self) -> float:
        """Return the greatest angle to which the fin is turned, rad."""
        return self.travel

    def refuse_less_than(self, delta_max: float) -> None:
        """Refuse a drive that is not to turn its fin to delta_max, rad.

        Raises:
            ParamError: it stops before.
        """
        if delta_max > self.travel + 1e-9:
            raise ParamError(
                f"{self.key}: travel_deg = {math.degrees(self.travel):.4g}: must be at least the "
                f"fin's delta_max_deg = {math.degrees(delta_max):.4g}"
            )

    def refuse_slower_than(self, rate_max: float) -> None:
        """Refuse a drive that is not to turn its fin as fast as it is commanded, rad/s: it would be taken for jammed.

        Raises:
            ParamError: it is slower.
        """
        if rate_max > self._speed + 1e-9:
            raise ParamError(
                f"{self.key}: speed_deg_s = {math.degrees(self._speed):.4g}: must be at least the fin's "
                f"rate_max_deg_s = {math.degrees(rate_max):.4g}; give vehicle.toml less where the servo is slower"
            )


def refuse_rate(key: str, rate: Rate) -> None:
    """Refuse a rate of commands and positions at which no vehicle is steered, nor its fins watched.

    Raises:
        ParamError: it is too low.
    """
    if rate < Rate.HZ_10:
        raise ParamError(
            f'{key}.rate = "{rate.name.lower()}": fins that report so rarely cannot be watched; give "hz_10" or more'
        )


def by_fin(key: str, declared: Sequence[E], fins: Sequence[str]) -> list[E]:
    """Return the entry of each fin, in the order of vehicle.toml; none if none is declared.

    Args:
        key: of the entries in the io file.
        declared: the entries.
        fins: names of the fins.

    Raises:
        ParamError: a fin without an entry, an entry without a fin, or twice.
    """
    entries: dict[str, E] = {}
    for one in declared:
        if one.name not in fins:
            raise ParamError(f"{key}: {one.name}: is no fin of vehicle.toml, which has {', '.join(fins)}")
        if one.name in entries:
            raise ParamError(f"{key}: {one.name}: stands there twice; a fin has one driver")
        entries[one.name] = one
    missing = [name for name in fins if name not in entries]
    if declared and missing:
        raise ParamError(f"{key}: {missing[0]}: has no entry; where one fin has one, all must have one")
    return [entries[name] for name in fins] if declared else []
