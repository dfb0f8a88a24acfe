"""Satellite receivers: a u-blox of generation 9, and one that speaks NMEA 0183. Under water they have no fix."""

from __future__ import annotations

import math

from firmware_py.records.sensing import Fix
from firmware_py.wire.serial import nmea0183, ubx, ubx_config
from firmware_py.wire.serial.nmea_messages import Position, PositionSigma
from sim_bridge.devices.lines.firmware import Pace, Talker

WEEK, DAY = 604800.0, 86400.0
SATELLITES, HDOP = 12, 0.9
_PORT = "uart1"
_FACTORY = {
    ubx_config.RATE_MEAS: 1000,
    ubx_config.RATE_NAV: 1,
    ubx_config.DYNAMIC_MODEL: 0,
    **dict.fromkeys(ubx_config.PVT_ON.values(), 0),
    **dict.fromkeys(ubx_config.UBX_OUT.values(), 1),
    **dict.fromkeys(ubx_config.NMEA_OUT.values(), 1),
}


def _known(fix: Fix | None) -> bool:
    return fix is not None and math.isfinite(fix.latitude + fix.longitude + fix.std)


def _position(fix: Fix | None, valid: float) -> Position:
    if fix is None or not _known(fix):
        return Position("GGA", valid % DAY, math.nan, math.nan, 0, 0)
    return Position("GGA", valid % DAY, fix.latitude, fix.longitude, 1, SATELLITES, HDOP, 0.0, 0.0)


def _sentences(fix: Fix | None, valid: float, _now: float) -> bytes:
    sigma = nmea0183.encode(PositionSigma(valid % DAY, fix.std, fix.std, 2.0 * fix.std)) if fix and _known(fix) else b""
    return sigma + nmea0183.encode(_position(fix, valid))


def nmea_receiver() -> Talker:
    """Return the program of one that sends GST and GGA with every fix."""
    return Talker(_sentences)


class Ublox:
    """The program of a u-blox: sentences (GGA) once a second from the factory, then what it is told.

    It takes CFG-VALSET of the values in `ubx_config`, and the older CFG-RATE and CFG-MSG of NAV-PVT; what else it is
    told to set is refused. A rate is at most that of the sensor. What it was told is lost without power.
    """

    hears = True

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Go back to the settings of the factory."""
        self._commands = ubx.commands()
        self._set(_FACTORY)

    def report(self, fix: Fix | None, valid: float, _now: float) -> bytes:
        """Return the messages of a fix that are due."""
        if not self._fixes.due(valid):
            return b""
        sent = b""
        if self._values[ubx_config.PVT_ON[_PORT]] and self._values[ubx_config.UBX_OUT[_PORT]]:
            sent += ubx.encode(_nav_pvt(fix, valid))
        if self._values[ubx_config.NMEA_OUT[_PORT]]:
            sent += nmea0183.encode(_position(fix, valid))
        return sent

    def answer(self, data: bytes) -> bytes:
        """Return the ACK of each setting: taken, or refused."""
        told = [(kind, payload) for kind, payload in self._commands.feed(data) if kind[0] == ubx.CFG_VALSET[0]]
        return b"".join([ubx.encode(ubx.Ack(self._obey(kind, payload), kind)) for kind, payload in told])

    def _obey(self, kind: bytes, payload: bytes) -> bool:
        if kind == ubx.CFG_VALSET:
            try:
                values = ubx_config.values_of(payload)
            except ValueError:
                return False
        elif kind == ubx.CFG_RATE and len(payload) == 6:
            values = {ubx_config.RATE_MEAS: int.from_bytes(payload[:2], "little"), ubx_config.RATE_NAV: payload[2]}
        elif kind == ubx.CFG_MSG and len(payload) == 3 and payload[:2] == ubx.NAV_PVT:
            values = {ubx_config.PVT_ON[_PORT]: payload[2]}
        else:
            return False
        values = self._values | values
        if values.keys() != _FACTORY.keys() or values[ubx_config.RATE_MEAS] < 25 or not values[ubx_config.RATE_NAV]:
            return False
        self._set(values)
        return True

    def _set(self, values: dict[int, int]) -> None:
        self._values = values
        self._fixes = Pace(1e3 / (values[ubx_config.RATE_MEAS] * values[ubx_config.RATE_NAV]))


def _nav_pvt(fix: Fix | None, valid: float) -> ubx.NavPvt:
    found = fix is not None and _known(fix)
    latitude, longitude, std = fix if fix is not None and found else Fix(0.0, 0.0, 1e4)
    day = valid % DAY
    return ubx.NavPvt(
        time_of_week=valid % WEEK,
        date=(2026, 1, 1),
        time=(int(day // 3600.0), int(day // 60.0 % 60.0), int(day % 60.0)),
        valid=7 if found else 0,
        time_accuracy=3e-8,
        nano=round(day % 1.0 * 1e9),
        fix=3 if found else 0,
        flags=int(found),
        satellites=SATELLITES if found else 0,
        longitude=longitude,
        latitude=latitude,
        height=0.0,
        altitude=0.0,
        horizontal_accuracy=std,
        vertical_accuracy=2.0 * std,
        velocity=(0.0, 0.0, 0.0),
        speed=0.0,
        course=0.0,
        speed_accuracy=0.1 if found else 1e3,
        course_accuracy=math.pi,
        pdop=1.5 if found else 99.99,
    )
