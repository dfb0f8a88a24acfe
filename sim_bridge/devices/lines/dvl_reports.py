"""DVLs: Water Linked (serial line, JSON over TCP), Nortek, PD6. They ping by themselves, and are not told anything.

Without bottom lock each says so in its own way, with the numbers that it sends then.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable

from firmware_py.records.sensing import Dvl
from firmware_py.wire.serial import nortek_dvl, pd6, waterlink_dvl, waterlink_json
from firmware_py.wire.serial.stream import Lines, SentenceError
from sim_bridge.devices.lines.firmware import Talker

UNLOCKED = Dvl(0.0, 0.0, 0.0, 0.0, -1.0)
"""The values that a Water Linked sends without bottom lock."""
_UNKNOWN = Dvl(math.nan, math.nan, math.nan, math.nan, math.nan)
_ALL_VALID, _DISTANCES_VALID = 0x000F_FFFF, 0x0000_00F0
_EPOCH = 1_700_000_000.0
"""A Nortek tells Unix time: its clock was set once, s."""
DAY = 86400.0


def _waterlink_reports() -> Callable[[Dvl | None, float, float], waterlink_dvl.Velocity]:
    """Return what makes reports, each with the time since the last one."""
    last_us = 0

    def velocity(dvl: Dvl | None, valid: float, now: float) -> waterlink_dvl.Velocity:
        nonlocal last_us
        u, v, w, fom, altitude = dvl or UNLOCKED
        covariance = (fom * fom, 0.0, 0.0, 0.0, fom * fom, 0.0, 0.0, 0.0, fom * fom)
        valid_us, sent_us = round(valid * 1e6), round(now * 1e6)
        since_last_ms = (valid_us - last_us) / 1000.0 if last_us else 0.0
        last_us = valid_us
        return waterlink_dvl.Velocity(
            u, v, w, dvl is not None, altitude, fom, covariance, valid_us, sent_us, since_last_ms, status=0
        )

    return velocity


def waterlink() -> Talker:
    """Return the program of an A50 or A125 on its serial line."""
    velocity = _waterlink_reports()
    return Talker(lambda dvl, valid, now: waterlink_dvl.encode(velocity(dvl, valid, now)))


def nortek() -> Talker:
    """Return the program of one that sends PNORBT9."""

    def report(dvl: Dvl | None, valid: float, now: float) -> bytes:
        u, v, w, fom, altitude = dvl or _UNKNOWN
        age, status = now - valid, _ALL_VALID if dvl is not None else _DISTANCES_VALID
        distances, water = (altitude,) * 4, (24.0, 1500.0, 2e5, 285.0)
        velocity = nortek_dvl.Velocity(_EPOCH + valid, age, -age, u, v, w, fom, distances, *water, status)
        return nortek_dvl.encode(velocity)

    return Talker(report)


def pd6_of(teledyne: bool) -> Talker:
    """Return the program of one that sends PD6, with the axes of Teledyne (beam 3 forward) or of Water Linked."""

    def report(dvl: Dvl | None, valid: float, _now: float) -> bytes:
        u, v, w, _, altitude = dvl or _UNKNOWN
        x, y, z = (v, u, -w) if teledyne else (u, v, w)
        return pd6.encode(pd6.BottomTrack(valid % DAY, x, y, z, 0.0, dvl is not None, altitude, 0.0))

    return Talker(report)


class WaterlinkJson:
    """A Water Linked over TCP: its reports, and an answer to each command; pings end when it is told so."""

    hears = True

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Ping, with the speed of sound of the factory."""
        self._velocity = _waterlink_reports()
        self._commands = Lines(_command, waterlink_json.LONGEST_LINE)
        self._settings: dict[str, object] = {
            "speed_of_sound": 1475,
            "acoustic_enabled": True,
            "dark_mode_enabled": False,
            "mounting_rotation_offset": 0.0,
            "range_mode": "auto",
        }

    def report(self, dvl: Dvl | None, valid: float, now: float) -> bytes:
        """Return a report of velocity, or nothing while pings are off."""
        velocity = self._velocity(dvl, valid, now)
        return waterlink_json.encode(velocity) if self._settings["acoustic_enabled"] else b""

    def answer(self, data: bytes) -> bytes:
        """Return the response to each command."""
        return b"".join([self._obey(*command) for command in self._commands.feed(data)])

    def _obey(self, name: str, parameters: dict[str, object]) -> bytes:
        result, error = None, ""
        if name == "get_config":
            result = self._settings
        elif name == "set_config" and parameters.keys() <= self._settings.keys():
            self._settings |= parameters
        elif name not in ("trigger_ping", "reset_dead_reckoning", "calibrate_gyro"):
            error = f"cannot {name[:40]}"
        content = {"response_to": name, "success": not error, "error_message": error, "result": result}
        return json.dumps(content | {"format": "json_v3.1", "type": "response"}).encode() + b"\r\n"


def _command(line: bytes) -> tuple[str, dict[str, object]]:
    try:
        told = json.loads(line)
        name, parameters = told["command"], told.get("parameters") or {}
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise SentenceError("not a command") from None
    if not isinstance(name, str) or not isinstance(parameters, dict):
        raise SentenceError("not a command")
    return name, parameters
