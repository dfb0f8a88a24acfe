"""SocketCAN, the CAN buses of the Linux kernel: python-can's interface with a way past `can.Message`."""

from __future__ import annotations

import errno
import socket
import struct

import can
from can.interfaces.socketcan import SocketcanBus
from can.typechecking import CanFilter

from firmware_py.adapters.buses import receive_buffer

_FRAME = struct.Struct("=IB3x8s")
_EXTENDED = socket.CAN_EFF_FLAG
_EXTENDED_ONLY: list[CanFilter] = [{"can_id": 0, "can_mask": 0, "extended": True}]


class SocketCanFrameBus(SocketcanBus):
    """One node on a CAN interface; it receives extended ids only, and not its own frames.

    While the interface is down nothing is sent or received; when it is up again, frames flow again.

    Bare frames bypass `can.Message`, which costs about as much as everything else that a frame costs here.

    Raises:
        can.CanInitializationError: no such interface, or it is down; the text says how to make it.
    """

    def __init__(self, interface: str) -> None:
        _check(interface)
        super().__init__(channel=interface, can_filters=_EXTENDED_ONLY, ignore_rx_error_frames=True)
        self.channel_info = f"socketcan:{interface}"
        receive_buffer.enlarge(self.socket)

    @property
    def overrun(self) -> int:
        """Return how many frames, one's own included, the kernel had no room for."""
        return receive_buffer.overrun(self.socket)

    def send_frame(self, can_id: int, data: bytes) -> None:
        """Send a frame with an extended id; raise OSError if the kernel does not take it at once."""
        self.socket.send(_FRAME.pack(can_id | _EXTENDED, len(data), data), socket.MSG_DONTWAIT)

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
            text = f"{interface!r} is no CAN interface"
        elif error.errno == errno.ENODEV:
            make = f"ip link add dev {interface} type vcan; ip link set {interface} up"
            text = f"there is no interface {interface!r}; a virtual one is made by: {make}"
        else:
            text = str(error)
        raise can.CanInitializationError(text) from error
    if down:
        raise can.CanInitializationError(f"the interface is down; bring it up: {up}")
