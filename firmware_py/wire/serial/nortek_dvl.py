"""Bottom-track sentences of Nortek DVLs, in the form of NMEA 0183 (DVL integrator's guide, data formats 300 to 359).

In X, Y, Z: `$PNORBT7,time,dt1,dt2,vx,vy,vz,fom,d1,d2,d3,d4*cs` (format 357), and `$PNORBT9` (359), which adds battery
voltage, speed of sound, pressure, temperature and status; `$PNORBT6` and `$PNORBT8` (356, 358) are the same with tags,
`VX=0.1234`. Time is s since 1970 of the device's clock; dt1 and dt2 ms, from the trigger and from the start of this
sentence to the echo of the bottom (dt2 is negative); m/s; m, vertical; dbar; °C; status `0x` and eight hexadecimal
digits: bits 0 to 3 velocity, 4 to 7 distance, 8 to 11 figure of merit of each beam valid, 12 to 15 velocity of X, Y,
Z1, Z2 valid, 16 to 19 their figures of merit. Axes: X along the mark on the housing, right-handed, velocities of the
device over the bottom.

Of one beam: `$PNORBT,beam,date,time,dt1,dt2,velocity,fom,distance,water velocity,status*cs` (Signature, format 300;
301 with tags) and `$PNORBT0` (351; `$PNORBT1` with tags), which lacks the water velocity. Velocity is positive towards
the transducer.

What is invalid: velocity -32.768, distance 0, figure of merit 10 or more.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.wire.serial.nmea_line import at_least, clock, count, fields, number, sentence, written_clock
from firmware_py.wire.serial.stream import Lines, SentenceError

LONGEST_LINE = 256
"""The longest line that is accepted, bytes; the device's own longest is about 200."""
INVALID_VELOCITY, INVALID_FOM = -32.768, 10.0
DBAR, MS, CELSIUS = 1e4, 1e-3, 273.15
UNKNOWN = -1
_XYZ_VALID = 0b0111 << 12
_NAN = math.nan


class Velocity(NamedTuple):
    """Velocity over the bottom in the device's axes; NaN is unknown or invalid.

    Attributes:
        time: of the ping, s since 1970 by the device's clock.
        since_trigger: from the trigger to the echo of the bottom, s.
        since_output: from the start of the sentence to that echo, s: negative, by so much is the velocity older.
        vx: m/s.
        vy: m/s.
        vz: m/s.
        fom: standard deviation of the velocity, m/s.
        distances: vertical distance to the bottom by each beam, m.
        battery: V.
        sound_speed: m/s.
        pressure: Pa.
        temperature: K.
        status: bits as above; UNKNOWN in PNORBT6 and PNORBT7.
    """

    time: float
    since_trigger: float
    since_output: float
    vx: float
    vy: float
    vz: float
    fom: float
    distances: tuple[float, float, float, float]
    battery: float = _NAN
    sound_speed: float = _NAN
    pressure: float = _NAN
    temperature: float = _NAN
    status: int = UNKNOWN

    @property
    def usable(self) -> bool:
        """Return True if all velocities are valid, and the status says so too where it is told."""
        told = self.status == UNKNOWN or self.status & _XYZ_VALID == _XYZ_VALID
        return told and math.isfinite(self.vx + self.vy + self.vz + self.fom)

    @property
    def bottom(self) -> float:
        """Return the distance to the bottom, the mean of the beams that found it, m; NaN if none did."""
        found = [distance for distance in self.distances if math.isfinite(distance)]
        return sum(found) / len(found) if found else _NAN


class Beam(NamedTuple):
    """What one beam saw; NaN is unknown or invalid. Three beams and their angles make a velocity.

    Attributes:
        sentence: "PNORBT" or "PNORBT0".
        beam: from 1.
        time: of day, s.
        velocity: along the beam, m/s, positive towards the transducer.
        fom: figure of merit; m/s in PNORBT0, a number without unit in PNORBT.
        distance: vertical, m.
        water_velocity: along the beam, m/s.
        status: bits.
    """

    sentence: str
    beam: int
    time: float
    velocity: float
    fom: float
    distance: float
    water_velocity: float
    status: int


_TAGS_7 = (b"TIME", b"DT1", b"DT2", b"VX", b"VY", b"VZ", b"FOM", b"D1", b"D2", b"D3", b"D4")
_TAGS_9 = (*_TAGS_7, b"BATT", b"SS", b"PRESS", b"TEMP", b"STAT")
_TAGS_0 = (b"BEAM", b"DATE", b"TIME", b"DT1", b"DT2", b"BV", b"FOM", b"DIST", b"STAT")
_TAGS = (*_TAGS_0[:6], b"FM", b"DIST", b"WV", b"STAT")
_XYZ = {b"PNORBT6": _TAGS_7, b"PNORBT7": _TAGS_7, b"PNORBT8": _TAGS_9, b"PNORBT9": _TAGS_9}
_BEAMS = {b"PNORBT": _TAGS, b"PNORBT0": _TAGS_0, b"PNORBT1": _TAGS_0}


def decode(line: bytes) -> Velocity | Beam | None:
    """Return the message of a line without its end; None for another sentence.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    f = fields(line)
    if f[0] in _XYZ:
        return _velocity(_values(f, _XYZ[f[0]]))
    if f[0] in _BEAMS:
        return _beam(f[0] == b"PNORBT", _values(f, _BEAMS[f[0]]))
    return None


def _values(f: list[bytes], tags: tuple[bytes, ...]) -> list[bytes]:
    """Return the fields in the order of their tags, without them where they have any."""
    at_least(len(tags), f)
    values = f[1 : len(tags) + 1]
    if b"=" not in values[0]:
        return values
    for k, tag in enumerate(tags):
        name, equals, values[k] = values[k].partition(b"=")
        if name != tag or not equals:
            raise SentenceError(f"{f[0]!r} with {f[k + 1]!r}: must be {tag.decode()}=")
    return values


def _speed(field: bytes) -> float:
    value = number(field)
    return _NAN if value <= INVALID_VELOCITY else value


def _fom(field: bytes) -> float:
    value = number(field)
    return _NAN if value >= INVALID_FOM else value


def _distance(field: bytes) -> float:
    value = number(field)
    return value if value > 0.0 else _NAN


def _bits(field: bytes) -> int:
    digits = field[2:] if field[:2] in (b"0x", b"0X") else field
    if not 0 < len(digits) <= 8 or digits.strip(b"0123456789abcdefABCDEF"):
        raise SentenceError(f"status {field!r}: must be at most eight hexadecimal digits")
    return int(digits, 16)


def _velocity(v: list[bytes]) -> Velocity:
    message = Velocity(
        number(v[0]),
        number(v[1]) * MS,
        number(v[2]) * MS,
        _speed(v[3]),
        _speed(v[4]),
        _speed(v[5]),
        _fom(v[6]),
        (_distance(v[7]), _distance(v[8]), _distance(v[9]), _distance(v[10])),
    )
    if len(v) == len(_TAGS_7):
        return message
    return message._replace(
        battery=number(v[11]),
        sound_speed=number(v[12]),
        pressure=number(v[13]) * DBAR,
        temperature=number(v[14]) + CELSIUS,
        status=_bits(v[15]),
    )


def _beam(signature: bool, v: list[bytes]) -> Beam:
    beam, time, velocity, distance, status = count(v[0], 0), clock(v[2]), _speed(v[5]), _distance(v[7]), _bits(v[-1])
    if signature:
        return Beam("PNORBT", beam, time, velocity, number(v[6]), distance, _speed(v[8]), status)
    return Beam("PNORBT0", beam, time, velocity, _fom(v[6]), distance, _NAN, status)


def _told(value: float, invalid: float, decimals: int) -> str:
    return f"{value if math.isfinite(value) else invalid:.{decimals}f}"


def encode(message: Velocity | Beam) -> bytes:
    """Return the line of a message, with CR LF: PNORBT7, with a status PNORBT9 (0.1 mm/s, cm); of a beam its own."""
    m = message
    if isinstance(m, Beam):
        speeds = f"{_told(m.velocity, INVALID_VELOCITY, 5)},{_told(m.fom, INVALID_FOM, 5)},{_told(m.distance, 0.0, 2)}"
        start = f"{m.sentence},{m.beam},010100,{written_clock(m.time)}00,0.000,0.000,{speeds}"
        if m.sentence == "PNORBT":
            return sentence(f"{start},{_told(m.water_velocity, INVALID_VELOCITY, 5)},{m.status:02X}")
        return sentence(f"{start},0x{m.status:08X}")
    times = f"{m.time:.4f},{_told(m.since_trigger / MS, 0.0, 3)},{_told(m.since_output / MS, 0.0, 3)}"
    speeds = ",".join([_told(v, INVALID_VELOCITY, 4) for v in (m.vx, m.vy, m.vz)])
    distances = ",".join([_told(d, 0.0, 2) for d in m.distances])
    body = f"{times},{speeds},{_told(m.fom, INVALID_FOM, 5)},{distances}"
    if m.status == UNKNOWN:
        return sentence(f"PNORBT7,{body}")
    water = f"{m.battery:.1f},{m.sound_speed:.1f},{m.pressure / DBAR:.3f},{m.temperature - CELSIUS:.2f}"
    return sentence(f"PNORBT9,{body},{water},0x{m.status:08X}")


def lines() -> Lines[Velocity | Beam]:
    """Return a decoder of the device's lines."""
    return Lines(decode, LONGEST_LINE)
