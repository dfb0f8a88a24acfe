"""A u-blox receiver in the words of pyubx2."""

import math

from pyubx2 import GET, UBXMessage

from firmware_py.adapters.drivers.ublox import UBLOX
from tests.contract.device import FAR_FIXES, FIXES, Device, damaged


def encode(truth, clock, **changed) -> bytes:
    place = {"lat": math.degrees(truth.latitude), "lon": math.degrees(truth.longitude), "hAcc": round(truth.std * 1e3)}
    state = {"fixType": 3, "gnssFixOk": 1, "numSV": 12, "iTOW": round(clock * 1e3) % 604_800_000}
    return UBXMessage("NAV", "NAV-PVT", GET, **place, **state | changed).serialize()


DEVICE = Device(
    "ublox",
    UBLOX,
    FIXES,
    FAR_FIXES,
    encode,
    damaged,
    (
        encode(FIXES[0], 1.0, gnssFixOk=0),
        encode(FIXES[0], 1.0, fixType=1),
        encode(FIXES[0], 1.0, invalidLlh=1),
        encode(FIXES[0]._replace(std=0.0), 1.0),
    ),
    tolerance=(2e-9, 2e-9, 1e-3),
    clocked=True,
)
