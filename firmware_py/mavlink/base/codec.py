"""MAVLink frames. pymavlink's generated dialect packs and unpacks messages; nothing else of pymavlink is used."""

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
"""A partial frame older than this was noise: its rest will not come."""

dialect.MAVLINK_IGNORE_CRC = 0  # pymavlink reads this from the environment; checksums are always checked


class Codec:
    """Packs and parses the frames of one link: MAVLink 2 out, MAVLink 1 and 2 in. No input makes it raise."""

    def __init__(self, system: int, stream: bool = False, mav: Any = None) -> None:
        """In a `stream` a frame may continue in the next bytes, in a datagram not; `mav` packs and parses if given."""
        self._mav = mav or dialect.MAVLink(None, system, COMPONENT)
        self._stream = stream
        self._partial = b""
        self._rest_ns = 0
        self.malformed = 0
        """Positions in the input where no valid frame begins."""
        self.refused = 0
        """Messages without a valid, recent signature where one is required."""
        self.not_encodable = 0
        """Messages to send with a number that its field cannot hold."""
        self.unknown = 0
        """Frames of an id that the dialect does not have: newer messages, or noise; no checksum can tell."""
        self.dropped = 0
        """Datagrams that were not parsed to their end, as the tick's limit was reached."""

    def pack(self, message: Message) -> bytes:
        """Return the frame with the next sequence number; empty, and counted, if a field cannot hold its number."""
        mav = self._mav
        try:
            frame: bytes = message.pack(mav)
        except (struct.error, OverflowError):
            self.not_encodable += 1
            return b""
        mav.seq = mav.seq + 1 & 255
        return frame

    def parse(self, data: bytes, most: int, t_ns: int = 0) -> tuple[list[Message], int]:
        """Return the messages of a datagram, and the number of parse attempts, at most `most`.

        In a stream, a partial frame (less than 300 bytes) is kept for the next call. A broken frame costs only itself:
        the search continues at the next byte that may begin a frame.
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
        """Append the frame's message, unless it is refused or its id is unknown; return False if it is no frame."""
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
    """Return the length of the frame that begins here: 0 if none does, a large number if it is not known yet."""
    magic = data[start]
    if magic not in (_V1, _V2):
        return _NO_FRAME
    if len(data) - start < _FRAME_V1:
        return _NOT_KNOWN_YET
    if magic == _V1:
        return _FRAME_V1 + data[start + 1]
    if data[start + 2] & ~_SIGNED:  # other incompatibility flags change the frame's meaning
        return _NO_FRAME
    return _FRAME_V2 + data[start + 1] + (_SIGNATURE if data[start + 2] else 0)


def _next_start(data: bytes, after: int) -> int:
    starts = [found for found in (data.find(_V1, after), data.find(_V2, after)) if found >= 0]
    return min(starts, default=len(data))
