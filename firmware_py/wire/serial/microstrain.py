"""MicroStrain inertial sensors (3DM-GX5, CX5, CV5, CV7, GQ7): attitude and angular rates in MIP packets; commands.

Facts are those of the maker's protocol manuals and of the headers of its MIP SDK. A packet is 75 65, descriptor set,
length of the payload, payload, checksum (Fletcher, two sums modulo 256 of all before it). The payload is fields: length
(with its own two bytes of head), descriptor, content. Numbers are big-endian.

Set 82, the estimation filter: quaternion (03), Euler angles (05), compensated angular rate (0E), each with a word that
is 1 if it is valid; status (10); GPS time stamp (11). Set 80, the sensors: angular rate (05), and quaternion (0A) and
Euler angles (0C) of the complementary filter, which say nothing about validity; GPS time stamp (12). In both: GPS time
stamp (D3), reference time (D5). Attitude is that of the device's axes (x forward, y right, z down, unless it is told
another mounting) against north, east, down: roll, pitch, yaw in rad, turned yaw first; a quaternion with its scalar
first. Rates are in rad/s.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from typing import Final, NamedTuple

from firmware_py.wire.serial.checksums import fletcher
from firmware_py.wire.serial.stream import ChecksumError, Packets, SentenceError

LONGEST = 261
"""The longest packet, bytes."""

SENSOR: Final = 0x80
FILTER: Final = 0x82

_UNKNOWN: Final = (math.nan,) * 3
_STAMP = struct.Struct(">dHH")
_FLAGGED, _UNFLAGGED = struct.Struct(">3fH"), struct.Struct(">3f")
_SHARED = {0xD3: ("week_time", _STAMP), 0xD5: ("time", struct.Struct(">Q"))}
_FIELDS: Final = {
    FILTER: {
        0x03: ("quaternion", struct.Struct(">4fH")),
        0x05: ("angles", _FLAGGED),
        0x0E: ("rates", _FLAGGED),
        0x10: ("status", struct.Struct(">3H")),
        0x11: ("week_time", _STAMP),
        **_SHARED,
    },
    SENSOR: {
        0x05: ("rates", _UNFLAGGED),
        0x0A: ("quaternion", struct.Struct(">4f")),
        0x0C: ("angles", _UNFLAGGED),
        0x12: ("week_time", _STAMP),
        **_SHARED,
    },
}
"""What is read, by descriptor set and descriptor."""

_OLD_FORMAT = {SENSOR: 0x08, FILTER: 0x0A}
_OLD_STREAM = {SENSOR: 0x01, FILTER: 0x03}
_WRITE = b"\x01"
_VALID_OLDER, _HEADING_KNOWN = 2, 3
"""State of the filter of a GX5, CX5 or CV5 that is right; least one of that of a CV7 or GQ7 that knows its heading."""


class Attitude(NamedTuple):
    """What one packet tells; what it does not is NaN, or -1 as a number of the status.

    Attributes:
        angles: roll, pitch, yaw, rad.
        quaternion: w, x, y, z, from the device's axes to north, east, down.
        rates: angular rates p, q, r, rad/s.
        time: of the device's own clock, which never jumps, s.
        week_time: seconds of the week; without GPS it is the device's own clock.
        valid: the device calls every one of the fields that were sent valid; those of the sensors say nothing, and are.
        state: of the filter. 0 starting, 1 initializing; then by family: GX5, CX5, CV5 2 valid, 3 error; CV7, GQ7
            2 vertical gyro, whose heading counts from switch-on, 3 attitude and heading, 4 full navigation.
        flags: warnings of the filter, bits that differ by family too.
        filtered: from the estimation filter, not the sensors.
    """

    angles: tuple[float, float, float] = _UNKNOWN
    quaternion: tuple[float, float, float, float] = (*_UNKNOWN, math.nan)
    rates: tuple[float, float, float] = _UNKNOWN
    time: float = math.nan
    week_time: float = math.nan
    valid: bool = True
    state: int = -1
    flags: int = -1
    filtered: bool = True

    @property
    def usable(self) -> bool:
        """Return True if an attitude is known and valid, and the filter does not say that it has no heading, or fails.

        The families CV7 and GQ7 alone know the reference time.
        """
        known = math.isfinite(sum(self.angles)) or math.isfinite(sum(self.quaternion))
        runs = self.state == _VALID_OLDER if math.isnan(self.time) else self.state >= _HEADING_KNOWN
        return known and self.valid and (runs or self.state < 0)


def decode(packet: bytes) -> Attitude | None:
    """Return what a packet tells of attitude, rates and status; None for a packet without any of these.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    _check(packet)
    if packet[2] not in _FIELDS:
        return None
    told, valid = _read(packet)
    if told.keys() <= {"time", "week_time"}:
        return None
    angles, quaternion, rates = (told.get(name) for name in ("angles", "quaternion", "rates"))
    state, _, flags = told.get("status", (-1, -1, -1))
    return Attitude(
        (angles[0], angles[1], angles[2]) if angles else _UNKNOWN,
        (quaternion[0], quaternion[1], quaternion[2], quaternion[3]) if quaternion else (*_UNKNOWN, math.nan),
        (rates[0], rates[1], rates[2]) if rates else _UNKNOWN,
        told["time"][0] / 1e9 if "time" in told else math.nan,
        told["week_time"][0] if "week_time" in told else math.nan,
        valid,
        int(state),
        int(flags),
        packet[2] == FILTER,
    )


def _check(packet: bytes) -> None:
    if packet[:2] != b"ue" or len(packet) < 6 or len(packet) != packet[3] + 6:
        raise SentenceError(f"packet of {len(packet)} bytes: must be 75 65, set, length, payload and checksum")
    if (right := fletcher(packet[:-2])) != packet[-2:]:
        raise ChecksumError(f"checksum is {packet[-2:].hex()}: must be {right.hex()}")


def unpacked(whole: bytes) -> tuple[int, list[tuple[int, bytes]]]:
    """Return the descriptor set of a packet, and its fields, each a descriptor and its content, as `packet` takes them.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    _check(whole)
    fields, at, end = [], 4, len(whole) - 2
    while at < end:
        length = whole[at]
        if length < 2 or at + length > end:
            raise SentenceError(f"field of {length} bytes: must be 2 or more, within the payload")
        fields.append((whole[at + 1], whole[at + 2 : at + length]))
        at += length
    return whole[2], fields


def _read(packet: bytes) -> tuple[dict[str, tuple[float, ...]], bool]:
    """Return the numbers of each field that is read, and whether all that tell it are valid."""
    fields, told, valid = _FIELDS[packet[2]], {}, True
    at, end = 4, len(packet) - 2
    while at < end:
        length = packet[at]
        if length < 2 or at + length > end:
            raise SentenceError(f"field of {length} bytes: must be 2 or more, within the payload")
        if packet[at + 1] in fields:
            name, form = fields[packet[at + 1]]
            if form.size != length - 2:
                raise SentenceError(f"{name} of {length - 2} bytes: must be {form.size}")
            told[name] = form.unpack_from(packet, at + 2)
            if packet[2] == FILTER and name in ("angles", "quaternion", "rates"):
                valid = valid and bool(told[name][-1] & 1)
        at += length
    return told, valid


def encode(attitude: Attitude) -> bytes:
    """Return the packet of what is known of an attitude, with the reference time and not the GPS time stamp."""
    kind = FILTER if attitude.filtered else SENSOR
    contents = {"angles": attitude.angles, "quaternion": attitude.quaternion, "rates": attitude.rates}
    flag = (int(attitude.valid),) if attitude.filtered else ()
    fields = [] if math.isnan(attitude.time) else [(0xD5, struct.pack(">Q", round(attitude.time * 1e9)))]
    for descriptor, (name, form) in _FIELDS[kind].items():
        if name in contents and not math.isnan(contents[name][0]):
            fields.append((descriptor, form.pack(*contents[name], *flag)))
    if attitude.filtered and attitude.state >= 0:
        fields.append((0x10, struct.pack(">3H", attitude.state, 1, max(attitude.flags, 0))))
    return packet(kind, *fields)


def packet(descriptor_set: int, *fields: tuple[int, bytes]) -> bytes:
    """Return a packet of fields, each a descriptor and its content."""
    payload = b"".join([bytes((len(content) + 2, descriptor)) + content for descriptor, content in fields])
    start = bytes((0x75, 0x65, descriptor_set, len(payload))) + payload
    return start + fletcher(start)


def idle() -> bytes:
    """Return the command that stops all streams."""
    return packet(0x01, (0x02, b""))


def resume() -> bytes:
    """Return the command that resumes the streams that are enabled."""
    return packet(0x01, (0x06, b""))


def message_format(descriptor_set: int, decimations: Mapping[int, int], old: bool = False) -> bytes:
    """Return the command that selects the fields of a set's packets.

    Args:
        descriptor_set: SENSOR or FILTER.
        decimations: by descriptor, the device's own rate divided by the field's, in the order in which they are sent.
        old: in the form that the GX5 family and earlier ones understand.
    """
    rates = b"".join([struct.pack(">BH", *pair) for pair in decimations.items()])
    if old:
        return packet(0x0C, (_OLD_FORMAT[descriptor_set], _WRITE + bytes((len(decimations),)) + rates))
    return packet(0x0C, (0x0F, _WRITE + bytes((descriptor_set, len(decimations))) + rates))


def enable_stream(descriptor_set: int, on: bool = True, old: bool = False) -> bytes:
    """Return the command that starts or stops the packets of a set; `old` as for `message_format`."""
    stream = _OLD_STREAM[descriptor_set] if old else descriptor_set
    return packet(0x0C, (0x11, _WRITE + bytes((stream, on))))


def packets() -> Packets[Attitude]:
    """Return a decoder of the device's packets."""
    return Packets(b"ue", 4, lambda head: head[3] + 6, decode, LONGEST)


def commands() -> Packets[tuple[int, list[tuple[int, bytes]]]]:
    """Return a decoder of what a device is told: descriptor sets and fields."""
    return Packets(b"ue", 4, lambda head: head[3] + 6, unpacked, LONGEST)
