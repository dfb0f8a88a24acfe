"""A MicroStrain sensor: angles, rates and status of its filter, with the reference time."""

import itertools
import math
import struct

from firmware_py.adapters.drivers.microstrain_ahrs import MICROSTRAIN
from tests.contract.device import ATTITUDES, FAR_ATTITUDES, Device, damaged


def encode(truth, clock, state=3, valid=1) -> bytes:
    contents = (
        (0xD5, struct.pack(">Q", round(clock * 1e9))),
        (0x05, struct.pack(">3fH", *truth[:3], valid)),
        (0x0E, struct.pack(">3fH", *truth[3:], valid)),
        (0x10, struct.pack(">3H", state, 1, 0)),
    )
    payload = b"".join(bytes((len(content) + 2, kind)) + content for kind, content in contents)
    packet = b"\x75\x65\x82" + bytes((len(payload),)) + payload
    return packet + bytes((sum(packet) % 256, sum(itertools.accumulate(packet)) % 256))


DEVICE = Device(
    "microstrain",
    MICROSTRAIN,
    ATTITUDES,
    FAR_ATTITUDES,
    encode,
    damaged,
    (
        encode(ATTITUDES[0], 1.0, state=1),
        encode(ATTITUDES[0], 1.0, state=2),
        encode(ATTITUDES[0], 1.0, valid=0),
        encode(ATTITUDES[0]._replace(r=math.inf), 1.0),
    ),
    tolerance=1e-5,
    clocked=True,
)
