"""A simulated servo of the X series: instructions in, answers out. It obeys its control table, not our driver.

Source: Robotis e-Manual, XM430-W350. What it keeps without power (below address 64) is locked while its torque is on;
what is read-only, reserved or out of range is refused with the maker's error numbers; a fault of its `shutdown` mask
takes its torque away until a reboot; the watchdog stops it, and locks its goals until it is set to 0.
"""

from __future__ import annotations

import math

from firmware_py.marine import clip
from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial import dynamixel_x as x
from firmware_py.wire.serial.dynamixel import Instruction, Status
from firmware_py.wire.serial.dynamixel_x import HardwareError, Item

XM430_W350, FIRMWARE = 1020, 48
BOOT_S = 0.3
"""So long it hears nothing after its power came, s."""
FAILED, UNKNOWN, RANGE, TOO_SHORT, LIMIT, ACCESS = 1, 2, 4, 5, 6, 7
"""Error numbers of answers, see `dynamixel.ERRORS`."""
_KEPT = 64
"""What is below this address is kept without power."""
_LENGTH = 147
_POWER_ON = {
    x.STATUS_RETURN_LEVEL: 2,
    x.PRESENT_INPUT_VOLTAGE: 120,
    x.PRESENT_TEMPERATURE: 30,
}
_FACTORY = {
    x.MODEL_NUMBER: XM430_W350,
    x.FIRMWARE_VERSION: FIRMWARE,
    x.ID: 1,
    x.BAUD_RATE: 1,
    x.RETURN_DELAY_TIME: 250,
    x.OPERATING_MODE: x.POSITION_MODE,
    x.MAX_POSITION_LIMIT: x.COUNTS_PER_TURN - 1,
    x.SHUTDOWN: int(HardwareError.OVERLOAD | HardwareError.ELECTRICAL_SHOCK | HardwareError.OVERHEATING),
}
_LARGEST = {
    x.ID: 252,
    x.BAUD_RATE: 7,
    x.RETURN_DELAY_TIME: 254,
    x.DRIVE_MODE: 15,
    x.OPERATING_MODE: 16,
    x.MAX_POSITION_LIMIT: x.COUNTS_PER_TURN - 1,
    x.MIN_POSITION_LIMIT: x.COUNTS_PER_TURN - 1,
    x.SHUTDOWN: 63,
    x.TORQUE_ENABLE: 1,
    x.STATUS_RETURN_LEVEL: 2,
    x.BUS_WATCHDOG: 127,
    x.PROFILE_ACCELERATION: 32767,
    x.PROFILE_VELOCITY: 32767,
    x.GOAL_POSITION: x.COUNTS_PER_TURN - 1,
}
"""The items that are written here, and the greatest value of each; gains and other goals are not simulated."""


class Servo:
    """A servo.

    Attributes:
        table: its control table.
        position: where its horn is, counts: set by whoever turns it.
    """

    def __init__(self, number: int, position: int = x.MIDDLE) -> None:
        self.table = bytearray(_LENGTH)
        for item, value in (_FACTORY | {x.ID: number}).items():
            self._put(item, value)
        self.position = position
        self._target, self._t, self._t_heard, self._t_up = float(position), math.inf, -math.inf, -math.inf
        self._forget()

    @property
    def id(self) -> int:
        """Return its id."""
        return self.get(x.ID)

    def get(self, item: Item) -> int:
        """Return a number of its table."""
        return int.from_bytes(self.table[item.address : item.address + item.length], "little")

    def power_on(self, t: float) -> None:
        """Start at t, s: what it does not keep is forgotten."""
        self._forget()
        self._t_up = t + BOOT_S

    def fail(self, error: HardwareError) -> None:
        """Have a fault; one of its shutdown mask takes its torque away."""
        self._put(x.HARDWARE_ERROR_STATUS, self.get(x.HARDWARE_ERROR_STATUS) | error)
        if error & self.get(x.SHUTDOWN):
            self._put(x.TORQUE_ENABLE, 0)

    def goal(self, t: float) -> float | None:
        """Return where its motor turns it at t, s, counts; None: it has no power. It goes there by its profile."""
        step, self._t = max(t - self._t, 0.0), t
        watchdog = self.get(x.BUS_WATCHDOG)
        if not self.get(x.TORQUE_ENABLE):
            self._target = float(self.position)
            return None
        if 0 < watchdog < x.WATCHDOG_STRUCK and t - self._t_heard > watchdog * x.WATCHDOG_STEP:
            self._put(x.BUS_WATCHDOG, x.WATCHDOG_STRUCK)
            self._put(x.PROFILE_VELOCITY, 0)
            self._put(x.GOAL_POSITION, round(self._target))
        speed = self.get(x.PROFILE_VELOCITY) * x.VELOCITY_STEP / (2.0 * math.pi) * x.COUNTS_PER_TURN
        way = self.get(x.GOAL_POSITION) - self._target
        self._target += clip(way, -speed * step, speed * step) if speed else way
        return self._target

    def hears(self, t: float) -> bool:
        """Return whether it has started, at t, s; any instruction on the line holds its watchdog."""
        if t < self._t_up:
            return False
        self._t_heard = t
        return True

    def read(self, address: int, length: int) -> Status:
        """Return its answer to a read."""
        self._put(x.PRESENT_POSITION, self.position % 2**32)
        if address + length > _LENGTH:
            return self._status(TOO_SHORT)
        return self._status(0, bytes(self.table[address : address + length]))

    def write(self, address: int, content: bytes) -> Status:
        """Take numbers, all or none of them; return its answer."""
        items = [item for item in _LARGEST if address <= item.address and _end(item) <= address + len(content)]
        if sum(item.length for item in items) != len(content):
            return self._status(ACCESS)  # something read-only or reserved, or a piece of a number
        values = {item: content[item.address - address : _end(item) - address] for item in items}
        for item, value in values.items():
            if error := self._refused(item, int.from_bytes(value, "little")):
                return self._status(error)
        for item, value in values.items():
            self._set(item, int.from_bytes(value, "little"))
        return self._status(0)

    def obey(self, asked: Instruction, t: float) -> Status | None:
        """Return the answer to an instruction for it alone, at t, s; None for none."""
        answer = self._obeyed(asked, t)
        level = self.get(x.STATUS_RETURN_LEVEL)
        silent = asked.code != dynamixel.PING and (not level or (level == 1 and asked.code != dynamixel.READ))
        return None if silent else answer

    def _obeyed(self, asked: Instruction, t: float) -> Status:
        if asked.code == dynamixel.PING:
            return self._status(0, bytes((*self.table[:2], self.table[6])))
        if asked.code == dynamixel.REBOOT:
            answer = self._status(0)
            self.power_on(t)
            return answer
        if asked.code == dynamixel.READ and len(asked.parameters) == 4:
            return self.read(*(int.from_bytes(asked.parameters[k : k + 2], "little") for k in (0, 2)))
        if asked.code == dynamixel.WRITE and len(asked.parameters) > 2:
            return self.write(int.from_bytes(asked.parameters[:2], "little"), asked.parameters[2:])
        return self._status(UNKNOWN)

    def _refused(self, item: Item, value: int) -> int:
        """Return the error number with which a value is refused; 0 if it is taken."""
        if item.address < _KEPT and self.get(x.TORQUE_ENABLE):
            return ACCESS
        if item == x.GOAL_POSITION:
            if self.get(x.BUS_WATCHDOG) == x.WATCHDOG_STRUCK:
                return RANGE
            return 0 if self.get(x.MIN_POSITION_LIMIT) <= value <= self.get(x.MAX_POSITION_LIMIT) else LIMIT
        if item == x.TORQUE_ENABLE and value and self.get(x.HARDWARE_ERROR_STATUS) & self.get(x.SHUTDOWN):
            return FAILED
        return RANGE if value > _LARGEST[item] else 0

    def _set(self, item: Item, value: int) -> None:
        if item == x.TORQUE_ENABLE and value and not self.get(item):
            self._target = float(self.position)
        self._put(item, value)

    def _status(self, error: int, content: bytes = b"") -> Status:
        alert = 0x80 if self.get(x.HARDWARE_ERROR_STATUS) else 0
        return Status(self.id, error | alert, content)

    def _put(self, item: Item, value: int) -> None:
        self.table[item.address : _end(item)] = value.to_bytes(item.length, "little")

    def _forget(self) -> None:
        self.table[_KEPT:] = bytes(_LENGTH - _KEPT)
        for item, value in _POWER_ON.items():
            self._put(item, value)
        self._put(x.GOAL_POSITION, self.position % 2**32)


def _end(item: Item) -> int:
    return item.address + item.length
