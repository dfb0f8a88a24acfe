"""Packets of u-blox receivers (protocol UBX): NAV-PVT and ACK; configuration that switches NAV-PVT on.

A packet is B5 62, class, id, length of the payload (2 bytes), payload, and two bytes of checksum: Fletcher's with 8
bits over all between B5 62 and itself. Numbers are little-endian. Facts: u-blox interface descriptions, M8 (protocol
15 to 23) and F9 (protocol 27 and above). NAV-PVT (01 07) has 92 bytes, 84 before protocol 15: iTOW ms, UTC, flags of
what is valid, lon and lat 1e-7 degrees, heights and accuracies mm, velocity north, east, down mm/s, headings 1e-5
degrees, pDOP 0.01. ACK-ACK (05 01) and ACK-NAK (05 00) name the class and id that they answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from struct import Struct
from typing import NamedTuple, TypeVar

from firmware_py.wire.serial.checksums import fletcher
from firmware_py.wire.serial.stream import ChecksumError, Packets, SentenceError

M = TypeVar("M")
SYNC = b"\xb5\x62"
LONGEST_PACKET = 100
"""NAV-PVT, bytes. Longer packets are of other kinds: they are passed over, and counted as too long."""
LONGEST_COMMAND = 1024
"""64 values in one CFG-VALSET have 780 bytes."""
_AROUND = 8
"""Bytes of a packet beside its payload."""
NAV_PVT, ACK_NAK, ACK_ACK = b"\x01\x07", b"\x05\x00", b"\x05\x01"
CFG_MSG, CFG_RATE, CFG_VALSET = b"\x06\x01", b"\x06\x08", b"\x06\x8a"
_PVT = Struct("<IH6BIi4B4i2I5i2I2H")
"""The first 80 of its bytes; what follows (heading of the vehicle, declination) is not read."""
_PVT_SIZES = (84, 92)
_ANGLE, _COURSE = math.radians(1e-7), math.radians(1e-5)


class NavPvt(NamedTuple):
    """Position, velocity and time.

    Attributes:
        time_of_week: of the fix, GPS time, s.
        date: year, month, day, UTC.
        time: hour, minute, second, UTC; with `nano` (ns, also negative) the time of the fix.
        valid: bits: 1 date, 2 time, 4 fully resolved, 8 declination.
        time_accuracy: s.
        fix: 0 none, 1 dead reckoning only, 2 in two dimensions, 3 in three, 4 with dead reckoning, 5 time only.
        flags: bits: 1 fix within the limits of accuracy, 2 differential, 64 carrier phase float, 128 fixed.
        satellites: how many are used.
        longitude: rad.
        latitude: rad.
        height: above the ellipsoid, m.
        altitude: above mean sea level, m.
        horizontal_accuracy: m, estimated.
        vertical_accuracy: m.
        velocity: north, east, down, m/s.
        speed: over ground, m/s.
        course: over ground, from true north, rad.
        speed_accuracy: m/s.
        course_accuracy: rad.
        pdop: dilution of precision.
        invalid_position: longitude, latitude and heights are not valid (protocol 27 and above).
    """

    time_of_week: float
    date: tuple[int, int, int]
    time: tuple[int, int, int]
    valid: int
    time_accuracy: float
    nano: int
    fix: int
    flags: int
    satellites: int
    longitude: float
    latitude: float
    height: float
    altitude: float
    horizontal_accuracy: float
    vertical_accuracy: float
    velocity: tuple[float, float, float]
    speed: float
    course: float
    speed_accuracy: float
    course_accuracy: float
    pdop: float
    invalid_position: bool = False

    @property
    def usable(self) -> bool:
        """Return True if the receiver vouches for position and velocity: a fix by satellites, within its limits."""
        return 2 <= self.fix <= 4 and bool(self.flags & 1) and not self.invalid_position

    @property
    def time_of_day(self) -> float:
        """Return the UTC of the fix, s since midnight (of the day before or after too); NaN if it is not known."""
        hour, minute, second = self.time
        known = self.valid & 3 == 3
        return 3600.0 * hour + 60.0 * minute + second + 1e-9 * self.nano if known else math.nan


class Ack(NamedTuple):
    """The answer to a configuration: taken or refused; the class and the id of what it answers."""

    taken: bool
    answered: bytes


def packet(kind: bytes, payload: bytes) -> bytes:
    """Return a packet of a class and id."""
    body = kind + len(payload).to_bytes(2, "little") + payload
    return SYNC + body + fletcher(body)


def decode(whole: bytes) -> NavPvt | Ack | None:
    """Return the message of a packet; None for another kind.

    Raises:
        SentenceError: bad checksum, not of this protocol, or of a wrong length.
    """
    kind, payload = unpacked(whole)
    if kind == NAV_PVT:
        return _pvt(payload)
    if kind not in (ACK_ACK, ACK_NAK):
        return None
    if len(payload) != 2:
        raise SentenceError(f"ACK with {len(payload)} bytes: must be 2")
    return Ack(kind == ACK_ACK, payload)


def unpacked(whole: bytes) -> tuple[bytes, bytes]:
    """Return the kind (class and id) of a packet, and its payload.

    Raises:
        SentenceError: bad checksum, or not of this protocol.
    """
    body = whole[2:-2]
    if len(whole) < _AROUND or whole[:2] != SYNC or len(whole) != _AROUND + int.from_bytes(whole[4:6], "little"):
        raise SentenceError("not a packet: must be B5 62, a header, the payload that it tells, and a checksum")
    if fletcher(body) != whole[-2:]:
        raise ChecksumError(f"checksum is {whole[-2:].hex()}: must be {fletcher(body).hex()}")
    return body[:2], body[4:]


def _pvt(payload: bytes) -> NavPvt:
    if len(payload) not in _PVT_SIZES:
        raise SentenceError(f"NAV-PVT with {len(payload)} bytes: must be 84 or 92")
    v = _PVT.unpack_from(payload)
    return NavPvt(
        time_of_week=v[0] * 1e-3,
        date=v[1:4],
        time=v[4:7],
        valid=v[7],
        time_accuracy=v[8] * 1e-9,
        nano=v[9],
        fix=v[10],
        flags=v[11],
        satellites=v[13],
        longitude=v[14] * _ANGLE,
        latitude=v[15] * _ANGLE,
        height=v[16] * 1e-3,
        altitude=v[17] * 1e-3,
        horizontal_accuracy=v[18] * 1e-3,
        vertical_accuracy=v[19] * 1e-3,
        velocity=(v[20] * 1e-3, v[21] * 1e-3, v[22] * 1e-3),
        speed=v[23] * 1e-3,
        course=v[24] * _COURSE,
        speed_accuracy=v[25] * 1e-3,
        course_accuracy=v[26] * _COURSE,
        pdop=v[27] * 0.01,
        invalid_position=len(payload) == _PVT_SIZES[1] and bool(v[28] & 1),
    )


def _units(value: float, unit: float, bits: int = 31) -> int:
    """Return how many units a value is: 31 bits and a sign, or 16 or 32 bits without; NaN is the most."""
    low, high = (-(1 << 31), (1 << 31) - 1) if bits == 31 else (0, (1 << bits) - 1)
    scaled = value / unit
    return high if math.isnan(scaled) else round(min(max(scaled, low), high))


def encode(message: NavPvt | Ack) -> bytes:
    """Return the packet of a message, NAV-PVT with 92 bytes; a number out of its range becomes the nearest one."""
    if isinstance(message, Ack):
        return packet(ACK_ACK if message.taken else ACK_NAK, message.answered)
    m = message
    payload = _PVT.pack(
        _units(m.time_of_week, 1e-3, 32),
        *m.date,
        *m.time,
        m.valid,
        _units(m.time_accuracy, 1e-9, 32),
        m.nano,
        m.fix,
        m.flags,
        0,
        m.satellites,
        _units(m.longitude, _ANGLE),
        _units(m.latitude, _ANGLE),
        _units(m.height, 1e-3),
        _units(m.altitude, 1e-3),
        _units(m.horizontal_accuracy, 1e-3, 32),
        _units(m.vertical_accuracy, 1e-3, 32),
        *[_units(v, 1e-3) for v in m.velocity],
        _units(m.speed, 1e-3),
        _units(m.course % math.tau, _COURSE),
        _units(m.speed_accuracy, 1e-3, 32),
        _units(m.course_accuracy, _COURSE, 32),
        _units(m.pdop, 0.01, 16),
        int(m.invalid_position),
    )
    return packet(NAV_PVT, payload.ljust(_PVT_SIZES[1], b"\0"))


def packets() -> Packets[NavPvt | Ack]:
    """Return a decoder of the receiver's bytes; sentences in between are passed over."""
    return _packets(decode, LONGEST_PACKET)


def commands() -> Packets[tuple[bytes, bytes]]:
    """Return a decoder of what a receiver is told: kinds and payloads."""
    return _packets(unpacked, LONGEST_COMMAND)


def _packets(decode: Callable[[bytes], M | None], longest: int) -> Packets[M]:
    return Packets(SYNC, 6, lambda header: _AROUND + int.from_bytes(header[4:6], "little"), decode, longest)
