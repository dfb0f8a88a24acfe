"""A VectorNav that sends packets: time, angles, quaternion, rates; the status of its attitude."""

import math
import struct

from firmware_py.adapters.drivers.vectornav_ahrs import VECTORNAV
from firmware_py.marine import quaternion_from_euler
from tests.contract.device import ATTITUDES, FAR_ATTITUDES, Device, damaged


def crc(data: bytes) -> int:
    """CRC-16 of polynomial x^16 + x^12 + x^5 + 1, bit by bit."""
    found = 0
    for byte in data:
        found ^= byte << 8
        for _ in range(8):
            found = (found << 1 ^ (0x1021 if found & 0x8000 else 0)) & 0xFFFF
    return found


def encode(truth, clock, status=0) -> bytes:
    roll, pitch, yaw, *rates = truth
    angles = (math.degrees(angle) for angle in (yaw, pitch, roll))
    quaternion = quaternion_from_euler(roll, pitch, yaw)
    fields = struct.pack("<Q3f4f3fH", round(clock * 1e9), *angles, *quaternion, *rates, status)
    body = struct.pack("<BHH", 0b1_0001, 0b11_1001, 1) + fields
    return b"\xfa" + body + struct.pack(">H", crc(body))


DEVICE = Device(
    "vectornav",
    VECTORNAV,
    ATTITUDES,
    FAR_ATTITUDES,
    encode,
    damaged,
    (
        encode(ATTITUDES[0], 1.0, status=2),
        encode(ATTITUDES[0], 1.0, status=4),
        encode(ATTITUDES[0]._replace(p=math.nan), 1.0),
    ),
    tolerance=1e-5,
    clocked=True,
)
