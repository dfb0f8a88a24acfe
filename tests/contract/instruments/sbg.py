"""An SBG sensor: Euler angles, and then the rates of the same moment."""

import math
import struct

from firmware_py.adapters.drivers.sbg_ahrs import SBG
from tests.contract.device import ATTITUDES, FAR_ATTITUDES, Device, damaged

GYROS = 0b10_1110_0011
HEADING_AND_TILT = 0x32


def crc(data: bytes) -> int:
    """CRC-16 of polynomial x^16 + x^12 + x^5 + 1, reflected, bit by bit."""
    found = 0
    for byte in data:
        found ^= byte
        for _ in range(8):
            found = found >> 1 ^ (0x8408 if found & 1 else 0)
    return found


def frame(kind: int, data: bytes) -> bytes:
    body = bytes((kind, 0)) + struct.pack("<H", len(data)) + data
    return b"\xff\x5a" + body + struct.pack("<H", crc(body)) + b"\x33"


def encode(truth, clock, status=HEADING_AND_TILT, gyros=GYROS) -> bytes:
    time = round(clock * 1e6) % 2**32
    rates = [round(rate * 67108864.0) for rate in truth[3:]]
    return frame(6, struct.pack("<I6fI", time, *truth[:3], 0.01, 0.01, 0.02, status)) + frame(
        44, struct.pack("<IH3i3ih", time, gyros, 0, 0, 0, *rates, 2000)
    )


def corrupt(content: bytes) -> bytes:
    """The first frame is damaged; rates alone are not heard."""
    return damaged(content[:40]) + content[40:]


DEVICE = Device(
    "sbg",
    SBG,
    ATTITUDES,
    FAR_ATTITUDES,
    encode,
    corrupt,
    (
        encode(ATTITUDES[0], 1.0, status=0x31),
        encode(ATTITUDES[0], 1.0, gyros=GYROS & ~1),
        encode(ATTITUDES[0]._replace(phi=math.nan), 1.0),
    ),
    tolerance=1e-5,
    clocked=True,
)
