"""The velocity report of a Water Linked DVL A50 or A125 over TCP (port 16171): lines of JSON, decoded and encoded.

Each line is an object. Its `type` is `velocity` (over the bottom), which is read, or another (`velocity_water`,
`position_local`, `response`), which is skipped. A velocity has `time` (ms since the last report), `vx`, `vy`, `vz` and
`fom` (m/s), `covariance` (three rows, (m/s)²), `altitude` (m), `velocity_valid`, `status`, `time_of_validity` and
`time_of_transmission` (Unix time, us), in the axes of the device: x forward, y to starboard, z down. `transducers`,
what each beam has measured, is not read. There is no checksum: TCP has its own.

Source: Water Linked, "DVL A50/A125 TCP JSON API", `json_v3.3`; this page names no field that 3.0 lacks. Another major
version is refused: its fields may mean something else.
"""

from __future__ import annotations

import json
from typing import Any, NoReturn

from firmware_py.wire.serial.stream import Lines, SentenceError
from firmware_py.wire.serial.waterlink_dvl import Velocity

PORT = 16171
LONGEST_LINE = 2048
"""The longest line that is accepted, bytes; a report with four transducers has about 1200."""
_FORMAT = "json_v3"
_LARGEST = 1e12
"""No number of the device is larger but its times."""
_MOST_BRACKETS = 64
"""A report has 10; as many as a line can hold would exhaust the parser's stack."""


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number of JSON")


_JSON = json.JSONDecoder(parse_constant=_refuse_constant)


def encode(report: Velocity) -> bytes:
    """Return the line of a report, with LF, in the device's precision (floats as they are) and without transducers."""
    c = report.covariance
    fields = {
        "time": report.time_ms,
        "vx": report.vx,
        "vy": report.vy,
        "vz": report.vz,
        "fom": report.fom,
        "covariance": [c[0:3], c[3:6], c[6:9]],
        "altitude": report.altitude,
        "transducers": [],
        "velocity_valid": report.valid,
        "status": report.status,
        "format": "json_v3.1",
        "type": "velocity",
        "time_of_validity": report.time_of_validity_us,
        "time_of_transmission": report.time_of_transmission_us,
    }
    return json.dumps(fields, separators=(",", ":")).encode() + b"\n"


def decode(line: bytes) -> Velocity | None:
    """Return the report of a line without its end; None for another message of the device.

    Raises:
        SentenceError: not JSON, not a message, or malformed.
    """
    if line.count(b"[") + line.count(b"{") > _MOST_BRACKETS:
        raise SentenceError(f"more than {_MOST_BRACKETS} brackets: must be a message of the device")
    try:
        fields = _JSON.decode(str(line, "utf-8"))
    except ValueError as error:
        raise SentenceError(f"not a message: must be JSON; {error}") from None
    kind = fields.get("type") if isinstance(fields, dict) else None
    if not isinstance(kind, str):
        raise SentenceError("not a message: must be an object with a type")
    if kind != "velocity":
        return None
    version = fields.get("format")
    if not isinstance(version, str) or version.partition(".")[0] != _FORMAT:
        raise SentenceError(f"velocity in the format {version!r}: must be {_FORMAT}.x")
    valid = fields.get("velocity_valid")
    if not isinstance(valid, bool):
        raise SentenceError(f"velocity_valid = {valid!r}: must be true or false")
    return Velocity(
        _number(fields, "vx"),
        _number(fields, "vy"),
        _number(fields, "vz"),
        valid,
        _number(fields, "altitude"),
        _number(fields, "fom"),
        _covariance(fields.get("covariance")),
        _integer(fields, "time_of_validity"),
        _integer(fields, "time_of_transmission"),
        _number(fields, "time"),
        _integer(fields, "status"),
    )


def lines() -> Lines[Velocity]:
    """Return a decoder of the device's lines."""
    return Lines(decode, LONGEST_LINE)


def trigger_ping() -> bytes:
    """Return the command for one ping, which the device obeys while its own are disabled."""
    return _command("trigger_ping")


def get_configuration() -> bytes:
    """Return the command that asks for the configuration."""
    return _command("get_config")


def set_configuration(speed_of_sound: float | None = None, acoustic_enabled: bool | None = None) -> bytes:
    """Return the command that sets the speed of sound, m/s in steps of 1 m/s, and whether the device pings by itself.

    Raises:
        ValueError: if there is nothing to set, or the speed is not in [1000, 2000].
    """
    parameters: dict[str, int | bool] = {}
    if speed_of_sound is not None:
        if not 1000.0 <= speed_of_sound <= 2000.0:
            raise ValueError(f"speed of sound {speed_of_sound:g} m/s: must be in [1000, 2000]")
        parameters["speed_of_sound"] = round(speed_of_sound)
    if acoustic_enabled is not None:
        parameters["acoustic_enabled"] = acoustic_enabled
    if not parameters:
        raise ValueError("nothing to set: must be a speed of sound, or whether to ping")
    return _command("set_config", parameters)


def _command(name: str, parameters: dict[str, int | bool] | None = None) -> bytes:
    content: dict[str, Any] = {"command": name}
    if parameters is not None:
        content["parameters"] = parameters
    return json.dumps(content, separators=(",", ":")).encode() + b"\n"


def _finite(value: object, name: str) -> float:
    # A bool is an int to Python; a large int has no float.
    if type(value) not in (int, float) or not -_LARGEST <= value <= _LARGEST:  # type: ignore[operator]
        raise SentenceError(f"{name} = {str(value)[:40]}: must be a number of at most {_LARGEST:g}")
    return float(value)  # type: ignore[arg-type]


def _number(fields: dict[str, object], name: str) -> float:
    return _finite(fields.get(name), name)


def _integer(fields: dict[str, object], name: str) -> int:
    value = fields.get(name)
    if type(value) is not int or not 0 <= value < 2**63:
        raise SentenceError(f"{name} = {str(value)[:40]}: must be a whole number of at most 63 bits")
    return value


def _covariance(rows: object) -> tuple[float, ...]:
    if not isinstance(rows, list) or [type(row) for row in rows] != [list] * 3 or any(len(row) != 3 for row in rows):
        raise SentenceError("covariance: must be three rows of three numbers")
    return tuple([_finite(value, "covariance") for row in rows for value in row])
