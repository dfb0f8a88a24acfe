"""What the autopilot knows of one servo: how far its set-up is, whether it lives, whether its motor has power."""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeAlias

from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial import dynamixel_x as x
from firmware_py.wire.serial.dynamixel import Status
from firmware_py.wire.serial.dynamixel_fins import DynamixelFin, DynamixelParams
from firmware_py.wire.serial.dynamixel_x import HardwareError, Item

_TRIES = 3
_AGAIN_S = 0.5
"""Pause before a servo that did not answer, or could not be set up, is asked again, s."""
_REBOOT_S = 3.0
"""Pause between two reboots of a servo that a fault has shut down, s."""
_SETTLE_S = 0.3
"""So long a change of torque may take until the servo must tell it, s."""
_TWICE = 3
"""So many times in succession two answers to one question are two servos under one id; once is an echo of the line."""
_ABSENT = "absent"
_SETTINGS = Item(x.RETURN_DELAY_TIME.address, 3)
"""Return delay, drive mode, operating mode."""
_LIMITS = Item(x.MAX_POSITION_LIMIT.address, 8)
_PROFILE = Item(x.PROFILE_VELOCITY.address - 2, 6)
"""The velocity with what stands before it."""
_PONG = 3
"""Bytes: model and firmware."""
_SHUTDOWN_AND_TORQUE = Item(x.SHUTDOWN.address, 2)

TORQUE, FAULT = Item(x.TORQUE_ENABLE.address, 2), Item(x.STATUS_RETURN_LEVEL.address, 3)
"""With the LED behind the torque, and what stands before the fault: these answers have lengths that no others have that
several servos are asked for, so that one that comes too late is not taken for one to the next question.
"""

Talk: TypeAlias = Generator[bytes, Status | None, None]
"""Questions to one servo: yields a packet, and is sent the answer, or None if there was none in time."""


class SetUpError(Exception):
    """A servo that cannot be set up; the text is the cause, as it is counted."""


class ServoLink:
    """One servo. It is set up when it is first heard, was lost, or has restarted.

    What it keeps without power is read first, and written only where it differs: that wears its memory, and its motor
    must be without power meanwhile.

    Attributes:
        counts: what went wrong, by cause.
        ready: whether it is set up and answers.
        known: whether it was ever heard.
        seen: whether it answers, set up or not.
        restarted: whether it has restarted since this was last asked for.
        doubled: whether two servos answer under its id.
        torque: whether its motor has power, as far as is known.
        due: bytes of the answer to its question.
        t_quiet: until then it may owe an answer, and is asked nothing alone, s.
    """

    def __init__(self, fin: DynamixelFin, params: DynamixelParams) -> None:
        self.fin, self.id, self._params = fin, fin.params.id, params
        self.counts: dict[str, int] = {}
        self.restarted = self.doubled = self.torque = False
        self.ready = self.known = self.seen = self._watched = self._forgets = self._profile_told = False
        self._wanted, self._t_told = False, 0.0
        self._alert, self._error, self._shutdown = False, HardwareError(0), HardwareError(0)
        self._t_heard = self._t_again = self._t_reboot = self.t_quiet = 0.0
        self._talk: Talk | None = None
        self._packet = b""
        self._position = self.due = 0
        self._answers = self._twice = 0

    @property
    def faulty(self) -> bool:
        """Return whether a fault has shut it down. An alert alone does not tell: it may be of low voltage."""
        return bool(self._error & self._shutdown)

    def begin(self, t: float, pause: float = 0.0) -> None:
        """Set it up anew, at the earliest so long after t, s."""
        self.ready = self.seen = False
        self._talk, self._packet, self._t_again = None, b"", t + pause

    def wait_for(self, t: float) -> bool:
        """Return whether it was heard lately; notice at t, s, that it has fallen silent."""
        if self.seen and t - self._t_heard > self._params.timeout:
            self.count("timeouts")
            self.begin(t)
        return self.seen

    def question(self, t: float, *, looking: bool = False) -> bytes:
        """Return what it alone must be asked or told at t, s; empty for nothing.

        Args:
            t: now, s.
            looking: only look whether it is there; set up nothing.
        """
        self.wait_for(t)
        if self._talk is None and t >= self._t_again:
            self._talk = self._next(t, looking)
            self._packet = next(self._talk, b"") if self._talk else b""
        return self._packet if t >= self.t_quiet else b""

    def answer(self, answer: Status | None, t: float) -> None:
        """Take the answer to its question; None: it did not come in time."""
        if self._talk is None:
            return
        try:
            self._packet = self._talk.send(answer)
        except StopIteration:
            self._talk, self._packet = None, b""
        except SetUpError as error:
            if str(error) != _ABSENT:
                self.count("set_ups_failed")
                self.count(str(error))
            self.begin(t, _AGAIN_S)

    def hear(self, answer: Status, t: float) -> None:
        """Take what each of its answers tells beside."""
        self._t_heard = t
        self._answers += 1
        if not answer.alert:
            self._error = HardwareError(0)
        elif not self._error:
            self._alert = True
        self._alert &= answer.alert

    def hear_position(self, counts: int) -> float:
        """Take where it is; return the angle of its fin, rad."""
        self._position = counts
        return self.fin.angle(counts)

    def hear_state(self, item: Item, value: int, t: float) -> None:
        """Take what it told of its state at t, s: a restart switches off its watchdog, a fault its torque."""
        if item == x.BUS_WATCHDOG and value == self._watchdog:
            self._profile_told = False
        elif item == x.BUS_WATCHDOG:
            if value == x.WATCHDOG_STRUCK:
                self.count("watchdog_struck")
            if value or not self._forgets:
                self.begin(t)
        elif item == TORQUE and t - self._t_told > _SETTLE_S:
            on = bool(value & 0xFF)
            if self.torque and not on:
                self.count("torque_lost")
                self.begin(t)  # it may have restarted: no power until its speed and its watchdog are set again
            self.torque = on
        elif item == FAULT:
            self._take_error(value >> 16)

    def steer(self, wanted: bool, t: float) -> bool:
        """Take whether its motor is to have power at t, s; return whether that must be told.

        One that is lost may still hear: it can lose its power, and does not get it. One that gets power must be told
        its speed with it: it may have restarted, and not been found out yet.
        """
        self._wanted = wanted
        if not self.ready:
            self.torque &= wanted
            return not wanted
        if wanted == self.torque or (wanted and self.faulty):
            return False
        self.torque, self._t_told = wanted, t
        self._profile_told |= wanted
        return True

    def goal(self, angle: float, begins: bool) -> int:
        """Return the goal for a fin angle, rad; of a motor that `begins` to have power, where it is, lest it leap."""
        low, high = self.fin.ends
        return min(max(self._position, low), high) if begins else self.fin.counts(angle)

    def judge_answers(self) -> None:
        """Judge how often it has answered one question."""
        self._twice = self._twice + 1 if self._answers > 1 else 0
        self.doubled = self._twice >= _TWICE
        self._answers = 0

    def count(self, cause: str) -> None:
        """Count what went wrong."""
        self.counts[cause] = self.counts.get(cause, 0) + 1

    @property
    def _watchdog(self) -> int:
        return round(self._params.patience / x.WATCHDOG_STEP)

    def _next(self, t: float, looking: bool) -> Talk | None:
        """Return what is to be asked or told next, if anything."""
        if looking:
            return None if self.seen else self._sought()
        if not self.ready:
            return self._set_up()
        if self._alert:
            return self._error_read()
        if self._wanted and self.faulty and not self.torque and t - self._t_reboot > _REBOOT_S:
            self._t_reboot = t
            return self._rebooted(t)
        return None

    def _sought(self) -> Talk:
        self.due = _PONG
        pong = yield dynamixel.ping(self.id)
        if pong is None or pong.refused:
            raise SetUpError(_ABSENT)
        model = int.from_bytes(pong.parameters[:2], "little")
        if model not in x.MODELS:
            raise SetUpError(f"unknown_model_{model}")
        self.seen = True

    def _set_up(self) -> Talk:
        yield from self._sought()
        answering = self._told(x.STATUS_RETURN_LEVEL, 2)
        watchdog = yield from self._read(x.BUS_WATCHDOG, before=answering)
        self.known = True
        if self._watched and not watchdog:
            yield from self._restart_or_not()
        both = yield from self._read(_SHUTDOWN_AND_TORQUE)
        self._shutdown, torque = HardwareError(both & 0xFF), bool(both >> 8)
        yield from self._error_read()
        if (yield from self._kept_differs()):
            torque = False
        unlocked = self._told(x.BUS_WATCHDOG, 0)  # where it has struck, goals and profile are locked until then
        running = self._told(x.PROFILE_VELOCITY, self.fin.profile_velocity) + self._told(x.BUS_WATCHDOG, self._watchdog)
        if (yield from self._read(x.BUS_WATCHDOG, before=unlocked + running)) != self._watchdog:
            raise SetUpError("refused")
        self._position = yield from self._read(x.PRESENT_POSITION, signed=True)
        self.torque, self.ready, self._watched = torque, True, True

    def _restart_or_not(self) -> Talk:
        """Find out why a watchdog that was set is off: a restart makes the servo forget its profile too."""
        profile = (yield from self._read(_PROFILE)) >> 16
        self._watched, self._forgets = False, profile == self.fin.profile_velocity and not self._profile_told
        self.restarted = not self._forgets
        self.count("watchdog_lost" if self._forgets else "restarts")

    def _kept_differs(self) -> Generator[bytes, Status | None, bool]:
        """Set what it keeps without power; return whether anything had to be written."""
        low, high = self.fin.ends
        found = yield from self._read(_SETTINGS)
        delay, drive_mode = round(self._params.return_delay / x.RETURN_DELAY_STEP), found >> 8 & x.KEPT_DRIVE_MODE
        settings, limits = delay | drive_mode << 8 | x.POSITION_MODE << 16, high | low << 32
        differing = [] if found == settings else [(_SETTINGS, settings)]
        if (yield from self._read(_LIMITS)) != limits:
            differing.append((_LIMITS, limits))
        if differing:
            self.count("settings_written")
            yield from self._write(x.TORQUE_ENABLE, 0)
        for item, value in differing:
            yield from self._write(item, value)
        return bool(differing)

    def _error_read(self) -> Talk:
        self._take_error((yield from self._read(x.HARDWARE_ERROR_STATUS)))

    def _take_error(self, value: int) -> None:
        error = HardwareError(value)
        for one in error & ~self._error:
            self.count(f"error_{(one.name or 'unknown').lower()}")
        self._error, self._alert = error, False
        if error & self._shutdown:
            self.torque = False

    def _rebooted(self, t: float) -> Talk:
        self.due = 0
        yield dynamixel.reboot(self.id)
        self.count("reboots")
        self.begin(t, _AGAIN_S)

    def _read(self, item: Item, *, signed: bool = False, before: bytes = b"") -> Generator[bytes, Status | None, int]:
        """Read a number, behind packets that need no answer."""
        answer = yield from self._asked(before + x.read(self.id, item), item.length)
        return x.number(answer, item, signed)

    def _write(self, item: Item, value: int) -> Talk:
        yield from self._asked(x.write(self.id, item, value), 0)

    def _told(self, item: Item, value: int) -> bytes:
        """Return the packet that sets a number without an answer, which no servo gives to a sync write."""
        return dynamixel.sync_write(*item, [(self.id, value.to_bytes(item.length, "little"))])

    def _asked(self, packet: bytes, due: int) -> Generator[bytes, Status | None, Status]:
        self.due = due
        for _ in range(_TRIES):
            answer = yield packet
            if answer is not None:
                if answer.refused:
                    raise SetUpError("refused")
                return answer
        raise SetUpError("silent")
