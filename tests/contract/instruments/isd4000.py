"""An Impact Subsea ISD4000: depth, absolute pressure, temperature, padded with zeros."""

from firmware_py.adapters.drivers.depth_sensors import ISD4000
from tests.contract.device import Device, damaged, xor_line


def encode(truth, clock) -> bytes:
    return xor_line(f"ISDPT,{(truth - 101_325.0) / 1e4:08.3f},M,{truth / 1e5:08.4f},B,12.34,C")


DEVICE = Device(
    "isd4000",
    ISD4000,
    (101_320.0, 350_000.0, 2_000_000.0),
    (90_000.0, 99_999_990.0),
    encode,
    damaged,
    (xor_line("ISDPT,0010.000,M,,B,12.34,C"), xor_line("PIPS,0010.00,M"), xor_line("PIPS,0010.00,d")),
    tolerance=5.1,
    family="depth",
)
