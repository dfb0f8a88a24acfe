"""The channels of sensors: each number that a sensor measures, by the name under which faults know it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from firmware_py.marine import GRAVITY, depth_of_pressure, wrap

SENSORS = ("ahrs", "dvl", "pressure", "altimeter", "fix", "battery", "leak")
_AIR, _DENSITY = 101325.0, 1000.0
"""Pa and kg/m^3: a pressure is given as the depth that it means in fresh water."""
_NUMBER = re.compile(r"\.[2-4](?=\.|$)")
"""Of a device that is not the first of its kind."""
_EARTH_RADIUS = 6.371e6
_MOST: Mapping[str, float] = {"deg": 360.0, "deg/s": 1000.0, "m/s": 100.0, "m": 12000.0, "%": 100.0}
"""By unit; more than the deepest sea has, m."""
_FAR = 1e5
"""Of a position, m: what a receiver may be off by."""


class Channel(NamedTuple):
    """One number of a sensor's reading.

    Attributes:
        sensor: which one measures it.
        unit: in which faults give it.
        get: reading's value -> number, SI.
        put: (reading's value, number) -> reading's value.
        most: what a fault may give it or take from it, either way, in `unit`.
        is_share: whether it lies in [0, most] by what it is, so that no sensor can show anything else.
    """

    sensor: str
    unit: str
    get: Callable[[Any], float]
    put: Callable[[Any, float], Any]
    most: float
    is_share: bool = False


def base_of(target: str) -> str:
    """Return the target of the first device of a kind: "pressure" of "pressure.2", "ahrs.roll" of "ahrs.2.roll"."""
    return _NUMBER.sub("", target, count=1)


def sensor_of(target: str) -> str:
    """Return the sensor of a sensor's or channel's name: "ahrs.2" of "ahrs.2.roll", "ahrs" of "ahrs.roll"."""
    number = _NUMBER.search(target)
    return base_of(target).partition(".")[0] + (number[0] if number else "")


def channel_of(target: str) -> Channel:
    """Return a channel by its name, that of a further sensor too."""
    return CHANNELS[base_of(target)]


def _field(sensor: str, name: str, unit: str) -> Channel:
    share = unit == "%"
    most = _MOST[unit]
    return Channel(
        sensor, unit, lambda value: getattr(value, name), lambda value, x: value._replace(**{name: x}), most, share
    )


def _number(sensor: str, unit: str) -> Channel:
    return Channel(sensor, unit, lambda value: value, lambda _, x: x, _MOST[unit], unit == "%")


CHANNELS: Mapping[str, Channel] = {
    "ahrs.roll": _field("ahrs", "phi", "deg"),
    "ahrs.pitch": _field("ahrs", "theta", "deg"),
    "ahrs.yaw": Channel(
        "ahrs", "deg", lambda a: a.psi, lambda a, x: a._replace(psi=wrap(x) if x == x else x), _MOST["deg"]
    ),
    "ahrs.p": _field("ahrs", "p", "deg/s"),
    "ahrs.q": _field("ahrs", "q", "deg/s"),
    "ahrs.r": _field("ahrs", "r", "deg/s"),
    "dvl.u": _field("dvl", "u", "m/s"),
    "dvl.v": _field("dvl", "v", "m/s"),
    "dvl.w": _field("dvl", "w", "m/s"),
    "dvl.altitude": _field("dvl", "altitude", "m"),
    "pressure": Channel(
        "pressure",
        "m",
        lambda pressure: depth_of_pressure(pressure, _AIR, _DENSITY),
        lambda _, depth: _AIR + depth * _DENSITY * GRAVITY,
        _MOST["m"],
    ),
    "altimeter": _number("altimeter", "m"),
    "fix.north": Channel(
        "fix",
        "m",
        lambda fix: fix.latitude * _EARTH_RADIUS,
        lambda fix, x: fix._replace(latitude=x / _EARTH_RADIUS),
        _FAR,
    ),
    "fix.east": Channel(
        "fix",
        "m",
        lambda fix: fix.longitude * _EARTH_RADIUS * math.cos(fix.latitude),
        lambda fix, x: fix._replace(longitude=x / (_EARTH_RADIUS * math.cos(fix.latitude))),
        _FAR,
    ),
    "battery": _field("battery", "remaining", "%"),
    "leak": _number("leak", "%"),
}
