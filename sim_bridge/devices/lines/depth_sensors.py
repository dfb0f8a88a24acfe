"""Depth sensors: Impact Subsea ISD4000, which tells absolute pressure, and Valeport, which tells it above its tare."""

from __future__ import annotations

import math

from firmware_py.wire.serial.depth_sentences import Depth, encode
from sim_bridge.devices.lines.firmware import Talker

AIR = 101_325.0
"""The Valeport was tared at this pressure, Pa."""
_PER_METRE = 9806.65
"""Fresh water, by which the device computes depth, Pa/m."""


def isd4000() -> Talker:
    """Return the program of an ISD4000."""
    return Talker(lambda pressure, _valid, _now: encode(Depth("ISDPT", (pressure - AIR) / _PER_METRE, pressure, 285.0)))


def valeport() -> Talker:
    """Return the program of a miniIPS that was told to send decibars."""
    return Talker(lambda pressure, _valid, _now: encode(Depth("PIPS", math.nan, pressure - AIR)))
