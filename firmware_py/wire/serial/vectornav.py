"""VectorNav VN-100 and its family: attitude, as sentences and as packets.

Facts are those of the maker's VN-100 manual (UM001). Attitude is that of the device's axes (x forward, y right, z down)
against north, east, down: yaw, pitch, roll in degrees, turned in this order; a quaternion with its scalar last; angular
rates in rad/s. A device sends both forms on one line: packets, and lines that answer commands.

Sentences: `$VNYPR,yaw,pitch,roll`, `$VNYMR,yaw,pitch,roll,magnetic(3),acceleration(3),rates(3)` and
`$VNQMR,x,y,z,w,magnetic(3),acceleration(3),rates(3)`; then, if so configured, `,Shhhh` (status, hexadecimal) and
`,Tn` (a counter); then `*` and two hexadecimal digits (XOR of all between `$` and `*`) or four (CRC-16), CR LF.

Packets: FA; a byte with a bit for each of the groups 1 to 7; for each of these a word with a bit for each field; the
fields; CRC-16 of all behind FA, big-endian, with polynomial 0x1021 and initial value 0. All else is little-endian.
"""

from __future__ import annotations

import math
import re
import struct
from typing import Final, NamedTuple

from firmware_py.wire.serial.checksums import xor_sum
from firmware_py.wire.serial.stream import ChecksumError, Kind, Mixed, SentenceError
from firmware_py.wire.serial.vectornav_commands import command, crc16
from firmware_py.wire.serial.vectornav_layout import layout_of, packet_size

LONGEST = 256
"""The longest line or packet that is accepted, bytes."""

_FIELDS = {b"VNYPR": 3, b"VNYMR": 12, b"VNQMR": 13}
_UNKNOWN: Final = (math.nan,) * 3
_BAD = 0b1100
"""Bits of the status: angular rates out of range, and the recovery from it."""


class Attitude(NamedTuple):
    """One attitude; what was not sent is NaN, or -1 as a status.

    Attributes:
        angles: roll, pitch, yaw, rad.
        quaternion: w, x, y, z, from the device's axes to north, east, down.
        rates: angular rates p, q, r, rad/s.
        time: since the device started, s.
        status: the status of the attitude filter; the sentence may carry that of a navigation filter instead, which
            must not be configured.
    """

    angles: tuple[float, float, float] = _UNKNOWN
    quaternion: tuple[float, float, float, float] = (*_UNKNOWN, math.nan)
    rates: tuple[float, float, float] = _UNKNOWN
    time: float = math.nan
    status: int = -1

    @property
    def quality(self) -> int:
        """Return how good the attitude is: 0 excellent, 1 good, 2 bad, 3 not tracking; -1 if it was not sent."""
        return self.status & 3 if self.status >= 0 else -1

    @property
    def usable(self) -> bool:
        """Return True if the attitude is known and the device, where it sends a status, vouches for it."""
        known = math.isfinite(sum(self.angles)) or math.isfinite(sum(self.quaternion))
        return known and (self.status < 0 or (self.quality < 2 and not self.status & _BAD))


def decode(content: bytes) -> Attitude | None:
    """Return the attitude of a packet or a line; None for one of another kind.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    return _decode_packet(content) if content[:1] == b"\xfa" else _decode_line(content)


def _decode_packet(packet: bytes) -> Attitude | None:
    if packet_size(packet) != len(packet):
        raise SentenceError(f"packet of {len(packet)} bytes: its header tells another length")
    if (right := crc16(packet[1:-2])) != int.from_bytes(packet[-2:], "big"):
        raise ChecksumError(f"CRC is {packet[-2:].hex()}: must be {right:04x}")
    begin = 2 + 2 * packet[1].bit_count()
    layout = layout_of(packet[1:begin])
    if layout is None or layout.places.keys() <= {"time"}:
        return None
    numbers, places = layout.numbers.unpack_from(packet, begin), layout.places
    angles, quaternion, rates, time, status = _NOTHING
    if (at := places.get("angles")) is not None:
        angles = _angles(*numbers[at : at + 3])
    if (at := places.get("quaternion")) is not None:
        x, y, z, w = numbers[at : at + 4]
        quaternion = w, x, y, z
    if (at := places.get("rates")) is not None:
        p, q, r = numbers[at : at + 3]
        rates = p, q, r
    if (at := places.get("time")) is not None:
        time = numbers[at] / 1e9
    if (at := places.get("status")) is not None:
        status = numbers[at]
    return Attitude(angles, quaternion, rates, time, status)


def _decode_line(line: bytes) -> Attitude | None:
    body, star, digits = line.rstrip(b"\r\n").partition(b"*")
    if not star or not body.startswith(b"$VN") or len(digits) not in (2, 4):
        raise SentenceError("not a sentence: must be $VN..., a star and two or four hexadecimal digits")
    right = b"%02X" % xor_sum(body[1:]) if len(digits) == 2 else b"%04X" % crc16(body[1:])
    if right != digits.upper():
        raise ChecksumError(f"checksum is {digits!r}: must be {right.decode()}")
    name, *fields = body[1:].split(b",")
    if name not in _FIELDS:
        return None
    count = _FIELDS[name]
    try:
        numbers, status = [*map(float, fields[:count])], -1
        for field in fields[count:]:
            if field[:1] not in (b"S", b"T"):
                raise ValueError(f"{field!r}: must be S or T and a number")
            status = int(field[1:], 16) if field[:1] == b"S" else status
    except ValueError as error:
        raise SentenceError(f"{name.decode()} with a field that is not a number: {error}") from None
    if len(numbers) != count:
        raise SentenceError(f"{name.decode()} with {len(numbers)} numbers: must be {count}")
    p, q, r = numbers[-3:] if count > 3 else _UNKNOWN
    if name == b"VNQMR":
        x, y, z, w = numbers[:4]
        return Attitude(quaternion=(w, x, y, z), rates=(p, q, r), status=status)
    return Attitude(_angles(*numbers[:3]), rates=(p, q, r), status=status)


_NOTHING = Attitude()


def _angles(yaw: float, pitch: float, roll: float) -> tuple[float, float, float]:
    return math.radians(roll), math.radians(pitch), math.radians(yaw)


def encode(attitude: Attitude) -> bytes:
    """Return the packet of what is known of an attitude: group 1, and the status in group 5."""
    roll, pitch, yaw = map(math.degrees, attitude.angles)
    w, x, y, z = attitude.quaternion
    fields, content = 0, b""
    for bit, form, numbers in (
        (0, "<Q", (attitude.time if math.isnan(attitude.time) else round(attitude.time * 1e9),)),
        (3, "<3f", (yaw, pitch, roll)),
        (4, "<4f", (x, y, z, w)),
        (5, "<3f", attitude.rates),
    ):
        if not math.isnan(numbers[0]):
            fields |= 1 << bit
            content += struct.pack(form, *numbers)
    if attitude.status < 0:
        packet = struct.pack("<BH", 0x01, fields) + content
    else:
        packet = struct.pack("<BHH", 0x11, fields, 1) + content + struct.pack("<H", attitude.status)
    return b"\xfa" + packet + crc16(packet).to_bytes(2, "big")


def encode_line(attitude: Attitude, name: str = "VNYMR", crc: bool = False) -> bytes:
    """Return the sentence of an attitude in the device's precision; what is not read (magnetic, acceleration) is 0.

    Args:
        attitude: its angles must be known; for VNQMR its quaternion; its rates but for VNYPR.
        name: VNYPR, VNYMR or VNQMR.
        crc: ends it with the CRC-16 instead of the 8-bit checksum.
    """
    roll, pitch, yaw = map(math.degrees, attitude.angles)
    w, x, y, z = attitude.quaternion
    if name == "VNQMR":
        text = f"{name},{x:+09.6f},{y:+09.6f},{z:+09.6f},{w:+09.6f}"
    else:
        text = f"{name},{yaw:+08.3f},{pitch:+08.3f},{roll:+08.3f}"
    if name != "VNYPR":
        p, q, r = attitude.rates
        text += ",+00.0000" * 3 + ",+00.000" * 3 + f",{p:+010.6f},{q:+010.6f},{r:+010.6f}"
    return command(text + (f",S{attitude.status:04X}" if attitude.status >= 0 else ""), crc)


_BREAK = re.compile(rb"[^ -#%-~]")
"""What a line cannot go on with."""


def _line_size(head: bytes) -> int:
    end = _BREAK.search(head, 1)
    if end is None:
        return len(head) + 1
    return end.end() if end.group() in b"\r\n" else 0


def messages() -> Mixed[Attitude]:
    """Return a decoder of the device's packets and lines, mixed in any way."""
    return Mixed({b"\xfa": Kind(packet_size, decode), b"$VN": Kind(_line_size, decode)}, LONGEST)
