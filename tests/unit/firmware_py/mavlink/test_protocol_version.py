"""PROTOCOL_VERSION, which pymavlink does not know: by the definition in MAVLink's minimal.xml."""

from __future__ import annotations

import struct

import pytest
from pymavlink.dialects.v20 import all as mavlink

from firmware_py.mavlink.base.codec import Codec
from firmware_py.mavlink.base.protocol_version import MESSAGE_ID, protocol_version

from .station import Boat

FIELDS = (
    ("uint16_t", "version", 0),
    ("uint16_t", "min_version", 0),
    ("uint16_t", "max_version", 0),
    ("uint8_t", "spec_version_hash", 8),
    ("uint8_t", "library_version_hash", 8),
)
FRAME = bytes.fromhex("fd 05 00 00 00 07 01 2c 01 00  c8 00 64 00 c8")
"""MAVLink 2, five bytes but for the zeros behind them, sequence 0, system 7, component 1, message 300."""


def crc_extra() -> int:
    """MAVLink's checksum over a message's name and fields, folded into a byte."""
    crc = mavlink.x25crc(b"PROTOCOL_VERSION ")
    for kind, name, length in FIELDS:
        crc.accumulate(f"{kind} {name} ".encode())
        if length:
            crc.accumulate(bytes([length]))
    return int(crc.crc & 255 ^ crc.crc >> 8)


def test_its_bytes_are_those_of_the_definition() -> None:
    frame = Codec(7).pack(protocol_version())
    assert frame[:-2] == FRAME
    checked = mavlink.x25crc(FRAME[1:])
    checked.accumulate(bytes([crc_extra()]))
    assert frame[-2:] == struct.pack("<H", checked.crc)


@pytest.mark.parametrize(
    "command",
    [(mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION, 1), (mavlink.MAV_CMD_REQUEST_MESSAGE, MESSAGE_ID)],
    ids=["by its own command", "as any message"],
)
def test_who_asks_is_told(command: tuple[int, int]) -> None:
    boat = Boat()
    (station,) = boat.stations
    station.command(*command)
    boat.step(2)
    (told,) = [m for m in station.messages if m.get_msgId() == mavlink.MAVLINK_MSG_ID_UNKNOWN]
    assert bytes(told.get_msgbuf())[7:10] == MESSAGE_ID.to_bytes(3, "little")
    assert station.acks() == [(command[0], mavlink.MAV_RESULT_ACCEPTED)]
