"""SBG Systems inertial sensors (Ellipse, Ekinox, Apogee, Quanta): attitude and rates in sbgECom frames.

Facts are those of the maker's protocol description (sbgECom 5). A frame is FF 5A, message id, class, length (2 bytes),
data, CRC-16 of id to data (polynomial 0x1021 reflected, initial value 0), 33. Numbers are little-endian. Data may grow
at its end with the firmware: what is longer than known is read.

Class 0: Euler angles (06), quaternion with its scalar first (07), rates as floats (03, older firmware) and as scaled
integers (44). Attitude is that of the vehicle's axes (x forward, y right, z down, as configured) against true north,
east, down, in rad; rates are in rad/s; time is in us since the start, 32 bits. What is sent, and how often, is
configured with the maker's tools.
"""

from __future__ import annotations

import math
import struct
from binascii import crc_hqx
from typing import Final, NamedTuple

from firmware_py.wire.serial.stream import ChecksumError, Packets, SentenceError

LONGEST = 128
"""The longest frame that is accepted, bytes; those that are read have 41 to 67."""

IMU_DATA: Final = 3
EULER: Final = 6
QUATERNION: Final = 7
IMU_SHORT: Final = 44

_FORMS = {
    IMU_DATA: struct.Struct("<IH12x3f28x"),
    EULER: struct.Struct("<I6fI"),
    QUATERNION: struct.Struct("<I7fI"),
    IMU_SHORT: struct.Struct("<IH12x3i2x"),
}
_UNKNOWN: Final = (math.nan,) * 3
_FINE, _COARSE = 67108864.0, 12304174.0
"""Steps in 1 rad/s of a scaled rate; the second where the status has the bit of the coarse scale."""
_COARSE_SCALE = 1 << 10
_GYROS_GOOD = 0b10_1110_0011
"""Bits of the status: connection, self test, the three gyros, all within their range."""
_REVERSED = bytes([int(f"{byte:08b}"[::-1], 2) for byte in range(256)])


class Attitude(NamedTuple):
    """One attitude: angles or a quaternion; what was not sent is NaN.

    Attributes:
        time: since the device started, s; it starts again from 0 after 4294.967296 s.
        angles: roll, pitch, yaw, rad.
        quaternion: w, x, y, z, from the vehicle's axes to north, east, down.
        deviations: standard deviations of roll, pitch, yaw, rad.
        status: of the solution; bits 0 to 3 are the mode.
    """

    time: float
    angles: tuple[float, float, float] = _UNKNOWN
    quaternion: tuple[float, float, float, float] = (*_UNKNOWN, math.nan)
    deviations: tuple[float, float, float] = _UNKNOWN
    status: int = 0

    @property
    def mode(self) -> int:
        """Return the mode: 0 not initialized, 1 roll and pitch, 2 and heading, 3 and velocity, 4 and position."""
        return self.status & 0xF

    @property
    def tilt_usable(self) -> bool:
        """Return True if the device vouches for roll and pitch."""
        known = math.isfinite(sum(self.angles)) or math.isfinite(sum(self.quaternion))
        return known and self.mode > 0 and bool(self.status & 1 << 4)

    @property
    def usable(self) -> bool:
        """Return True if the device vouches for roll, pitch and heading."""
        return self.tilt_usable and self.mode > 1 and bool(self.status & 1 << 5)


class Rates(NamedTuple):
    """Angular rates p, q, r about the vehicle's axes, rad/s, with time and status of the inertial sensors."""

    time: float
    rates: tuple[float, float, float]
    status: int

    @property
    def usable(self) -> bool:
        """Return True if the gyros work, within their range."""
        return self.status & _GYROS_GOOD == _GYROS_GOOD and math.isfinite(sum(self.rates))


def crc16(data: bytes) -> int:
    """Return the CRC-16: polynomial 0x1021, reflected (0x8408), initial value 0."""
    crc = crc_hqx(data.translate(_REVERSED), 0)
    return _REVERSED[crc & 0xFF] << 8 | _REVERSED[crc >> 8]


def decode(frame: bytes) -> Attitude | Rates | None:
    """Return the attitude or the rates of a frame; None for one of another kind.

    Raises:
        SentenceError: bad checksum, not of this protocol, or malformed.
    """
    if frame[:2] != b"\xff\x5a" or len(frame) < 9 or len(frame) != _size(frame) or frame[-1] != 0x33:
        raise SentenceError(f"frame of {len(frame)} bytes: must be FF 5A, id, class, length, data, CRC and 33")
    right = crc16(frame[2:-3])
    if int.from_bytes(frame[-3:-1], "little") != right:
        raise ChecksumError(f"CRC is {int.from_bytes(frame[-3:-1], 'little'):04x}: must be {right:04x}")
    kind = frame[2]
    if frame[3] or kind not in _FORMS:
        return None
    form = _FORMS[kind]
    if len(frame) - 9 < form.size:
        raise SentenceError(f"message {kind} with {len(frame) - 9} bytes: must be {form.size} or more")
    time, *numbers = form.unpack_from(frame, 6)
    if kind == EULER:
        roll, pitch, yaw, *deviations, status = numbers
        return Attitude(time / 1e6, (roll, pitch, yaw), deviations=_three(deviations), status=status)
    if kind == QUATERNION:
        w, x, y, z, *deviations, status = numbers
        return Attitude(time / 1e6, quaternion=(w, x, y, z), deviations=_three(deviations), status=status)
    status, *rates = numbers
    if kind == IMU_SHORT:
        scale = _COARSE if status & _COARSE_SCALE else _FINE
        rates = [rate / scale for rate in rates]
    return Rates(time / 1e6, _three(rates), status)


def _three(numbers: list[float]) -> tuple[float, float, float]:
    x, y, z = numbers
    return x, y, z


def encode(message: Attitude | Rates) -> bytes:
    """Return the frame of a message: of the quaternion if it is known, else of the angles; rates as scaled integers.

    Rates must be finite; the largest that the scale holds is 174 rad/s.
    """
    time = round(message.time * 1e6) & 0xFFFFFFFF
    if isinstance(message, Attitude):
        rest = (*message.deviations, message.status, 0.0, 0.0)
        if math.isnan(message.quaternion[0]):
            return frame(EULER, struct.pack("<I6fI2f", time, *message.angles, *rest))
        return frame(QUATERNION, struct.pack("<I7fI2f", time, *message.quaternion, *rest))
    coarse = max(map(abs, message.rates)) * _FINE >= 2**31 - 1
    status = message.status & ~_COARSE_SCALE | coarse * _COARSE_SCALE
    limit, scale = 2**31 - 1, _COARSE if coarse else _FINE
    rates = [max(-limit, min(limit, round(rate * scale))) for rate in message.rates]
    return frame(IMU_SHORT, struct.pack("<IH3i3ih", time, status, 0, 0, 0, *rates, 0))


def frame(kind: int, data: bytes) -> bytes:
    """Return the frame of a message of class 0."""
    content = struct.pack("<BBH", kind, 0, len(data)) + data
    return b"\xff\x5a" + content + struct.pack("<HB", crc16(content), 0x33)


def _size(head: bytes) -> int:
    return 9 + int.from_bytes(head[4:6], "little")


def frames() -> Packets[Attitude | Rates]:
    """Return a decoder of the device's frames."""
    return Packets(b"\xff\x5a", 6, _size, decode, LONGEST)
