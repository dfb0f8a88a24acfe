"""Xsens MTi: orientation and rate of turn in MTData2 messages of the Xbus protocol; commands.

Facts are those of the maker's Low Level Communication Protocol (MT0101P). A message is FA, bus id FF, message id,
length of the data, data, and a byte that makes the sum of all behind FA a multiple of 256. Numbers are big-endian.
Messages of the extended length, with more than 254 bytes of data, are not read: what is read takes far less.

The data of MTData2 (36) is items: identifier (2 bytes), length, content. Read are packet counter (1020), sample time
(1060, 0.1 ms), quaternion (201y), Euler angles (203y, roll, pitch, yaw in degrees), rate of turn (802y, rad/s), status
byte (E010) and status word (E020); other items are skipped. Bits 0 and 1 of y tell the form of the numbers: float32,
fixed 12.20, fixed 16.32 (the fraction, then the integer part), float64. Bits 2 and 3 tell the earth's axes: 0 east,
north, up; 4 north, east, down; 8 north, west, up.

Orientation turns the sensor's axes into these. Every rotation is right-handed about the axes at hand: yaw is 0 where
the sensor's x points along the first of them, and grows from the first towards the second, so to the left in the two
systems with z up. Rates are about the sensor's axes.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from typing import Final, NamedTuple

from firmware_py.wire.serial.stream import ChecksumError, Packets, SentenceError

LONGEST = 259
"""The longest message that is read, bytes."""

FLOAT32: Final = 0
FIXED_12_20: Final = 1
FIXED_16_32: Final = 2
FLOAT64: Final = 3

PACKET_COUNTER: Final = 0x1020
SAMPLE_TIME_FINE: Final = 0x1060
QUATERNION: Final = 0x2010
EULER_ANGLES: Final = 0x2030
RATE_OF_TURN: Final = 0x8020
STATUS_BYTE: Final = 0xE010
STATUS_WORD: Final = 0xE020

FRAMES: Final = {0x0: "ENU", 0x4: "NED", 0x8: "NWU"}
"""The earth's axes, by the bits of an identifier."""

_UNKNOWN: Final = (math.nan,) * 3
_COUNTS = {QUATERNION: 4, EULER_ANGLES: 3, RATE_OF_TURN: 3}
_WHOLE = {PACKET_COUNTER: 2, SAMPLE_TIME_FINE: 4, STATUS_BYTE: 1, STATUS_WORD: 4}
_SIZES = (4, 4, 6, 8)
_MTDATA2 = 0x36
_BITS = {name: bits for bits, name in FRAMES.items()}


class Attitude(NamedTuple):
    """What one message tells; what it does not is NaN, -1 as a whole number, or an empty text.

    Attributes:
        angles: roll, pitch, yaw, rad.
        quaternion: w, x, y, z, from the sensor's axes to the earth's.
        rates: rate of turn about the sensor's axes, rad/s.
        frame: the earth's axes: ENU, NED or NWU.
        time: of the sensor's clock, s; it starts again from 0 after 2**32 steps of 0.1 ms (119 h).
        counter: of messages, 16 bits.
        status: the status word, or the byte, which is the same bits 0 to 7.
    """

    angles: tuple[float, float, float] = _UNKNOWN
    quaternion: tuple[float, float, float, float] = (*_UNKNOWN, math.nan)
    rates: tuple[float, float, float] = _UNKNOWN
    frame: str = ""
    time: float = math.nan
    counter: int = -1
    status: int = -1

    @property
    def usable(self) -> bool:
        """Return True if an orientation is known and, where a status was sent, its filter's input is valid (bit 1)."""
        known = math.isfinite(sum(self.angles)) or math.isfinite(sum(self.quaternion))
        return known and bool(self.status & 2)


def decode(message: bytes) -> Attitude | None:
    """Return what a message tells; None for one of another kind, or without orientation, rates and status.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    kind, _ = unpacked(message)
    if kind != _MTDATA2:
        return None
    reals, whole, frame = _items(message)
    status = whole.get(STATUS_WORD, whole.get(STATUS_BYTE, -1))
    if not reals and status < 0:
        return None
    angles, quaternion, rates = _UNKNOWN, (*_UNKNOWN, math.nan), _UNKNOWN
    if EULER_ANGLES in reals:
        roll, pitch, yaw = map(math.radians, reals[EULER_ANGLES])
        angles = roll, pitch, yaw
    if QUATERNION in reals:
        w, x, y, z = reals[QUATERNION]
        quaternion = w, x, y, z
    if RATE_OF_TURN in reals:
        p, q, r = reals[RATE_OF_TURN]
        rates = p, q, r
    time = whole[SAMPLE_TIME_FINE] / 1e4 if SAMPLE_TIME_FINE in whole else math.nan
    return Attitude(angles, quaternion, rates, frame, time, whole.get(PACKET_COUNTER, -1), status)


def unpacked(message: bytes) -> tuple[int, bytes]:
    """Return the id of a message, and its data, as `command` takes them.

    Raises:
        SentenceError: bad checksum, or not of this protocol.
    """
    if message[:2] != b"\xfa\xff" or len(message) < 5 or len(message) != _size(message):
        raise SentenceError(f"message of {len(message)} bytes: must be FA FF, id, length, data and checksum")
    if sum(message[1:]) & 0xFF:
        raise ChecksumError(f"checksum is {message[-1]:02x}: must be {-sum(message[1:-1]) & 0xFF:02x}")
    return message[2], message[4:-1]


def _items(message: bytes) -> tuple[dict[int, tuple[float, ...]], dict[int, int], str]:
    """Return the items that are read, by identifier without its form: real numbers, whole numbers; and the frame."""
    reals: dict[int, tuple[float, ...]] = {}
    whole: dict[int, int] = {}
    frame, at, end = "", 4, len(message) - 1
    while at < end:
        length = message[at + 2] if at + 3 <= end else LONGEST
        identifier, content = int.from_bytes(message[at : at + 2], "big"), message[at + 3 : at + 3 + length]
        at += 3 + length
        if at > end:
            raise SentenceError("item longer than the data")
        kind = identifier & 0xFFF0
        if kind in _COUNTS:
            reals[kind] = _numbers(content, identifier & 3, _COUNTS[kind])
            if kind != RATE_OF_TURN:
                frame = _frame(identifier, frame)
        elif identifier in _WHOLE:
            if length != _WHOLE[identifier]:
                raise SentenceError(f"item {identifier:04x} of {length} bytes: must be {_WHOLE[identifier]}")
            whole[identifier] = int.from_bytes(content, "big")
    return reals, whole, frame


def _frame(identifier: int, before: str) -> str:
    frame = FRAMES.get(identifier & 0xC)
    if frame is None or before not in ("", frame):
        raise SentenceError(f"item {identifier:04x} with axes {frame}: must be ENU, NED or NWU, the same in all")
    return frame


def _numbers(content: bytes, form: int, count: int) -> tuple[float, ...]:
    if len(content) != count * _SIZES[form]:
        raise SentenceError(f"item of {len(content)} bytes: must be {count} numbers of {_SIZES[form]}")
    if form == FLOAT32:
        return struct.unpack(f">{count}f", content)
    if form == FLOAT64:
        return struct.unpack(f">{count}d", content)
    if form == FIXED_12_20:
        return tuple([number / 2**20 for number in struct.unpack(f">{count}i", content)])
    parts = struct.unpack(">" + "Ih" * count, content)
    return tuple([high + low / 2**32 for low, high in zip(parts[::2], parts[1::2], strict=True)])


def _content(numbers: Iterable[float], form: int) -> bytes:
    if form in (FLOAT32, FLOAT64):
        return b"".join([struct.pack(">f" if form == FLOAT32 else ">d", number) for number in numbers])
    if form == FIXED_12_20:
        return b"".join([struct.pack(">i", round(number * 2**20)) for number in numbers])
    fixed = [round(number * 2**32) for number in numbers]
    return b"".join([struct.pack(">Ih", number & 0xFFFFFFFF, number >> 32) for number in fixed])


def encode(attitude: Attitude, form: int = FLOAT32) -> bytes:
    """Return the message of what is known of an attitude.

    Args:
        attitude: with the frame of its orientation.
        form: FLOAT32, FIXED_12_20, FIXED_16_32 or FLOAT64; the fixed ones hold finite numbers below 2**11 and 2**15.
    """
    items, bits = [], form | _BITS.get(attitude.frame, 0)
    if attitude.counter >= 0:
        items.append((PACKET_COUNTER, struct.pack(">H", attitude.counter)))
    if not math.isnan(attitude.time):
        items.append((SAMPLE_TIME_FINE, struct.pack(">I", round(attitude.time * 1e4) & 0xFFFFFFFF)))
    if not math.isnan(attitude.quaternion[0]):
        items.append((QUATERNION | bits, _content(attitude.quaternion, form)))
    if not math.isnan(attitude.angles[0]):
        items.append((EULER_ANGLES | bits, _content(map(math.degrees, attitude.angles), form)))
    if not math.isnan(attitude.rates[0]):
        items.append((RATE_OF_TURN | form, _content(attitude.rates, form)))
    if attitude.status >= 0:
        items.append((STATUS_WORD, struct.pack(">I", attitude.status)))
    return command(_MTDATA2, b"".join([struct.pack(">HB", kind, len(content)) + content for kind, content in items]))


def command(message_id: int, data: bytes = b"") -> bytes:
    """Return a message with its checksum."""
    content = bytes((0xFF, message_id, len(data))) + data
    return b"\xfa" + content + bytes((-sum(content) & 0xFF,))


def go_to_config() -> bytes:
    """Return the command that stops measuring, so that settings can be changed."""
    return command(0x30)


def go_to_measurement() -> bytes:
    """Return the command that starts measuring."""
    return command(0x10)


def set_output_configuration(rates: Iterable[tuple[int, int]]) -> bytes:
    """Return the command that selects what is sent: identifiers, and how often each, Hz (65535: in every message)."""
    return command(0xC0, b"".join([struct.pack(">HH", *pair) for pair in rates]))


def _size(head: bytes) -> int:
    return 0 if head[3] == 0xFF else head[3] + 5


def messages() -> Packets[Attitude]:
    """Return a decoder of the sensor's messages."""
    return Packets(b"\xfa\xff", 4, _size, decode, LONGEST)


def commands() -> Packets[tuple[int, bytes]]:
    """Return a decoder of what a sensor is told: message ids and data."""
    return Packets(b"\xfa\xff", 4, _size, unpacked, LONGEST)
