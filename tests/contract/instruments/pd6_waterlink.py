"""A DVL that speaks PD6 with the axes of Water Linked."""

import math

from firmware_py.adapters.drivers.pd6_dvl import PD6_WATERLINK
from tests.contract.device import FAR_VELOCITIES, VELOCITIES, Device


def ensemble(x, y, z, altitude, clock, good="A") -> bytes:
    hundredths = round(clock * 100) % 8_640_000
    seconds, hundredths = divmod(hundredths, 100)
    date = f"261123{seconds // 3600:02d}{seconds // 60 % 60:02d}{seconds % 60:02d}{hundredths:02d}"
    lines = (
        ":SA, +1.23, -0.45,123.45",
        f":TS,{date},35.0,+10.0,  12.3,1500.0,  0",
        f":BI,{round(1e3 * x):+6d},{round(1e3 * y):+6d},{round(1e3 * z):+6d},    +3,{good}",
        ":BS,    +0,    +0,    +0,A",
        ":BE,    +0,    +0,    +0,A",
        f":BD,       +0.00,       +0.00,       +0.00,{altitude:7.2f},  0.00",
    )
    return "".join(f"{line}\r\n" for line in lines).encode()


def encode(truth, clock, good="A") -> bytes:
    return ensemble(truth.u, truth.v, truth.w, truth.altitude, clock, good)


def corrupt(content: bytes) -> bytes:
    """The format has no checksum: a comma is missing in the line of the velocity."""
    return content.replace(b":BI,", b":BI ", 1)


def without_merit(truths):
    return tuple(truth._replace(fom=math.nan) for truth in truths)


DEVICE = Device(
    "pd6_waterlink",
    PD6_WATERLINK,
    without_merit(VELOCITIES),
    without_merit(FAR_VELOCITIES),
    encode,
    corrupt,
    (encode(VELOCITIES[0], 1.0, good="V"), encode(VELOCITIES[0]._replace(u=-32.768), 1.0)),
    tolerance=6e-4,
    clocked=True,
    family="pd6",
    summed=False,
)
