"""Any interface that python-can knows, by its name: slcan, pcan, kvaser, vector, ixxat, ...

Each frame costs a `can.Message`, and an adapter on USB its own time besides: where the kernel has a driver for it
(gs_usb, candleLight, PEAK), socketcan is the better way.
"""

from __future__ import annotations

import contextlib
import errno
import time
from collections.abc import Collection
from typing import Any

import can

from firmware_py.adapters.buses.bus_health import BusHealth
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.buses.slcan_bus import SlcanBus
from firmware_py.adapters.buses.socketcan_bus import InterfaceAbsent
from firmware_py.error_text import one_line, quoted

_RETRY_S = 1.0
"""How often an interface that has failed is opened again, s."""
_STATES = {can.BusState.PASSIVE: "error_passive", can.BusState.ERROR: "error_bus_off"}
_FAILURES = (can.CanError, ValueError, TypeError, OSError, AttributeError, NameError, ImportError)
"""What the interfaces of makers raise where their library, or the adapter, is not there."""


class PythonCanBus:
    """One node on a bus of python-can. An adapter that fails is silence; it is opened again every second.

    Args:
        place: INTERFACE:CHANNEL, or INTERFACE:CHANNEL@BITRATE.
        standard: whether frames with standard ids are received too.

    Raises:
        InterfaceAbsent: no adapter, which may be plugged in later.
        can.CanInitializationError: no such interface; the text says why.
    """

    def __init__(self, place: str, standard: bool = False) -> None:
        self._interface, _, rest = place.partition(":")
        channel, at, bitrate = rest.rpartition("@")
        self._channel, self._bitrate = (channel, bitrate) if at else (rest, "")
        if self._interface not in can.VALID_INTERFACES or not self._channel:
            raise can.CanInitializationError(
                f"write python-can:INTERFACE:CHANNEL@BITRATE with one of: {', '.join(sorted(can.VALID_INTERFACES))}"
            )
        if self._bitrate and not self._bitrate.isdecimal():
            raise can.CanInitializationError(f"{quoted(self._bitrate)} is no bitrate; write bits a second: @500000")
        self._place, self._standard = place, standard
        self.health = BusHealth()
        self.overrun = 0
        """Not known."""
        self._lost: dict[str, int] = {}
        self._t_tried = 0.0
        self._bus: Any = self._opened()

    def __str__(self) -> str:
        """Return the name that `open_bus` knows."""
        return f"python-can:{self._place}"

    @property
    def sound(self) -> bool:
        """Return whether the adapter is there, and its controller on the bus and not error-passive."""
        return self.health.sound

    @property
    def errors(self) -> dict[str, int]:
        """Return error frames by kind, what is wrong now, and what the interface itself counts."""
        return {**self.health.counts(), **self._losses()}

    def fileno(self) -> int:
        """Return the descriptor to wait on; -1 if the interface has none."""
        try:
            return int(self._bus.fileno())
        except (NotImplementedError, AttributeError, can.CanError):
            return -1

    def send_frames(self, frames: Collection[tuple[int, bytes]]) -> int:
        """Send frames; return how many were not taken at once."""
        if self._bus is None and not self._reopened():
            return len(frames)
        not_taken = 0
        for can_id, data in frames:
            extended = can_id < STANDARD
            message = can.Message(arbitration_id=can_id & ~STANDARD, data=data, is_extended_id=extended)
            try:
                self._bus.send(message, 0)
            except (can.CanError, OSError):
                not_taken += 1
        if not_taken:
            self._ask_state()
        return not_taken

    def receive_frames(self, frames: list[tuple[int, bytes]], limit: int) -> None:
        """Append the frames that have arrived; examine at most `limit`.

        Raises:
            OSError: once, when the adapter has failed.
        """
        if self._bus is None and not self._reopened():
            return
        before = len(frames)
        for _ in range(limit):
            try:
                message = self._bus.recv(0)
            except (can.CanError, OSError) as error:
                self._leave()
                raise OSError(errno.ENETDOWN, str(error)) from None
            if message is None:
                break
            self._take(message, frames)
        if not self.health.sound:
            if len(frames) > before:
                self.health.carry(received=True)
            self._ask_state()

    def shutdown(self) -> None:
        """Leave the bus; may be called twice."""
        bus, self._bus = self._bus, None
        self._t_tried = float("inf")
        if bus is not None:
            with contextlib.suppress(*_FAILURES):
                bus.shutdown()

    def _take(self, message: can.Message, frames: list[tuple[int, bytes]]) -> None:
        if message.is_error_frame:
            self.health.hear_kinds(["error_frame"])
            self._ask_state()
        elif not (message.is_remote_frame or message.is_fd):
            identifier = message.arbitration_id
            if message.is_extended_id:
                frames.append((identifier, bytes(message.data)))
            elif self._standard:
                frames.append((identifier | STANDARD, bytes(message.data)))

    def _losses(self) -> dict[str, int]:
        """Return what the interface itself counts, since the start: an adapter that comes back begins at none."""
        now: dict[str, int] = getattr(self._bus, "losses", {})
        return {cause: self._lost.get(cause, 0) + now.get(cause, 0) for cause in {**self._lost, **now}}

    def _ask_state(self) -> None:
        """Ask the controller what it is; interfaces that do not know say that it is active."""
        try:
            state = self._bus.state
        except (NotImplementedError, can.CanError, OSError, AttributeError):
            return
        self.health.set_state(_STATES.get(state, ""))

    def _opened(self) -> can.BusABC:
        more: dict[str, Any] = {"bitrate": int(self._bitrate)} if self._bitrate else {}
        try:
            if self._interface == "slcan":
                return SlcanBus(self._channel, **more)
            return can.Bus(interface=self._interface, channel=self._channel, **more)
        except _FAILURES as error:
            missing = isinstance(error, NameError | ImportError)
            text = "its maker's library is not installed" if missing else one_line(error)
            later = isinstance(error, can.CanInitializationError) or getattr(error, "errno", None)
            kind = InterfaceAbsent if later else can.CanInitializationError
            raise kind(f"{self._interface}: {text}") from None

    def _reopened(self) -> bool:
        now = time.monotonic()
        if now - self._t_tried < _RETRY_S:
            return False
        self._t_tried = now
        try:
            self._bus = self._opened()
        except can.CanError:
            return False
        self.health.carry(received=False)
        return True

    def _leave(self) -> None:
        """Give up an adapter that has failed."""
        self._lost = self._losses()
        self.shutdown()
        self._t_tried = time.monotonic()
        self.health.fail()
