"""Sentences of satellite receivers, compasses and sounders: NMEA 0183, versions 2.0 to 4.11.

Read are GGA, GNS, RMC (position), GST (its standard deviations), VTG (velocity over ground), HDT, THS, HDM, HDG
(heading), ROT (rate of turn), DPT, DBT (distance to the bottom) of any talker, and PASHR (attitude: Applanix, Trimble,
NovAtel, SBG). Facts of the standard: positions are ddmm.mmmm with N, S, E, W; speeds in knots, angles in degrees, ROT
in degrees a minute, negative to port; deviation and variation are positive to the east; modes A autonomous,
D differential, P precise, R and F RTK, E dead reckoning, M entered, S simulated, N none, in GNS one for each system of
satellites. Not believed is the last field of RMC and GNS, the navigational status: receivers without a watch over
integrity always send V there. PASHR with a word in its first field is another sentence of the same name.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware_py.wire.serial.nmea_line import (
    angle,
    arc,
    at_least,
    clock,
    count,
    fields,
    number,
    sentence,
    signed,
    written,
    written_arc,
    written_clock,
    written_direction,
    written_signed,
)
from firmware_py.wire.serial.nmea_messages import (
    UNKNOWN,
    Attitude,
    BelowTransducer,
    Heading,
    Message,
    OverGround,
    Position,
    PositionSigma,
    TurnRate,
)
from firmware_py.wire.serial.stream import Lines, SentenceError

LONGEST_LINE = 256
"""The longest line that is accepted, bytes: 82 by the standard, and binary packets of the same receiver before it."""
KNOT = 1852.0 / 3600.0
KM_H = 1.0 / 3.6
FOOT, FATHOM = 0.3048, 1.8288
DEG = math.pi / 180.0
_MODES = {b"": 1, b"N": 0, b"A": 1, b"D": 2, b"P": 3, b"R": 4, b"F": 5, b"E": 6, b"M": 7, b"S": 8}
_BEST_FIRST = b"RFDPAEMS"
_LETTERS = "NADPRFEMS"
_OTHERS = {b"ISDPT"}
"""Sentences of makers that look like one of a talker; see `depth_sentences`."""


def decode(line: bytes) -> Message | None:
    """Return the message of a line without its end; None for another sentence.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    found = fields(line)
    address = found[0]
    proprietary = address[:1] == b"P" or address in _OTHERS
    read = _READ.get(address if proprietary or len(address) != 5 else address[2:])
    return read(found) if read is not None else None


def lines() -> Lines[Message]:
    """Return a decoder of a talker's lines."""
    return Lines(decode, LONGEST_LINE)


def _mode(letter: bytes) -> int:
    try:
        return _MODES[letter]
    except KeyError:
        raise SentenceError(f"mode {letter!r}: must be one of {_LETTERS}") from None


def _unit(field: bytes, unit: bytes, value: bytes) -> bytes:
    """Return the field of a value if the field behind it names the unit, or if it is empty."""
    if field != unit and (field or value):
        raise SentenceError(f"unit {field!r}: must be {unit.decode()}")
    return value


def _gga(f: list[bytes]) -> Position:
    at_least(14, f)
    latitude, longitude = arc(f[2], f[3], b"N", b"S", 90.0), arc(f[4], f[5], b"E", b"W", 180.0)
    altitude, separation = number(_unit(f[10], b"M", f[9])), number(_unit(f[12], b"M", f[11]))
    quality, satellites = count(f[6], 0), count(f[7], UNKNOWN)
    return Position("GGA", clock(f[1]), latitude, longitude, quality, satellites, number(f[8]), altitude, separation)


def _gns(f: list[bytes]) -> Position:
    at_least(12, f)
    latitude, longitude = arc(f[2], f[3], b"N", b"S", 90.0), arc(f[4], f[5], b"E", b"W", 180.0)
    best = next((_BEST_FIRST[k : k + 1] for k in range(len(_BEST_FIRST)) if _BEST_FIRST[k] in f[6]), b"N")
    if f[6].strip(_BEST_FIRST + b"N"):
        raise SentenceError(f"modes {f[6]!r}: must be some of {_LETTERS}")
    satellites, altitude, separation = count(f[7], UNKNOWN), number(f[9]), number(f[10])
    return Position(
        "GNS", clock(f[1]), latitude, longitude, _MODES[best], satellites, number(f[8]), altitude, separation
    )


def _rmc(f: list[bytes]) -> Position:
    at_least(11, f)
    if f[2] not in (b"A", b"V"):
        raise SentenceError(f"RMC with status {f[2]!r}: must be A or V")
    quality = _mode(f[12] if len(f) > 12 else b"")
    return Position(
        "RMC",
        clock(f[1]),
        arc(f[3], f[4], b"N", b"S", 90.0),
        arc(f[5], f[6], b"E", b"W", 180.0),
        quality if f[2] == b"A" else 0,
        speed=number(f[7]) * KNOT if f[7] else math.nan,
        course=angle(f[8]),
        variation=signed(f[10], f[11], b"E", b"W"),
    )


def _gst(f: list[bytes]) -> PositionSigma:
    at_least(8, f)
    return PositionSigma(clock(f[1]), number(f[6]), number(f[7]), number(f[8]))


def _vtg(f: list[bytes]) -> OverGround:
    at_least(8, f)
    knots, km_h = number(_unit(f[6], b"N", f[5])), number(_unit(f[8], b"K", f[7]))
    speed = km_h * KM_H if math.isnan(knots) else knots * KNOT
    return OverGround(angle(_unit(f[2], b"T", f[1])), speed, _mode(f[9] if len(f) > 9 else b""))


def _hdt(f: list[bytes]) -> Heading:
    at_least(2, f)
    return Heading("HDT", angle(_unit(f[2], b"T", f[1])))


def _hdm(f: list[bytes]) -> Heading:
    at_least(2, f)
    return Heading("HDM", angle(_unit(f[2], b"M", f[1])))


def _hdg(f: list[bytes]) -> Heading:
    at_least(5, f)
    return Heading("HDG", angle(f[1]), signed(f[2], f[3], b"E", b"W"), signed(f[4], f[5], b"E", b"W"))


def _ths(f: list[bytes]) -> Heading:
    at_least(2, f)
    if len(f[2]) != 1 or f[2] not in b"AEMSV":
        raise SentenceError(f"THS with mode {f[2]!r}: must be A, E, M, S or V")
    return Heading("THS", angle(f[1]), valid=f[2] == b"A")


def _rot(f: list[bytes]) -> TurnRate:
    at_least(2, f)
    if f[2] not in (b"A", b"V"):
        raise SentenceError(f"ROT with status {f[2]!r}: must be A or V")
    return TurnRate(number(f[1]) * (DEG / 60.0), f[2] == b"A")


def _pashr(f: list[bytes]) -> Attitude | None:
    at_least(1, f)
    if f[1][:1].isalpha():
        return None
    at_least(10, f)
    heading, roll, pitch = angle(_unit(f[3], b"T", f[2])), angle(f[4], 180.0), angle(f[5], 180.0)
    inertial = count(f[11], UNKNOWN) if len(f) > 11 else UNKNOWN
    sigma = angle(f[7]), angle(f[8]), angle(f[9])
    return Attitude(clock(f[1]), heading, roll, pitch, number(f[6]), sigma, count(f[10], 0), inertial)


def _dpt(f: list[bytes]) -> BelowTransducer:
    at_least(2, f)
    return BelowTransducer("DPT", number(f[1]), number(f[2]))


def _dbt(f: list[bytes]) -> BelowTransducer:
    at_least(6, f)
    feet, meters, fathoms = (
        number(_unit(f[2], b"f", f[1])),
        number(_unit(f[4], b"M", f[3])),
        number(_unit(f[6], b"F", f[5])),
    )
    told = (value for value in (meters, feet * FOOT, fathoms * FATHOM) if not math.isnan(value))
    return BelowTransducer("DBT", next(told, math.nan))


_READ: dict[bytes, Callable[[list[bytes]], Message | None]] = {
    b"GGA": _gga,
    b"GNS": _gns,
    b"RMC": _rmc,
    b"GST": _gst,
    b"VTG": _vtg,
    b"HDT": _hdt,
    b"HDM": _hdm,
    b"HDG": _hdg,
    b"THS": _ths,
    b"ROT": _rot,
    b"PASHR": _pashr,
    b"DPT": _dpt,
    b"DBT": _dbt,
}


def encode(message: Message, talker: str = "GN") -> bytes:
    """Return the line of a message, with CR LF, in the precision that receivers send (1.9 cm, 0.01 degrees, 1 mm/s)."""
    match message:
        case Position():
            return sentence(_position(message, talker))
        case PositionSigma(time, north, east, up):
            sigma = ",".join(written(value, 3) for value in (north, east, up))
            return sentence(f"{talker}GST,{written_clock(time)},,,,,{sigma}")
        case OverGround(course, speed, quality):
            speeds = f"{written(speed, 3, 1 / KNOT)},N,{written(speed, 3, 1 / KM_H)},K"
            return sentence(f"{talker}VTG,{written_direction(course, 2)},T,,M,{speeds},{_LETTERS[quality]}")
        case Heading():
            return sentence(_heading(message, talker))
        case TurnRate(rate, valid):
            return sentence(f"{talker}ROT,{written(rate, 2, 60 / DEG)},{'A' if valid else 'V'}")
        case Attitude(time, heading, roll, pitch, heave, sigma, aiding, inertial):
            angles = f"{written_direction(heading, 2)},T,{written(roll, 2, 1 / DEG)},{written(pitch, 2, 1 / DEG)}"
            sigmas = ",".join(written(value, 3, 1 / DEG) for value in sigma)
            flags = f"{aiding}" if inertial == UNKNOWN else f"{aiding},{inertial}"
            return sentence(f"PASHR,{written_clock(time)},{angles},{written(heave, 2)},{sigmas},{flags}")
        case BelowTransducer("DPT", distance, offset):
            return sentence(f"{talker}DPT,{written(distance, 3)},{written(offset, 3)}")
        case BelowTransducer(_, distance, _):
            feet, fathoms = written(distance, 2, 1 / FOOT), written(distance, 2, 1 / FATHOM)
            return sentence(f"{talker}DBT,{feet},f,{written(distance, 3)},M,{fathoms},F")


def _position(p: Position, talker: str) -> str:
    place = f"{written_arc(p.latitude, 2, 'NS')},{written_arc(p.longitude, 3, 'EW')}"
    if p.sentence == "RMC":
        motion = f"{written(p.speed, 3, 1 / KNOT)},{written_direction(p.course, 2)}"
        mode = _LETTERS[p.quality]
        end = f"{written_signed(p.variation, 1, 'EW')},{mode}"
        return f"{talker}RMC,{written_clock(p.time)},{'A' if p.quality else 'V'},{place},{motion},,{end}"
    satellites = "" if p.satellites == UNKNOWN else f"{p.satellites:02d}"
    height = written(p.altitude, 3), written(p.separation, 3)
    if p.sentence == "GNS":
        used = f"{_LETTERS[p.quality]},{satellites},{written(p.hdop, 2)}"
        return f"{talker}GNS,{written_clock(p.time)},{place},{used},{height[0]},{height[1]},,"
    used = f"{p.quality},{satellites},{written(p.hdop, 2)}"
    return f"{talker}GGA,{written_clock(p.time)},{place},{used},{height[0]},M,{height[1]},M,,"


def _heading(h: Heading, talker: str) -> str:
    heading = written_direction(h.heading, 2)
    if h.sentence == "HDG":
        return f"{talker}HDG,{heading},{written_signed(h.deviation, 1, 'EW')},{written_signed(h.variation, 1, 'EW')}"
    end = {"HDT": "T", "HDM": "M", "THS": "A" if h.valid else "V"}[h.sentence]
    return f"{talker}{h.sentence},{heading},{end}"
