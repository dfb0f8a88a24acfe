"""Messages of the MAVLink standard that pymavlink's dialects lack, in whole or in part.

pymavlink 2.4.50 has neither PROTOCOL_VERSION nor COMPONENT_METADATA (the standard marks both as work in progress), and
its mission messages end before the plan ids that the standard appended later. pymavlink's generator can make them from
XML, but the generated module has 970 lines, most of them a second codec. The definitions here take one line a field; a
test compares their bytes with those of a generated module.
"""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

from firmware_py.mavlink.base.codec import Message, dialect

_FORMATS = {"uint16_t": "H", "uint32_t": "I"}


class MessageField(NamedTuple):
    """A field: its C type, its name, and its length as an array of bytes or characters (0: a single number)."""

    ctype: str
    name: str
    length: int = 0


class MessageDefinition:
    """A message of the standard: id, name, and fields in the order of the wire."""

    def __init__(self, message_id: int, name: str, *fields: MessageField) -> None:
        self.id, self.name, self.fields = message_id, name, fields
        self.layout = struct.Struct("<" + "".join(f"{f.length}s" if f.length else _FORMATS[f.ctype] for f in fields))
        self.crc_extra = _crc_extra(name, fields)

    def message(self, *values: int | bytes) -> Message:
        """Return the message with these field values."""
        return _DefinedMessage(self, self.layout.pack(*values))


class _DefinedMessage(dialect.MAVLink_message):  # type: ignore[misc]
    """A message that knows its payload already."""

    def __init__(self, definition: MessageDefinition, payload: bytes) -> None:
        super().__init__(definition.id, definition.name)
        self._definition, self._fields = definition, payload

    def pack(self, mav: Any, force_mavlink1: bool = False) -> bytes:
        """Return the frame."""
        frame: bytes = self._pack(mav, self._definition.crc_extra, self._fields, force_mavlink1=force_mavlink1)
        return frame


class ExtendedMessage:
    """A message of the dialect with the uint32 extension fields that the standard appended to it later.

    Extension fields do not count in the checksum's extra byte, and parsers that do not know them skip them.
    """

    def __init__(self, message: Message, *extension: int) -> None:
        self._message, self._extension = message, b"".join(number.to_bytes(4, "little") for number in extension)

    def pack(self, mav: Any) -> bytes:
        """Return the frame."""
        m = self._message
        payload = m.unpacker.pack(*(getattr(m, name) for name in m.ordered_fieldnames)) + self._extension
        frame: bytes = m._pack(mav, m.crc_extra, payload)
        return frame


def _crc_extra(name: str, fields: tuple[MessageField, ...]) -> int:
    """Return the checksum of a message's name and fields, folded into one byte, as the standard defines it."""
    crc = dialect.x25crc(f"{name} ".encode())
    for field in fields:
        crc.accumulate(f"{field.ctype} {field.name} ".encode())
        if field.length:
            crc.accumulate(bytes([field.length]))
    return int(crc.crc & 255 ^ crc.crc >> 8)


PROTOCOL_VERSION = MessageDefinition(
    300,
    "PROTOCOL_VERSION",
    MessageField("uint16_t", "version"),
    MessageField("uint16_t", "min_version"),
    MessageField("uint16_t", "max_version"),
    MessageField("uint8_t", "spec_version_hash", 8),
    MessageField("uint8_t", "library_version_hash", 8),
)
COMPONENT_METADATA = MessageDefinition(
    397,
    "COMPONENT_METADATA",
    MessageField("uint32_t", "time_boot_ms"),
    MessageField("uint32_t", "file_crc"),
    MessageField("char", "uri", 100),
)
