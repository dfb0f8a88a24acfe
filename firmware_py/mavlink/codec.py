"""MAVLink's bytes. pymavlink's generated dialect packs and unpacks them; nothing else of pymavlink comes in."""

from __future__ import annotations

import struct
from typing import Any, TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as dialect  # type: ignore[import-untyped]

__all__ = ["COMPONENT", "Codec", "Message", "dialect"]

Message: TypeAlias = Any
"""One of the dialect's MAVLink_*_message."""

COMPONENT = dialect.MAV_COMP_ID_AUTOPILOT1
_V1, _V2, _SIGNED = 0xFE, 0xFD, 0x01
_FRAME_V1, _FRAME_V2, _SIGNATURE = 8, 12, 13

dialect.MAVLINK_IGNORE_CRC = 0  # pymavlink takes this from the environment, which shall not make us believe noise


class Codec:
    """One link's packing and parsing: MAVLink 2 out, MAVLink 1 and 2 in. Nothing that it is given makes it raise."""

    def __init__(self, system: int) -> None:
        self._mav = dialect.MAVLink(None, system, COMPONENT)
        self.malformed = 0
        """Places in what came in at which a frame should have begun, and did not."""
        self.unsayable = 0
        """Messages with a number that its field cannot hold."""
        self.dropped = 0
        """Datagrams that were not read to their end, for want of time."""

    def pack(self, message: Message) -> bytes:
        """The frame, numbered in sequence; empty, and counted, if a field cannot hold its number."""
        mav = self._mav
        try:
            frame: bytes = message.pack(mav)
        except (struct.error, OverflowError):
            self.unsayable += 1
            return b""
        mav.seq = mav.seq + 1 & 255
        return frame

    def parse(self, datagram: bytes, most: int) -> tuple[list[Message], int]:
        """The messages of a datagram, and in how many places it was looked at for them, at most `most`.

        Frames do not go on in the next datagram, so a broken one harms none but its own. After noise the search goes on
        at the next byte that may begin a frame.
        """
        messages: list[Message] = []
        start = looked = 0
        while start < len(datagram):
            if looked == most:
                self.dropped += 1
                break
            looked += 1
            end = start + _length(datagram, start)
            if start < end <= len(datagram):
                try:
                    messages.append(self._mav.decode(bytearray(datagram[start:end])))
                except dialect.MAVError:
                    end = start
            else:
                end = start
            if end == start:
                self.malformed += 1
                end = _next_start(datagram, start + 1)
            start = end
        return messages, looked


def _length(data: bytes, start: int) -> int:
    """How long a frame that begins here would be; 0 if none does."""
    if len(data) - start < _FRAME_V1:
        return 0
    if data[start] == _V1:
        return _FRAME_V1 + data[start + 1]
    if data[start] == _V2 and not data[start + 2] & ~_SIGNED:  # other flags change what the frame means
        return _FRAME_V2 + data[start + 1] + (_SIGNATURE if data[start + 2] else 0)
    return 0


def _next_start(data: bytes, after: int) -> int:
    starts = [found for found in (data.find(_V1, after), data.find(_V2, after)) if found >= 0]
    return min(starts, default=len(data))
