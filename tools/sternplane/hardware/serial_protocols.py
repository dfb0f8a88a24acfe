"""The protocols of serial instruments that are known here, and how each one's messages are called."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from firmware_py.wire.serial import (
    depth_sentences,
    dynamixel,
    microstrain,
    nmea0183,
    nortek_dvl,
    pd6,
    ping,
    sbg,
    ubx,
    vectornav,
    waterlink_dvl,
    waterlink_json,
    xsens,
)
from firmware_py.wire.serial.stream import Decoder


class Protocol(NamedTuple):
    """A protocol.

    Attributes:
        name: for people.
        decoder: makes its decoder.
    """

    name: str
    decoder: Callable[[], Decoder[Any]]


PROTOCOLS = (
    Protocol("Water Linked DVL", waterlink_dvl.lines),
    Protocol("Water Linked DVL, JSON", waterlink_json.lines),
    Protocol("Nortek DVL ($PNORBT)", nortek_dvl.lines),
    Protocol("DVL in PD6", pd6.ensembles),
    Protocol("depth sensor ($PIPS, $ISDPT)", depth_sentences.lines),
    Protocol("u-blox (UBX)", ubx.packets),
    Protocol("VectorNav", vectornav.messages),
    Protocol("MicroStrain (MIP)", microstrain.packets),
    Protocol("Xsens (MTData2)", xsens.messages),
    Protocol("SBG (sbgECom)", sbg.frames),
    Protocol("Blue Robotics Ping", ping.packets),
    Protocol("Dynamixel 2.0, answers", dynamixel.statuses),
    Protocol("Dynamixel 2.0, instructions", dynamixel.instructions),
    Protocol("NMEA 0183", nmea0183.lines),
)
"""NMEA 0183 is the last: many makers borrow its form, and its decoder knows their sentences by the checksum alone."""
