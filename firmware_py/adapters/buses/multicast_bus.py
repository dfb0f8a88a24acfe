"""CAN over UDP multicast: the buses that ArduPilot's SITL, AP_Periph, libcanard and pydronecan call `mcast:N`.

A frame is a datagram to 239.65.82.N, port 57732, all little-endian: magic 0x2934 (u16), CRC-16/CCITT-FALSE of what
follows (u16), flags (u16, bit 0: CAN FD), id (u32, bit 31: extended), data. Frames are sent on the loopback interface
with time to live 0, so that none leaves the machine; frames of another machine are ignored. python-can has no bus of
this framing (its own `udp_multicast` packs messages by msgpack).

python-can finds this bus by its entry point: `can.Bus(interface="sternplane_mcast", channel=0)`.
"""

from __future__ import annotations

import math
import select
import socket
import struct
import time
from binascii import crc_hqx
from collections.abc import Collection, Iterator
from typing import Any

import can

from firmware_py.adapters.buses import receive_buffer
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.error_text import quoted

NUMBERS = range(10)
PORT = 57732
_LOOPBACK = socket.inet_aton("127.0.0.1")
_MAGIC = 0x2934
_FD = 1
_EXTENDED = 1 << 31
_HEADER = struct.Struct("<HHHI")
_LONGEST = _HEADER.size + 64


def group(number: int) -> str:
    """Return the multicast address of a bus."""
    return f"239.65.82.{number}"


def encode(identifier: int, data: bytes) -> bytes:
    """Return the datagram of a frame; bit 31 of `identifier` marks an extended id of 29 bits."""
    body = struct.pack("<HI", 0, identifier) + data
    return struct.pack("<HH", _MAGIC, crc_hqx(body, 0xFFFF)) + body


class McastBus(can.BusABC):
    """One node on bus `channel`; it does not receive its own frames.

    Args:
        channel: 0 to 9, as a number or as text.
        can_filters: as everywhere in python-can.
        standard: whether `receive_frames` gives frames with standard ids too.

    Raises:
        can.CanInitializationError: no such bus, or no multicast on this machine.
    """

    sound = True
    """There is no controller that could fail."""

    def __init__(self, channel: int | str = 0, can_filters: Any = None, *, standard: bool = False, **_: object) -> None:
        if str(channel) not in map(str, NUMBERS):
            raise can.CanInitializationError(
                f"there is no bus {quoted(channel)}; write a number from 0 to {NUMBERS[-1]}"
            )
        self.channel_info = f"udp:{channel}"
        self.bad = 0
        """Datagrams that are no frames."""
        self.socket, self._sender = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        try:
            _set_up_receiver(self.socket, int(channel))
            _set_up_sender(self._sender, int(channel))
        except OSError as error:
            self.socket.close()
            self._sender.close()
            raise can.CanInitializationError(f"no multicast on the loopback interface: {error.strerror}") from error
        self._standard = standard
        self._own_address = self._sender.getsockname()
        self._local_hosts = {self._own_address[0]}
        super().__init__(channel, can_filters)

    @property
    def overrun(self) -> int:
        """Return how many frames, one's own included, the kernel had no room for."""
        return receive_buffer.overrun(self.socket)

    @property
    def errors(self) -> dict[str, int]:
        """Return how many datagrams were no frames, if any."""
        return {"malformed": self.bad} if self.bad else {}

    def send_frames(self, frames: Collection[tuple[int, bytes]]) -> int:
        """Send frames; return how many the kernel did not take."""
        not_taken = 0
        for can_id, data in frames:
            identifier = can_id | _EXTENDED if can_id < STANDARD else can_id & 0x7FF
            try:
                self._sender.send(encode(identifier, data))
            except OSError:
                not_taken += 1
        return not_taken

    def receive_frames(self, frames: list[tuple[int, bytes]], limit: int) -> None:
        """Append the frames that have arrived; examine at most `limit` datagrams of other nodes."""
        for identifier, data in self._arrived(limit):
            if identifier & _EXTENDED:
                frames.append((identifier & 0x1FFFFFFF, data))
            elif self._standard:
                frames.append((identifier | STANDARD, data))

    def send(self, msg: can.Message, timeout: float | None = None) -> None:  # noqa: ARG002 (it never waits)
        """Send a classic data frame at once.

        Raises:
            can.CanOperationError: any other frame, or the kernel takes none.
        """
        if msg.is_fd or msg.is_remote_frame or msg.is_error_frame:
            raise can.CanOperationError("this bus carries classic data frames alone")
        try:
            self._sender.send(encode(msg.arbitration_id | msg.is_extended_id << 31, bytes(msg.data)))
        except OSError as error:
            raise can.CanOperationError(f"cannot send: {error.strerror}", error.errno) from error

    def fileno(self) -> int:
        """Return the descriptor that is readable when something has arrived, one's own frames included."""
        return self.socket.fileno()

    def shutdown(self) -> None:
        """Leave the bus; may be called twice."""
        super().shutdown()
        self.socket.close()
        self._sender.close()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        try:
            frame = next(self._arrived(math.inf), None)
            if frame is None and timeout != 0 and select.select([self.socket], [], [], timeout)[0]:
                frame = next(self._arrived(math.inf), None)
        except OSError as error:
            raise can.CanOperationError(f"cannot receive: {error.strerror}", error.errno) from error
        if frame is None:
            return None, False
        identifier, data = frame
        return can.Message(time.time(), identifier & 0x1FFFFFFF, bool(identifier & _EXTENDED), data=data), False

    def _arrived(self, limit: float) -> Iterator[tuple[int, bytes]]:
        """Yield identifier (bit 31: extended) and data of the frames that have arrived; examine at most `limit`."""
        receive, own = self.socket.recvfrom, self._own_address
        while limit > 0:
            try:
                datagram, source = receive(_LONGEST + 1)
            except BlockingIOError:
                return
            if source == own:
                continue
            limit -= 1
            frame = self._decode(datagram, source[0])
            if frame is not None:
                yield frame

    def _decode(self, datagram: bytes, address: str) -> tuple[int, bytes] | None:
        """Return identifier (bit 31: extended) and data of a classic frame from this machine."""
        if len(datagram) < _HEADER.size:
            self.bad += 1
            return None
        magic, crc, flags, identifier = _HEADER.unpack_from(datagram)
        most = 64 if flags & _FD else 8
        known = identifier >> 29 == 0b100 or identifier <= 0x7FF
        if magic != _MAGIC or crc != crc_hqx(datagram[4:], 0xFFFF) or len(datagram) > _HEADER.size + most or not known:
            self.bad += 1
            return None
        if flags & _FD or not (address in self._local_hosts or self._is_local_host(address)):
            return None
        return identifier, datagram[_HEADER.size :]

    def _is_local_host(self, address: str) -> bool:
        """Return whether a sender is on this machine; other programs may send by the default route's address."""
        if is_local(address):
            self._local_hosts.add(address)
        return address in self._local_hosts


def is_local(address: str) -> bool:
    """Return whether an address is this machine's: only then can it be bound."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((address, 0))
        except OSError:
            return False
    return True


def _set_up_receiver(receiver: socket.socket, number: int) -> None:
    receive_buffer.enlarge(receiver)
    receiver.setblocking(False)
    receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    receiver.bind((group(number), PORT))
    receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(group(number)) + _LOOPBACK)


def _set_up_sender(sender: socket.socket, number: int) -> None:
    sender.setblocking(False)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, _LOOPBACK)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
    # Not SO_REUSEADDR: the port must be this socket's alone; it tells which node sent a frame.
    sender.connect((group(number), PORT))
