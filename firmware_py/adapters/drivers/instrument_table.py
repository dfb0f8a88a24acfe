"""Every instrument by the name that an io file gives it: one line each."""

from __future__ import annotations

from collections.abc import Mapping

from firmware_py.adapters.drivers.depth_sensors import ISD4000, VALEPORT
from firmware_py.adapters.drivers.microstrain_ahrs import MICROSTRAIN
from firmware_py.adapters.drivers.nmea_receiver import NMEA_RECEIVER
from firmware_py.adapters.drivers.nmea_sounder import NMEA_SOUNDER
from firmware_py.adapters.drivers.nortek import NORTEK
from firmware_py.adapters.drivers.pd6_dvl import PD6_TELEDYNE, PD6_WATERLINK
from firmware_py.adapters.drivers.ping_sonar import PING
from firmware_py.adapters.drivers.sbg_ahrs import SBG
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.adapters.drivers.ublox import UBLOX
from firmware_py.adapters.drivers.vectornav_ahrs import VECTORNAV
from firmware_py.adapters.drivers.waterlink import WATERLINK, WATERLINK_JSON
from firmware_py.adapters.drivers.xsens_ahrs import XSENS

INSTRUMENTS: Mapping[str, Instrument] = {
    "waterlink": WATERLINK,
    "waterlink_json": WATERLINK_JSON,
    "nortek": NORTEK,
    "pd6_teledyne": PD6_TELEDYNE,
    "pd6_waterlink": PD6_WATERLINK,
    "vectornav": VECTORNAV,
    "microstrain": MICROSTRAIN,
    "xsens": XSENS,
    "sbg": SBG,
    "nmea_receiver": NMEA_RECEIVER,
    "ublox": UBLOX,
    "nmea_sounder": NMEA_SOUNDER,
    "ping": PING,
    "isd4000": ISD4000,
    "valeport": VALEPORT,
}
"""Those that send messages on a stream of bytes, a serial line or TCP; `bar30` is on an I2C bus."""
