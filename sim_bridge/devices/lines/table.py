"""The simulated instrument of each driver of an io file: one line each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from sim_bridge.devices.lines.attitude_sensors import MicroStrain, Xsens, sbg_sensor
from sim_bridge.devices.lines.depth_sensors import isd4000, valeport
from sim_bridge.devices.lines.dvl_reports import WaterlinkJson, nortek, pd6_of, waterlink
from sim_bridge.devices.lines.firmware import Firmware
from sim_bridge.devices.lines.receivers import Ublox, nmea_receiver
from sim_bridge.devices.lines.sounders import Ping, nmea_sounder
from sim_bridge.devices.lines.vectornav import VectorNav
from sim_bridge.devices.ms5837_sensor import Ms5837, bar02

FIRMWARE: Mapping[str, Callable[[], Firmware]] = {
    "waterlink": waterlink,
    "waterlink_json": WaterlinkJson,
    "nortek": nortek,
    "pd6_teledyne": partial(pd6_of, teledyne=True),
    "pd6_waterlink": partial(pd6_of, teledyne=False),
    "vectornav": VectorNav,
    "microstrain": MicroStrain,
    "xsens": Xsens,
    "sbg": sbg_sensor,
    "nmea_receiver": nmea_receiver,
    "ublox": Ublox,
    "nmea_sounder": nmea_sounder,
    "ping": Ping,
    "isd4000": isd4000,
    "valeport": valeport,
}
"""Makes the program of an instrument, by the name of its driver (`firmware_py.adapters.drivers.instrument_table`)."""
I2C_CHIPS: Mapping[str, Callable[[], Ms5837]] = {"bar30": Ms5837, "bar02": bar02}
"""Makes what is on a simulated I2C bus, by the name of its driver."""
