"""A Blue Robotics echosounder in the words of brping."""

from brping import definitions
from brping.pingmessage import PingMessage

from firmware_py.adapters.drivers.ping_sonar import PING
from tests.contract.device import Device, damaged


def encode(truth, clock, confidence=98) -> bytes:
    message = PingMessage(definitions.PING1D_DISTANCE)
    message.src_device_id = 1
    told = {
        "distance": round(truth * 1e3),
        "confidence": confidence,
        "transmit_duration": 450,
        "ping_number": round(clock * 100),
        "scan_start": 500,
        "scan_length": 30_000,
        "gain_setting": 3,
    }
    for name, value in told.items():
        setattr(message, name, value)
    return bytes(message.pack_msg_data())


DEVICE = Device(
    "ping",
    PING,
    (12.345, 0.75, 28.0),
    (0.3, 100.0),
    encode,
    damaged,
    (encode(12.0, 1.0, confidence=0), encode(12.0, 1.0, confidence=49), encode(0.0, 1.0)),
    delay=lambda truth: truth / 1500.0,
)
