"""PROTOCOL_VERSION: which versions of MAVLink are spoken here.

pymavlink's dialects leave this message out, as it is marked "work in progress" in MAVLink's minimal.xml; stations ask
for it all the same when they connect.
"""

from __future__ import annotations

import struct
from typing import Any

from firmware_py.mavlink.base.codec import Message, dialect

__all__ = ["MESSAGE_ID", "protocol_version"]

MESSAGE_ID = 300
_V1, _V2 = 100, 200
"""Hundredths of a version: MAVLink 1 is understood, MAVLink 2 is spoken."""
_NO_HASH = bytes(8)


class _ProtocolVersion(dialect.MAVLink_message):  # type: ignore[misc]
    """uint16 version, min_version, max_version; uint8[8] spec_version_hash, library_version_hash."""

    id = MESSAGE_ID
    msgname = "PROTOCOL_VERSION"
    crc_extra = 217
    unpacker = struct.Struct("<3H8s8s")

    def __init__(self) -> None:
        super().__init__(self.id, self.msgname)

    def pack(self, mav: Any, force_mavlink1: bool = False) -> bytes:
        payload = self.unpacker.pack(_V2, _V1, _V2, _NO_HASH, _NO_HASH)
        frame: bytes = self._pack(mav, self.crc_extra, payload, force_mavlink1=force_mavlink1)
        return frame


def protocol_version() -> Message:
    """The message; no hash is given, for there is no repository of definitions behind this vehicle."""
    return _ProtocolVersion()
