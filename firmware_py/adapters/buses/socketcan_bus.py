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
from firmware_py.error_text import quoted

_FRAME = struct.Struct("=IB3x8s")
_EXTENDED = socket.CAN_EFF_FLAG
_EXTENDED_ONLY: list[CanFilter] = [{"can_id": 0, "can_mask": 0, "extended": True}]


_ERRORS = (
    (0x001, "error_tx_timeout"),
    (0x002, "error_arbitration_lost"),
    (0x008, "error_protocol"),
    (0x010, "error_transceiver"),
    (0x020, "error_no_acknowledge"),
    (0x040, "error_bus_off"),
    (0x080, "error_bus"),
    (0x100, "error_restarted"),
)
_CONTROLLER = 0x004
_CONTROLLER_STATES = (
    (0x03, "error_controller_overflow"),
    (0x0C, "error_warning"),
    (0x30, "error_passive"),
    (0x40, "error_active_again"),
)
"""Linux, linux/can/error.h: classes in the id, and the controller's problems in the second byte."""


def error_kinds(identifier: int, data: bytes) -> list[str]:
    """Return what an error frame of the kernel reports; mostly one kind."""
    kinds = [name for bit, name in _ERRORS if identifier & bit]
    if identifier & _CONTROLLER:
        kinds += [name for bits, name in _CONTROLLER_STATES if data[1] & bits] or ["error_controller"]
    return kinds or ["error_other"]


class InterfaceAbsent(can.CanInitializationError):
    """There is no such interface now, or it is down."""


class SocketCanFrameBus(SocketcanBus):
    """One node on a CAN interface; it receives extended ids only, and not its own frames.

    While the interface is down nothing is sent or received; when it is up again, frames flow again.

    The kernel's error frames are counted by kind, and not handed on.

    Bare frames bypass `can.Message`, which costs about as much as everything else that a frame costs here.

    Raises:
        can.CanInitializationError: no such interface, or it is down; the text says how to make it.
    """

    def __init__(self, interface: str) -> None:
        _check(interface)
        self.errors: dict[str, int] = {}
        """Error frames by kind, as `error_kinds` names them."""
        super().__init__(channel=interface, can_filters=_EXTENDED_ONLY)
        self.channel_info = f"socketcan:{interface}"
        receive_buffer.enlarge(self.socket)

    @property
    def overrun(self) -> int:
        """Return how many frames, one's own included, the kernel had no room for."""
        return receive_buffer.overrun(self.socket)

    def send_frames(self, frames: Collection[tuple[int, bytes]]) -> int:
        """Send frames with extended ids; return how many the kernel did not take at once."""
        not_taken = 0
        for can_id, data in frames:
            try:
                self.socket.send(_FRAME.pack(can_id | _EXTENDED, len(data), data), socket.MSG_DONTWAIT)
            except OSError:
                not_taken += 1
        return not_taken

    def receive_frames(self, frames: list[tuple[int, bytes]], limit: int) -> None:
        """Append the frames with extended ids that have arrived; examine at most `limit`.

        Raises:
            OSError: once, after the interface went down.
        """
        receive = self.socket.recv
        for _ in range(limit):
            try:
                identifier, length, data = _FRAME.unpack(receive(_FRAME.size, socket.MSG_DONTWAIT))
            except BlockingIOError:
                return
            if identifier >> 29 == 0b100:  # extended, not a remote request, not an error
                frames.append((identifier & 0x1FFFFFFF, data[:length]))
            elif identifier & socket.CAN_ERR_FLAG:
                for kind in error_kinds(identifier, data):
                    self.errors[kind] = self.errors.get(kind, 0) + 1


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
        elif error.errno == errno.ENODEV and interface in (name for _, name in socket.if_nameindex()):
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
