"""Every instrument by the name that an io file gives it: one line each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from firmware_py.adapters.drivers.bar30 import Bar30
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
from firmware_py.wire.serial.ms5837 import BAR02


class I2cSensor(NamedTuple):
    """A sensor on an I2C bus: what it measures; makes its driver from a name, a bus, latency and number."""

    role: str
    driver: Callable[..., Bar30]


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
"""Those that send messages on a stream of bytes: a serial line, or TCP."""
I2C_SENSORS: Mapping[str, I2cSensor] = {
    "bar30": I2cSensor("pressure", Bar30),
    "bar02": I2cSensor("pressure", partial(Bar30, unversioned=BAR02)),
}
"""Those on a bus i2c:N, see `i2c_bus`."""
