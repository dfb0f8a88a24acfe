"""A Valeport miniIPS that sends decibars above its tare."""

from firmware_py.adapters.drivers.depth_sensors import VALEPORT
from tests.contract.device import Device, damaged, xor_line

AIR = 101_325.0


def encode(truth, clock) -> bytes:
    return xor_line(f"PIPS,{(truth - AIR) / 1e4:07.2f},d")


DEVICE = Device(
    "valeport",
    VALEPORT,
    (AIR, 350_000.0, 2_000_000.0),
    (91_325.0, 60_101_325.0),
    encode,
    damaged,
    (xor_line("PIPS,0010.00,M"), xor_line("PIPS,,d")),
    tolerance=51.0,
    family="depth",
)
