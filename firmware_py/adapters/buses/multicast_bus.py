"""CAN over UDP multicast: the buses that ArduPilot's SITL, AP_Periph, libcanard and pydronecan call `mcast:N`.

A frame is a datagram to 239.65.82.N, port 57732, all little-endian: magic 0x2934 (u16), CRC-16/CCITT-FALSE of what
follows (u16), flags (u16, bit 0: CAN FD), id (u32, bit 31: extended), data. Ours go out on the loopback interface with
time to live 0, so that none leaves the machine; what another machine sends is not heard.

python-can finds this bus by its entry point: `can.Bus(interface="sternplane_mcast", channel=0)`.
"""

from __future__ import annotations

import select
import socket
import struct
import time
from binascii import crc_hqx
from typing import Any

import can

from firmware_py.adapters.buses.receive_buffer import enlarge

NUMBERS = range(10)
PORT = 57732
_LOOPBACK = socket.inet_aton("127.0.0.1")
_MAGIC = 0x2934
_FD = 1
_EXTENDED = 1 << 31
_HEADER = struct.Struct("<HHHI")
_LONGEST = _HEADER.size + 64


def group(number: int) -> str:
    """The multicast address of a bus."""
    return f"239.65.82.{number}"


def encode(identifier: int, data: bytes) -> bytes:
    """The datagram of a frame; bit 31 of `identifier` says that its other 29 are an extended id."""
    body = struct.pack("<HI", 0, identifier) + data
    return struct.pack("<HH", _MAGIC, crc_hqx(body, 0xFFFF)) + body


class McastBus(can.BusABC):
    """One node on bus `channel`; it does not hear itself.

    Args:
        channel: 0 to 9, as a number or as text.
        can_filters: as everywhere in python-can.

    Raises:
        can.CanInitializationError: no such bus, or no multicast on this machine.
    """

    def __init__(self, channel: int | str = 0, can_filters: Any = None, **_: object) -> None:
        if str(channel) not in map(str, NUMBERS):
            raise can.CanInitializationError(f"there is no bus {channel!r}; write a number from 0 to {NUMBERS[-1]}")
        self.channel_info = f"udp:{channel}"
        self.bad = 0
        """Datagrams that are no frames."""
        self.socket, self._out = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        try:
            _listen(self.socket, int(channel))
            _speak(self._out, int(channel))
        except OSError as error:
            self.socket.close()
            self._out.close()
            raise can.CanInitializationError(f"no multicast on the loopback interface: {error.strerror}") from error
        self._self = self._out.getsockname()
        self._neighbours = {self._self[0]}
        super().__init__(channel, can_filters)

    def put(self, can_id: int, data: bytes) -> None:
        """Sends a frame with an extended id; OSError if it cannot."""
        self._out.send(encode(can_id | _EXTENDED, data))

    def take(self, frames: list[tuple[int, bytes]], limit: int) -> None:
        """Appends the frames with extended ids that have arrived; looks at no more than `limit`, its own apart."""
        receive, own = self.socket.recvfrom, self._self
        while limit > 0:
            try:
                datagram, source = receive(_LONGEST + 1)
            except BlockingIOError:
                return
            if source == own:
                continue
            limit -= 1
            frame = self._decode(datagram, source[0])
            if frame is not None and frame[0] & _EXTENDED:
                frames.append((frame[0] & 0x1FFFFFFF, frame[1]))

    def send(self, msg: can.Message, timeout: float | None = None) -> None:  # noqa: ARG002 (it never waits)
        """Sends a classic data frame at once.

        Raises:
            can.CanOperationError: any other frame, or the kernel takes none.
        """
        if msg.is_fd or msg.is_remote_frame or msg.is_error_frame:
            raise can.CanOperationError("this bus carries classic data frames alone")
        try:
            self._out.send(encode(msg.arbitration_id | msg.is_extended_id << 31, bytes(msg.data)))
        except OSError as error:
            raise can.CanOperationError(f"cannot send: {error.strerror}", error.errno) from error

    def fileno(self) -> int:
        """Readable when something has arrived, be it one's own."""
        return self.socket.fileno()

    def shutdown(self) -> None:
        """Leaves the bus; may be called twice."""
        super().shutdown()
        self.socket.close()
        self._out.close()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        try:
            message = self._next()
            if message is None and timeout != 0 and select.select([self.socket], [], [], timeout)[0]:
                message = self._next()
        except OSError as error:
            raise can.CanOperationError(f"cannot receive: {error.strerror}", error.errno) from error
        return message, False

    def _next(self) -> can.Message | None:
        while True:
            try:
                datagram, source = self.socket.recvfrom(_LONGEST + 1)
            except BlockingIOError:
                return None
            frame = None if source == self._self else self._decode(datagram, source[0])
            if frame is not None:
                extended = bool(frame[0] & _EXTENDED)
                return can.Message(time.time(), frame[0] & 0x1FFFFFFF, extended, data=frame[1])

    def _decode(self, datagram: bytes, address: str) -> tuple[int, bytes] | None:
        """Identifier (bit 31: extended) and data of a classic frame from this machine."""
        if len(datagram) < _HEADER.size:
            self.bad += 1
            return None
        magic, crc, flags, identifier = _HEADER.unpack_from(datagram)
        most = 64 if flags & _FD else 8
        known = identifier >> 29 == 0b100 or identifier <= 0x7FF
        if magic != _MAGIC or crc != crc_hqx(datagram[4:], 0xFFFF) or len(datagram) > _HEADER.size + most or not known:
            self.bad += 1
            return None
        if flags & _FD or not (address in self._neighbours or self._is_neighbour(address)):
            return None
        return identifier, datagram[_HEADER.size :]

    def _is_neighbour(self, address: str) -> bool:
        """Whether a sender is on this machine; others' frames come by the default route, under its address."""
        if is_local(address):
            self._neighbours.add(address)
        return address in self._neighbours


def is_local(address: str) -> bool:
    """Whether an address is this machine's: only then can it be bound."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((address, 0))
        except OSError:
            return False
    return True


def _listen(door: socket.socket, number: int) -> None:
    enlarge(door)
    door.setblocking(False)
    door.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    door.bind((group(number), PORT))
    door.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(group(number)) + _LOOPBACK)


def _speak(door: socket.socket, number: int) -> None:
    door.setblocking(False)
    door.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, _LOOPBACK)
    door.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    door.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
    # Not SO_REUSEADDR: the port must be ours alone, by it we and others know who spoke.
    door.connect((group(number), PORT))
