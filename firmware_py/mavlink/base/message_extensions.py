"""Messages that have grown since the dialect was made."""

from __future__ import annotations

from typing import Any

from firmware_py.mavlink.base.codec import Message


class ExtendedMessage:
    """A message with numbers of 32 bits behind it that the standard has appended since the dialect was made."""

    def __init__(self, message: Message, *extension: int) -> None:
        self._message, self._extension = message, b"".join(number.to_bytes(4, "little") for number in extension)

    def pack(self, mav: Any) -> bytes:
        """The frame."""
        m = self._message
        payload = m.unpacker.pack(*(getattr(m, name) for name in m.ordered_fieldnames)) + self._extension
        frame: bytes = m._pack(mav, m.crc_extra, payload)
        return frame
