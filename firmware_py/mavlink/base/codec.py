"""MAVLink's bytes. pymavlink's generated dialect packs and unpacks them; nothing else of pymavlink comes in."""

from __future__ import annotations

import struct
from typing import Any, TypeAlias

from pymavlink.dialects.v20 import all as dialect  # type: ignore[import-untyped]

__all__ = ["COMPONENT", "Codec", "Message", "dialect"]

Message: TypeAlias = Any
"""One of the dialect's MAVLink_*_message."""

COMPONENT = dialect.MAV_COMP_ID_AUTOPILOT1
_V1, _V2, _SIGNED = 0xFE, 0xFD, 0x01
_FRAME_V1, _FRAME_V2, _SIGNATURE = 8, 12, 13
_NO_FRAME, _NOT_KNOWN_YET = 0, 1 << 16
_PARTIAL_TIMEOUT_NS = 200_000_000
"""What a frame still lacks so long after its first bytes will not come: those were noise."""

dialect.MAVLINK_IGNORE_CRC = 0  # pymavlink takes this from the environment, which shall not make us believe noise


class Codec:
    """One link's packing and parsing: MAVLink 2 out, MAVLink 1 and 2 in. Nothing that it is given makes it raise."""

    def __init__(self, system: int, stream: bool = False, mav: Any = None) -> None:
        """In a `stream` frames go on in what comes next, in a datagram not; `mav` packs and parses if it is given."""
        self._mav = mav or dialect.MAVLink(None, system, COMPONENT)
        self._stream = stream
        self._partial = b""
        self._rest_ns = 0
        self.malformed = 0
        """Places in what came in at which a frame should have begun, and did not."""
        self.refused = 0
        """Messages that should have been signed and were not, or wrongly, or not lately."""
        self.not_encodable = 0
        """Messages with a number that its field cannot hold."""
        self.unknown = 0
        """Frames of an id that the dialect does not have: newer messages or noise, for no checksum can tell."""
        self.dropped = 0
        """Datagrams that were not read to their end, for want of time."""

    def pack(self, message: Message) -> bytes:
        """The frame, numbered in sequence; empty, and counted, if a field cannot hold its number."""
        mav = self._mav
        try:
            frame: bytes = message.pack(mav)
        except (struct.error, OverflowError):
            self.not_encodable += 1
            return b""
        mav.seq = mav.seq + 1 & 255
        return frame

    def parse(self, data: bytes, most: int, t_ns: int = 0) -> tuple[list[Message], int]:
        """The messages of a datagram, and in how many places it was looked at for them, at most `most`.

        In a stream, what may be a frame's beginning is kept for the next call: less than 300 bytes. A broken frame
        harms none but its own. After noise the search goes on at the next byte that may begin a frame.
        """
        messages: list[Message] = []
        start = attempts = 0
        if self._partial:
            start = _next_start(self._partial, 1) if t_ns - self._rest_ns > _PARTIAL_TIMEOUT_NS else 0
            data, self._partial = self._partial + data, b""
        while start < len(data):
            if attempts == most:
                self.dropped += 1
                break
            attempts += 1
            length = _length(data, start)
            end = start + length
            if self._stream and end > len(data):
                self._partial, self._rest_ns = data[start:], t_ns
                break
            if not start < end <= len(data) or not self._decode(data[start:end], messages):
                self.malformed += 1
                end = _next_start(data, start + 1)
            start = end
        return messages, attempts

    def _decode(self, frame: bytes, messages: list[Message]) -> bool:
        """Appends the frame's message, unless it is refused or of no known id; False if it is no frame."""
        rejected = self._mav.signing.reject_count
        try:
            message = self._mav.decode(bytearray(frame))
        except dialect.MAVError:
            if self._mav.signing.reject_count == rejected:
                return False
            self.refused += 1
            return True
        if message.get_msgId() == dialect.MAVLINK_MSG_ID_UNKNOWN:
            self.unknown += 1
        else:
            messages.append(message)
        return True


def _length(data: bytes, start: int) -> int:
    """How long a frame that begins here would be: 0 if none does, more than there is if that cannot be told yet."""
    magic = data[start]
    if magic not in (_V1, _V2):
        return _NO_FRAME
    if len(data) - start < _FRAME_V1:
        return _NOT_KNOWN_YET
    if magic == _V1:
        return _FRAME_V1 + data[start + 1]
    if data[start + 2] & ~_SIGNED:  # other flags change what the frame means
        return _NO_FRAME
    return _FRAME_V2 + data[start + 1] + (_SIGNATURE if data[start + 2] else 0)


def _next_start(data: bytes, after: int) -> int:
    starts = [found for found in (data.find(_V1, after), data.find(_V2, after)) if found >= 0]
    return min(starts, default=len(data))
