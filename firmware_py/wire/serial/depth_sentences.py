"""Sentences of depth sensors, in the form of NMEA 0183: Valeport miniIPS and Impact Subsea ISD4000.

`$PIPS,depth,unit*cs` (Valeport, miniIPS2 operating manual, format "Valeport NMEA"): one number, which the unit tells
to be a depth (M, f) or a pressure (m mbar, d dbar, B bar, P psi). Its zero is that of the sensor's tare. A sensor that
was told to hide its units (#020;0) is refused: nobody knows what it measures.

`$ISDPT,depth,M,pressure,B,temperature,C*cs` (Impact Subsea, ISD4000 ASCII output 1; emulated by Valeport): fields of
fixed length, padded with zeros or spaces; depth in m, absolute pressure in bar, temperature in °C. Valeport's emulation
always sends 00.00 °C, has the units above in the place of M, and sends the pressure after its tare.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.wire.serial.nmea_line import at_least, fields, number, sentence
from firmware_py.wire.serial.stream import Lines, SentenceError

LONGEST_LINE = 82
"""The longest line that is accepted, bytes; the device's own longest is 44."""
CELSIUS = 273.15
BAR, DBAR = 1e5, 1e4
_PRESSURES = {b"m": 1e2, b"d": DBAR, b"B": BAR, b"P": 6894.757293168}
_DEPTHS = {b"M": 1.0, b"f": 0.3048}


class Depth(NamedTuple):
    """One measurement; NaN is unknown.

    Attributes:
        sentence: "PIPS" or "ISDPT".
        depth: m, positive down, as the sensor computed it from its own density of water.
        pressure: Pa; absolute from Impact Subsea, above its tare from Valeport.
        temperature: of the water, K.
    """

    sentence: str
    depth: float
    pressure: float = math.nan
    temperature: float = math.nan

    @property
    def usable(self) -> bool:
        """Return True if a depth or a pressure was told."""
        return math.isfinite(self.depth) or math.isfinite(self.pressure)


def _measured(value: float, unit: bytes) -> tuple[float, float]:
    """Return the depth and the pressure that a number with a unit is; the other is NaN."""
    unit = unit.strip()
    if unit in _DEPTHS:
        return value * _DEPTHS[unit], math.nan
    if unit in _PRESSURES:
        return math.nan, value * _PRESSURES[unit]
    raise SentenceError(f"unit {unit!r}: must be M, f, m, d, B or P")


def decode(line: bytes) -> Depth | None:
    """Return the measurement of a line without its end; None for another sentence.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    f = fields(line)
    if f[0] == b"PIPS":
        at_least(2, f)
        return Depth("PIPS", *_measured(number(f[1]), f[2]))
    if f[0] != b"ISDPT":
        return None
    at_least(6, f)
    if f[4].strip() != b"B" or f[6].strip() != b"C":
        raise SentenceError(f"ISDPT with units {f[4]!r} and {f[6]!r}: must be B and C")
    depth, _ = _measured(number(f[1]), f[2])
    return Depth("ISDPT", depth, number(f[3]) * BAR, number(f[5]) + CELSIUS)


def encode(message: Depth) -> bytes:
    """Return the line of a measurement, with CR LF, in the device's precision (PIPS 1 cm or 1 mbar, ISDPT 1 mm)."""
    if message.sentence == "PIPS":
        if math.isnan(message.depth):
            return sentence(f"PIPS,{_zeros(message.pressure / DBAR, 7, 2)},d")
        return sentence(f"PIPS,{_zeros(message.depth, 7, 2)},M")
    depth, pressure = _zeros(message.depth, 8, 3), _zeros(message.pressure / BAR, 8, 4)
    return sentence(f"ISDPT,{depth},M,{pressure},B,{_zeros(message.temperature - CELSIUS, 5, 2)},C")


def _zeros(value: float, width: int, decimals: int) -> str:
    return f"{value:0{width}.{decimals}f}" if math.isfinite(value) else ""


def lines() -> Lines[Depth]:
    """Return a decoder of the device's lines."""
    return Lines(decode, LONGEST_LINE)
