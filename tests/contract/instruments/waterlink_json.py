"""A Water Linked DVL over TCP."""

import json

from firmware_py.adapters.drivers.waterlink import WATERLINK_JSON
from tests.contract.device import FAR_VELOCITIES, VELOCITIES, Device

AGE = 0.09


def encode(truth, clock, **changed) -> bytes:
    us = round(clock * 1e6)
    report = {
        "time": 106.3,
        "vx": truth.u,
        "vy": truth.v,
        "vz": truth.w,
        "fom": truth.fom,
        "covariance": [[1e-7, 0.0, 0.0]] * 3,
        "altitude": truth.altitude,
        "transducers": [{"id": 0, "velocity": 0.1, "distance": 0.5, "rssi": -30.0, "nsd": -88.0, "beam_valid": True}],
        "velocity_valid": True,
        "status": 0,
        "format": "json_v3.1",
        "type": "velocity",
        "time_of_validity": us,
        "time_of_transmission": us + round(AGE * 1e6),
    }
    return json.dumps(report | changed).encode() + b"\r\n"


def corrupt(content: bytes) -> bytes:
    """JSON has no checksum: a bracket is missing."""
    return content.replace(b"[[", b"[", 1)


DEVICE = Device(
    "waterlink_json",
    WATERLINK_JSON,
    VELOCITIES,
    FAR_VELOCITIES,
    encode,
    corrupt,
    (
        encode(VELOCITIES[0], 1.0, velocity_valid=False),
        encode(VELOCITIES[0], 1.0, time_of_validity=9_000_000, time_of_transmission=0),
    ),
    delay=lambda _: AGE,
    summed=False,
)
