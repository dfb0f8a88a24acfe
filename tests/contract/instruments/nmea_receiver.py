"""A satellite receiver in the words of pynmeagps: accuracy, then position."""

import datetime
import math

from pynmeagps import GET, NMEAMessage

from firmware_py.adapters.drivers.nmea_receiver import NMEA_RECEIVER
from tests.contract.device import FAR_FIXES, FIXES, Device, damaged


def moment(clock) -> datetime.time:
    hundredths = round(clock * 100) % 8_640_000
    seconds, hundredths = divmod(hundredths, 100)
    return datetime.time(seconds // 3600, seconds // 60 % 60, seconds % 60, hundredths * 10_000)


def accuracy(std, clock) -> bytes:
    content = {"stdLat": std, "stdLong": std, "stdAlt": 2.0 * std}
    return NMEAMessage("GN", "GST", GET, time=moment(clock), **content).serialize()


def position(truth, clock, quality=1, satellites=12) -> bytes:
    latitude, longitude = math.degrees(truth.latitude), math.degrees(truth.longitude)
    fix = {"quality": quality, "numSV": satellites, "HDOP": 0.9}
    content = fix | {"alt": 1.0, "sep": 40.0, "altUnit": "M", "sepUnit": "M"}
    place = {"lat": latitude, "NS": "NS"[latitude < 0], "lon": longitude, "EW": "EW"[longitude < 0]}
    return NMEAMessage("GN", "GGA", GET, time=moment(clock), **place, **content).serialize()


def encode(truth, clock, quality=1, satellites=12) -> bytes:
    return accuracy(truth.std, clock) + position(truth, clock, quality, satellites)


def corrupt(content: bytes) -> bytes:
    sigma, place, _ = content.split(b"\r\n")
    return sigma + b"\r\n" + damaged(place) + b"\r\n"


DEVICE = Device(
    "nmea_receiver",
    NMEA_RECEIVER,
    FIXES,
    FAR_FIXES,
    encode,
    corrupt,
    (
        encode(FIXES[0], 1.0, quality=0),
        encode(FIXES[0], 2.0, quality=6),
        encode(FIXES[0], 3.0, quality=8),
        encode(FIXES[0], 4.0, satellites=0),
        encode(FIXES[0], 5.0, satellites=2),
    ),
    tolerance=(2e-9, 2e-9, 1e-3),
    clocked=True,
    family="nmea",
)
