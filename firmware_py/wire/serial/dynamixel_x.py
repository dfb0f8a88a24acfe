"""Dynamixel X series and MX of protocol 2.0: the control table, and what its numbers mean.

Source: Robotis e-Manual, control tables of each of `MODELS`; these addresses are the same for all. A turn has 4096
counts; 2048 is the middle, 0 rad, where no homing offset is set; angles grow counter-clockwise as seen from the horn,
unless the drive mode reverses them. Of what is set, the servo forgets all at a loss of supply but the addresses below
64, which it takes only while its torque is off.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial.dynamixel import Status
from firmware_py.wire.serial.stream import SentenceError


class Item(NamedTuple):
    """An entry of the control table: first address and length, bytes."""

    address: int
    length: int


MODELS = frozenset({30, 311, 321, *range(1000, 1241, 10), 1001, 1011, 1101, 1111, 1270, 1280, 1310})
"""Numbers of the models with this table, as a ping tells: MX-28, -64, -106, then XH430-W350 to XW540-H260."""
MODEL_NUMBER = Item(0, 2)
FIRMWARE_VERSION = Item(6, 1)
ID = Item(7, 1)
BAUD_RATE = Item(8, 1)
RETURN_DELAY_TIME = Item(9, 1)
"""Time before an answer, in 2 us."""
DRIVE_MODE = Item(10, 1)
OPERATING_MODE = Item(11, 1)
"""3: position, 4: position over many turns."""
POSITION_MODE = 3
KEPT_DRIVE_MODE = 0b10
"""Bit of a servo that follows another one; the others turn the sense of rotation, or the meaning of profiles."""
HOMING_OFFSET = Item(20, 4)
MAX_POSITION_LIMIT = Item(48, 4)
MIN_POSITION_LIMIT = Item(52, 4)
SHUTDOWN = Item(63, 1)
TORQUE_ENABLE = Item(64, 1)
STATUS_RETURN_LEVEL = Item(68, 1)
"""0: answers to pings only, 1: to reads too, 2: to all."""
HARDWARE_ERROR_STATUS = Item(70, 1)
BUS_WATCHDOG = Item(98, 1)
"""Silence of the host after which the servo stops, in 20 ms; 0: never. It reads 255 after it has struck."""
PROFILE_ACCELERATION = Item(108, 4)
PROFILE_VELOCITY = Item(112, 4)
"""Of its way to a goal, in 0.229 turns a minute; 0: as fast as it can. Where the servo restarts it is 0."""
GOAL_POSITION = Item(116, 4)
MOVING = Item(122, 1)
PRESENT_CURRENT = Item(126, 2)
"""XL430 and XC430 have the load here, in 0.1 %."""
PRESENT_VELOCITY = Item(128, 4)
PRESENT_POSITION = Item(132, 4)
PRESENT_INPUT_VOLTAGE = Item(144, 2)
"""In 0.1 V."""
PRESENT_TEMPERATURE = Item(146, 1)
"""In °C."""

WATCHDOG_STRUCK = 255
WATCHDOG_STEP, RETURN_DELAY_STEP = 20e-3, 2e-6
"""Units of these two, s."""
COUNTS_PER_TURN = 4096
MIDDLE = 2048
VELOCITY_STEP = 0.229 / 60.0 * 2.0 * math.pi
"""Unit of velocities, rad/s."""
_RADIANS_PER_COUNT = 2.0 * math.pi / COUNTS_PER_TURN


class HardwareError(enum.IntFlag):
    """Faults that stop a servo until it is rebooted: bits of its hardware error status."""

    INPUT_VOLTAGE = 1 << 0
    OVERHEATING = 1 << 2
    MOTOR_ENCODER = 1 << 3
    ELECTRICAL_SHOCK = 1 << 4
    OVERLOAD = 1 << 5


class Position(NamedTuple):
    """Where a servo is, rad from its middle; `usable` is False if it reports a fault of its hardware or an error."""

    servo: int
    angle: float
    usable: bool


def angle(counts: int) -> float:
    """Return the angle of a position, rad from the middle."""
    return (counts - MIDDLE) * _RADIANS_PER_COUNT


def counts(angle: float) -> int:
    """Return the position of an angle, rad from the middle.

    Raises:
        ValueError: if it is not finite.
    """
    return MIDDLE + round(angle / _RADIANS_PER_COUNT)


def enable_torque(servo: int, enabled: bool) -> bytes:
    """Return the packet that has a servo hold its position, or go limp."""
    return write(servo, TORQUE_ENABLE, int(enabled))


def set_return_delay(servo: int, delay: float) -> bytes:
    """Return the packet that sets how long a servo waits before it answers, s, in steps of 2 us up to 508 us."""
    return write(servo, RETURN_DELAY_TIME, _steps(delay, RETURN_DELAY_STEP, 254))


def set_bus_watchdog(servo: int, silence: float) -> bytes:
    """Return the packet that stops a servo after so much silence, s, in steps of 20 ms up to 2.54 s; 0 for never.

    One that has been stopped takes no goal until 0 is set.
    """
    return write(servo, BUS_WATCHDOG, _steps(silence, WATCHDOG_STEP, 127))


def write(servo: int, item: Item, value: int) -> bytes:
    """Return the packet that sets a number of the control table."""
    return dynamixel.write(servo, item.address, _bytes(value, item.length))


def read(servo: int, item: Item) -> bytes:
    """Return the packet that asks for a number of the control table."""
    return dynamixel.read(servo, *item)


def write_positions(goals: Iterable[tuple[int, float]]) -> bytes:
    """Return the packet that sends several servos to their goals: (id, angle in rad) of each."""
    data = [(servo, _bytes(counts(angle), GOAL_POSITION.length)) for servo, angle in goals]
    return dynamixel.sync_write(*GOAL_POSITION, data)


def read_positions(servos: Sequence[int], fast: bool = False) -> bytes:
    """Return the packet that asks servos where they are; `fast` for one answer (firmware 45, for X330 46, or newer)."""
    return dynamixel.sync_read(servos, *PRESENT_POSITION, fast=fast)


def number(answer: Status, item: Item, signed: bool = True) -> int:
    """Return the number of an answer to `read`.

    Raises:
        SentenceError: if the answer is of another length.
    """
    if len(answer.parameters) != item.length:
        text = f"{len(answer.parameters)} bytes from servo {answer.id}: must be {item.length}"
        raise SentenceError(f"{text}; {answer.refused}" if answer.refused else text)
    return int.from_bytes(answer.parameters, "little", signed=signed)


def positions(answer: Status) -> tuple[Position, ...]:
    """Return the positions of an answer to `read_positions`: of one servo, or of all if it was fast.

    Raises:
        SentenceError: if the answer has another form.
    """
    return tuple(
        [
            Position(one.id, angle(number(one, PRESENT_POSITION)), one.error == 0)
            for one in dynamixel.split(answer, PRESENT_POSITION.length)
        ]
    )


def _steps(value: float, step: float, most: int) -> int:
    steps = round(value / step)
    if not 0 <= steps <= most:
        raise ValueError(f"{value:g} s: must be in [0, {most * step:g}]")
    return steps


def _bytes(value: int, length: int) -> bytes:
    try:
        return value.to_bytes(length, "little", signed=value < 0)
    except OverflowError:
        raise ValueError(f"{value}: must fit into {length} bytes") from None
