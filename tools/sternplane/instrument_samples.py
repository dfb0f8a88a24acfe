"""What each instrument sends, by its codec: for measuring what a message costs, and for mutating it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from firmware_py.wire.serial import (
    depth_sentences,
    microstrain,
    nmea0183,
    nortek_dvl,
    pd6,
    ping,
    sbg,
    ubx,
    vectornav,
    waterlink_dvl,
    waterlink_json,
    xsens,
)
from firmware_py.wire.serial.nmea_messages import BelowTransducer, Position, PositionSigma

_RATES = (0.25, -0.125, 0.0625)
_ANGLES, _QUATERNION = (0.1, -0.2, 1.5), (0.7, 0.1, -0.05, 0.7)


def _waterlink(t: float) -> waterlink_dvl.Velocity:
    us = round(t * 1e6)
    return waterlink_dvl.Velocity(1.5, -0.02, 0.1, True, 12.3, 0.005, (1e-6,) * 9, us, us + 90_000, 200.0, 0)


def _nortek(t: float) -> bytes:
    distances = (5.0, 5.1, 5.2, 5.3)
    velocity = nortek_dvl.Velocity(1.7e9 + t, 0.1, -0.1, 1.5, 0.1, -0.2, 0.003, distances, 24.0, 1500.0, 1e5, 285.0)
    return nortek_dvl.encode(velocity._replace(status=0x000F_FFFF))


def _pd6(t: float) -> bytes:
    return pd6.encode(pd6.BottomTrack(t % 86400.0, 1.5, -0.02, 0.1, 0.003, True, 12.3, 0.0))


def _vectornav(t: float) -> bytes:
    return vectornav.encode(vectornav.Attitude(_ANGLES, _QUATERNION, _RATES, t, 0))


def _microstrain(t: float) -> bytes:
    return microstrain.encode(microstrain.Attitude(_ANGLES, _QUATERNION, _RATES, t, state=3, flags=0))


def _xsens(t: float) -> bytes:
    return xsens.encode(xsens.Attitude(quaternion=_QUATERNION, rates=_RATES, frame="NED", time=t, status=3))


def _sbg(t: float) -> bytes:
    attitude = sbg.Attitude(t, quaternion=_QUATERNION, deviations=(0.01, 0.01, 0.02), status=0x32)
    return sbg.encode(attitude) + sbg.encode(sbg.Rates(t, _RATES, 0x3FF))


def _nmea(t: float) -> bytes:
    time = t % 86400.0
    return nmea0183.encode(Position("GGA", time, 0.64, -2.13, 1, 12, 0.9, 1.0, 40.0)) + nmea0183.encode(
        PositionSigma(time, 2.0, 2.0, 4.0)
    )


def _ublox(t: float) -> bytes:
    fix = (3, 1, 12, -2.13, 0.64, 40.0, 1.0, 2.0, 4.0, (0.5, -0.25, 0.1), 0.5, 0.1, 0.05, 0.02, 1.2)
    return ubx.encode(ubx.NavPvt(t % 604800.0, (2026, 11, 23), (8, 0, 0), 7, 1e-9, 0, *fix))


SAMPLES: Mapping[str, Callable[[float], bytes]] = {
    "waterlink": lambda t: waterlink_dvl.encode(_waterlink(t)),
    "waterlink_json": lambda t: waterlink_json.encode(_waterlink(t)),
    "nortek": _nortek,
    "pd6_teledyne": _pd6,
    "pd6_waterlink": _pd6,
    "vectornav": _vectornav,
    "microstrain": _microstrain,
    "xsens": _xsens,
    "sbg": _sbg,
    "nmea_receiver": _nmea,
    "ublox": _ublox,
    "nmea_sounder": lambda _: nmea0183.encode(BelowTransducer("DPT", 12.3, -0.5), "SD"),
    "ping": lambda t: ping.encode(ping.Distance(12.345, 0.97, 450e-6, round(100 * t), 0.5, 30.0, 3)),
    "isd4000": lambda _: depth_sentences.encode(depth_sentences.Depth("ISDPT", 10.0, 2e5, 285.0)),
    "valeport": lambda _: depth_sentences.encode(depth_sentences.Depth("PIPS", float("nan"), 1e5)),
}
"""A measurement of each of `INSTRUMENTS`, stamped with a time of the device's clock, s."""


class Silence:
    """A byte stream that brings nothing: a driver on it is given its bytes by hand."""

    openings = 1

    def read(self, _t: float) -> bytes:
        """Return nothing."""
        return b""

    def write(self, data: bytes) -> None:
        """Send nowhere."""

    def losses(self) -> dict[str, int]:
        """Return nothing."""
        return {}

    def close(self) -> None:
        """Leave nothing."""
