"""An Xsens MTi as it comes: Euler angles against east, north, up, of axes forward, to port, up."""

import math
import struct

from firmware_py.adapters.drivers.xsens_ahrs import XSENS
from tests.contract.device import ATTITUDES, FAR_ATTITUDES, Device, damaged


def encode(truth, clock, status=3) -> bytes:
    roll, pitch, yaw = truth.phi, -truth.theta, math.pi / 2 - truth.psi
    items = (
        (0x1060, struct.pack(">I", round(clock * 1e4) % 2**32)),
        (0x2030, struct.pack(">3f", *map(math.degrees, (roll, pitch, yaw)))),
        (0x8020, struct.pack(">3f", truth.p, -truth.q, -truth.r)),
        (0xE020, struct.pack(">I", status)),
    )
    data = b"".join(struct.pack(">HB", kind, len(content)) + content for kind, content in items)
    body = bytes((0xFF, 0x36, len(data))) + data
    return b"\xfa" + body + bytes((-sum(body) % 256,))


DEVICE = Device(
    "xsens",
    XSENS,
    ATTITUDES,
    FAR_ATTITUDES,
    encode,
    damaged,
    (encode(ATTITUDES[0], 1.0, status=1), encode(ATTITUDES[0]._replace(theta=math.nan), 1.0)),
    tolerance=1e-5,
    clocked=True,
)
