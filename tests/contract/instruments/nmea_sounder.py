"""An echo sounder in the words of pynmeagps."""

from pynmeagps import GET, NMEAMessage

from firmware_py.adapters.drivers.nmea_sounder import NMEA_SOUNDER
from tests.contract.device import Device, damaged


def encode(truth, clock) -> bytes:
    return NMEAMessage("SD", "DPT", GET, depth=truth, offset=-0.5).serialize()


DEVICE = Device(
    "nmea_sounder",
    NMEA_SOUNDER,
    (12.3, 4.5, 100.0),
    (0.1, 9999.9),
    encode,
    damaged,
    (encode(0.0, 1.0), NMEAMessage("SD", "DPT", GET, depth="", offset="").serialize()),
    tolerance=0.051,
    family="nmea",
)
