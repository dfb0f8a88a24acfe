"""SocketCAN, the CAN buses of the Linux kernel: python-can's interface with a way past `can.Message`."""

from __future__ import annotations

import errno
import socket
import struct
from collections.abc import Collection

import can
from can.interfaces.socketcan import SocketcanBus
from can.typechecking import CanFilter

from firmware_py.adapters.buses import receive_buffer
from firmware_py.adapters.buses.bus_health import BusHealth
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.error_text import quoted

_FRAME = struct.Struct("=IB3x8s")
_EXTENDED = socket.CAN_EFF_FLAG
_EXTENDED_ONLY: list[CanFilter] = [{"can_id": 0, "can_mask": 0, "extended": True}]
_ALL: list[CanFilter] = [{"can_id": 0, "can_mask": 0}]
_DOWN = (errno.ENETDOWN, errno.ENODEV, errno.ENXIO)


class InterfaceAbsent(can.CanInitializationError):
    """There is no such interface now, or it is down."""


class SocketCanFrameBus(SocketcanBus):
    """One node on a CAN interface; it does not receive its own frames.

    While the interface is down nothing is sent or received; when it is up again, frames flow again. One that is plugged
    in anew is another one: `AwaitedBus` opens it.

    The kernel's error frames are counted by kind, tell `health`, and are not handed on.

    Bare frames bypass `can.Message`, which costs about as much as everything else that a frame costs here.

    Args:
        interface: its name.
        standard: whether frames with standard ids are received too; else the kernel keeps them back.

    Raises:
        can.CanInitializationError: no such interface, or it is down; the text says how to make it.
    """

    def __init__(self, interface: str, standard: bool = False) -> None:
        _check(interface)
        self.health = BusHealth()
        super().__init__(channel=interface, can_filters=_ALL if standard else _EXTENDED_ONLY)
        self.channel_info = f"socketcan:{interface}"
        receive_buffer.enlarge(self.socket)

    @property
    def sound(self) -> bool:
        """Return whether the interface is up, and the controller on the bus and not error-passive."""
        return self.health.sound

    @property
    def errors(self) -> dict[str, int]:
        """Return error frames by kind, and what is wrong now."""
        return self.health.counts()

    @property
    def overrun(self) -> int:
        """Return how many frames, one's own included, the kernel had no room for."""
        return receive_buffer.overrun(self.socket)

    def send_frames(self, frames: Collection[tuple[int, bytes]]) -> int:
        """Send frames; return how many the kernel did not take at once."""
        not_taken = 0
        for can_id, data in frames:
            identifier = can_id | _EXTENDED if can_id < STANDARD else can_id & 0x7FF
            try:
                self.socket.send(_FRAME.pack(identifier, len(data), data), socket.MSG_DONTWAIT)
            except OSError as error:
                not_taken += 1
                self._note(error)
        if not self.health.sound and not_taken < len(frames):
            self.health.carry(received=False)
        return not_taken

    def receive_frames(self, frames: list[tuple[int, bytes]], limit: int) -> None:
        """Append the frames that have arrived; examine at most `limit`.

        Raises:
            OSError: once, after the interface went down.
        """
        receive, before = self.socket.recv, len(frames)
        try:
            for _ in range(limit):
                identifier, length, data = _FRAME.unpack(receive(_FRAME.size, socket.MSG_DONTWAIT))
                if identifier >> 29 == 0b100:  # extended, not a remote request, not an error
                    frames.append((identifier & 0x1FFFFFFF, data[:length]))
                elif identifier < 0x800:
                    frames.append((identifier | STANDARD, data[:length]))
                elif identifier & socket.CAN_ERR_FLAG:
                    self.health.hear_error(identifier, data)
        except BlockingIOError:
            pass
        except OSError as error:
            self._note(error)
            raise
        if not self.health.sound and len(frames) > before:
            self.health.carry(received=True)

    def _note(self, error: OSError) -> None:
        """Take why the kernel took no frame: a full queue is no fault of the interface."""
        if error.errno in _DOWN:
            self.health.fail()


def _check(interface: str) -> None:
    """Raise what is wrong with an interface in words: python-can would log it, and raise a bare number."""
    up = f"ip link set {interface} up" + ("" if interface.startswith("vcan") else " type can bitrate 1000000")
    if not interface:
        raise can.CanInitializationError("which interface? write socketcan:IFACE")
    try:
        with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as probe:
            probe.bind((interface,))
            down = probe.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) == errno.ENETDOWN
    except OSError as error:
        if error.errno == errno.EAFNOSUPPORT:
            text = "this kernel has no CAN; load it (modprobe can_raw), or take another bus"
        elif error.errno == errno.ENODEV and _is_there(interface):
            text = f"{quoted(interface)} is no CAN interface"
        elif error.errno == errno.ENODEV:
            make = f"ip link add dev {interface} type vcan; ip link set {interface} up"
            text = f"there is no interface {quoted(interface)}; a virtual one is made by: {make}"
            raise InterfaceAbsent(text) from error
        else:
            text = str(error)
        raise can.CanInitializationError(text) from error
    if down:
        raise InterfaceAbsent(f"the interface is down; bring it up: {up}")


def _is_there(interface: str) -> bool:
    """Return whether there is an interface of any kind; to list all takes a netlink socket, which a service may not."""
    try:
        return socket.if_nametoindex(interface) > 0
    except OSError:
        return False
