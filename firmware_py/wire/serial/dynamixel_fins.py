"""Fins on Dynamixel servos, as the io file describes them, and how an angle of the fin is told to a servo in counts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import ParamError, param
from firmware_py.tick import Rate
from firmware_py.wire.fin_positions import AtRest, FinPositions, by_fin, refuse_rate
from firmware_py.wire.serial.dynamixel_x import COUNTS_PER_TURN, MIDDLE, VELOCITY_STEP

_BITS_PER_BYTE = 10
_FASTEST = 1023
"""Profile velocity that every model takes."""
_MISSED = 2
"""So many cycles may go without an answer before that is told apart from silence."""
_SHARE = 0.6
"""Of the period, for goals, question and answers: the rest is for other questions."""


@dataclass(frozen=True, slots=True)
class DynamixelFinParams:
    """Table [[dynamixel.fins]] of io_*.toml: the servo of one fin."""

    name: str = param(doc="Of the fin in vehicle.toml.")
    id: int = param(low=0, high=252, doc="Of the servo. As sold all have 1: give each its own with the maker's tool.")
    reversed: bool = param(False, doc="Whether the servo turns against the fin. It counts up counter-clockwise.")
    scale: float = param(1.0, low=0.1, high=10.0, doc="Angle of the servo by that of the fin, of a linkage.")
    zero: float = param(
        0.0, unit="deg", low=-180.0, high=180.0, doc="Angle of the servo from its middle where the fin is at 0."
    )
    travel: float = param(
        45.0,
        unit="deg",
        low=1.0,
        high=180.0,
        doc="Where goals stop, to either side of the fin's 0; the limits of the servo.",
    )
    speed: float = param(120.0, unit="deg/s", low=1.0, high=1400.0, doc="Fastest that the servo turns the fin.")
    at_rest: AtRest = AtRest.OFF


@dataclass(frozen=True, slots=True)
class DynamixelParams:
    """Table [dynamixel] of io_*.toml: fins on Dynamixel servos of a line (RS-485 or TTL, protocol 2.0)."""

    port: str = param("", doc="Serial device or tcp:HOST:PORT; {bus} in it stands for the name of the bus.")
    baud: int = param(1_000_000, low=9600, high=4_500_000, doc="Bits a second, set in each servo. As sold: 57600.")
    rate: Rate = Rate.HZ_50
    return_delay: float = param(
        20.0, unit="us", low=0.0, high=508.0, doc="Pause of a servo before it answers: what an adapter needs to turn."
    )
    answer: float = param(
        0.02, unit="s", low=0.002, high=0.2, doc="Longest that an adapter keeps an answer; the line waits meanwhile."
    )
    timeout: float = param(
        0.5, unit="s", low=0.05, high=10.0, doc="A servo without an answer for so long is lost, and set up anew."
    )
    patience: float = param(
        0.5, unit="s", low=0.04, high=2.54, doc="A servo that hears no autopilot for so long stops where it is."
    )
    fins: tuple[DynamixelFinParams, ...] = ()

    def __post_init__(self) -> None:
        """Refuse one id for two servos, fins without a line, times that contradict each other, and too slow a line."""
        refuse_rate("dynamixel", self.rate)
        least = _MISSED * (1.0 / self.rate + self.answer)
        for name, time in (("timeout_s", self.timeout), ("patience_s", self.patience)):
            if time < least:
                raise ParamError(
                    f"dynamixel.{name} = {time:g}: must be at least {least:g}, as long as {_MISSED} cycles of rate "
                    "whose answers do not come take with answer_s; else sound servos stop"
                )
        taken: dict[int, str] = {}
        for one in self.fins:
            if one.id in taken:
                raise ParamError(f"dynamixel.fins: {one.name}: id = {one.id}: is {taken[one.id]} already")
            taken[one.id] = one.name
        if self.fins and not self.port:
            raise ParamError("dynamixel.port: must be the serial device of the servos, such as /dev/ttyUSB0")
        busy, period = self.seconds(self.cycle_bytes), 1.0 / self.rate
        if busy > _SHARE * period:
            raise ParamError(
                f"dynamixel.baud = {self.baud}: goals and positions of {len(self.fins)} servos take "
                f"{1e3 * busy:.0f} ms of the {1e3 * period:.0f} ms of dynamixel.rate; set servos to 1000000 baud, or "
                "give a lower rate"
            )

    @property
    def driver(self) -> str:
        """Return the name of the protocol."""
        return "dynamixel"

    @property
    def cycle_bytes(self) -> int:
        """Return the bytes of one cycle: a sync write of goals, a sync read, and an answer each."""
        return 28 + 21 * len(self.fins)

    def seconds(self, count: int) -> float:
        """Return how long so many bytes take, s, with the pause of each servo."""
        return count * _BITS_PER_BYTE / self.baud + len(self.fins) * self.return_delay


class DynamixelFin(FinPositions):
    """Tells a servo the angles of its fin, and understands its positions.

    Raises:
        ParamError: the servo would have to turn beyond its turn of 4096 counts, of which it knows none but one.
    """

    def __init__(self, params: DynamixelFinParams) -> None:
        self.params = params
        per_turn, zero = COUNTS_PER_TURN * params.scale, params.zero / params.scale
        super().__init__(
            f"dynamixel.fins: {params.name}",
            per_turn,
            MIDDLE,
            zero,
            params.travel,
            params.speed,
            against=params.reversed,
        )
        low, high = self.ends
        if not 0 <= low < high < COUNTS_PER_TURN:
            raise ParamError(
                f"{self.key}: travel_deg = {math.degrees(params.travel):.4g}: the servo would have to go from {low} to "
                f"{high} counts, and has those from 0 to {COUNTS_PER_TURN - 1}; mount its horn anew so that zero_deg "
                "is near 0"
            )

    @property
    def profile_velocity(self) -> int:
        """Return the speed in the servo's unit; 0 would be none."""
        return round(clip(self.params.speed * self.params.scale / VELOCITY_STEP, 1, _FASTEST))


def servos_of(declared: Sequence[DynamixelFinParams], fins: Sequence[str]) -> tuple[DynamixelFin, ...]:
    """Return the servo of each fin, in the order of vehicle.toml; none if none is declared.

    Raises:
        ParamError: a fin without an entry, an entry without a fin, twice, or a servo that cannot turn so far.
    """
    return tuple(map(DynamixelFin, by_fin("dynamixel.fins", declared, fins)))
