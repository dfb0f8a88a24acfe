"""Attitude sensors beside VectorNav's: MicroStrain CV7, Xsens MTi, SBG."""

from __future__ import annotations

import math
import struct

from firmware_py.marine import euler_from_quaternion, quaternion_from_euler
from firmware_py.records.sensing import Ahrs
from firmware_py.wire.serial import microstrain as mip
from firmware_py.wire.serial import sbg, xsens
from sim_bridge.devices.lines.firmware import Pace, Talker

FILTER_HZ = 1000
"""The own rate of a CV7's filter, of which its packets are a part."""
_HEADING_KNOWN = 3
"""State of a CV7's filter: attitude and heading."""
_OK, _UNKNOWN_COMMAND, _BAD_PARAMETER = 0, 1, 3
_REPLY = 0xF1
_BASE, _FORMATS = 0x01, 0x0C
_PING, _IDLE, _RESUME, _MESSAGE_FORMAT, _STREAM = 0x01, 0x02, 0x06, 0x0F, 0x11
_NAMES = {0x03: "quaternion", 0x05: "angles", 0x0E: "rates", 0x10: "state", 0xD5: "time"}
"""The fields of the filter that are simulated."""


class MicroStrain:
    """The program of a CV7: silent until its stream is defined and enabled; what it does not know it refuses.

    The rate is that at which the first field was asked for, at most that of the sensor.
    """

    hears = True

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget the stream."""
        self._commands = mip.commands()
        self._fields: dict[int, int] = {}
        self._enabled, self._idle = False, False
        self._packets = Pace(0.0)

    def report(self, value: Ahrs, valid: float, _now: float) -> bytes:
        """Return the packet of the filter that is due."""
        if not self._enabled or self._idle or not self._packets.due(valid):
            return b""
        x, y, z, w = quaternion_from_euler(*value[:3])
        told = mip.Attitude(value[:3], (w, x, y, z), value[3:], valid, state=_HEADING_KNOWN)
        return mip.encode(mip.Attitude(**{_NAMES[field]: getattr(told, _NAMES[field]) for field in self._fields}))

    def answer(self, data: bytes) -> bytes:
        """Return the reply to each field of each command: the field, and an error or none."""
        replies = []
        for kind, fields in self._commands.feed(data):
            told = [(_REPLY, bytes((field, self._obey(kind, field, content)))) for field, content in fields]
            replies.append(mip.packet(kind, *told))
        return b"".join(replies)

    def _obey(self, kind: int, field: int, content: bytes) -> int:
        if kind == _BASE and field in (_PING, _IDLE, _RESUME):
            self._idle = field == _IDLE or (self._idle and field == _PING)
            return _OK
        if kind != _FORMATS or field not in (_MESSAGE_FORMAT, _STREAM):
            return _UNKNOWN_COMMAND
        if len(content) < 3 or content[0] != 1 or content[1] != mip.FILTER:
            return _BAD_PARAMETER
        if field == _STREAM:
            self._enabled = bool(content[2])
            return _OK
        if len(content) != 3 + 3 * content[2]:
            return _BAD_PARAMETER
        fields = dict(struct.iter_unpack(">BH", content[3:]))
        if not fields.keys() <= _NAMES.keys() or 0 in fields.values():
            return _BAD_PARAMETER
        self._fields, self._packets = fields, Pace(FILTER_HZ / next(iter(fields.values())) if fields else 0.0)
        return _OK


_GO_TO_MEASUREMENT, _GO_TO_CONFIG, _OUTPUT = 0x10, 0x30, 0xC0
_ERROR, _INVALID = 0x42, 0x04
_VALID = 3
"""Status of an Xsens: self test passed, filter valid."""
_KIND, _FRAME, _FORM = 0xFFF0, 0xC, 0x3
_FACTORY = (
    (xsens.SAMPLE_TIME_FINE, 0xFFFF),
    (xsens.EULER_ANGLES, 100),
    (xsens.RATE_OF_TURN, 100),
    (xsens.STATUS_WORD, 0xFFFF),
)
"""Against east, north, up, as single-precision numbers."""


class Xsens:
    """The program of an MTi, of axes forward, to port, up: it measures from the start; settings take its config state.

    The rate is that of the orientation, at most that of the sensor. Settings are kept without power.
    """

    hears = True

    def __init__(self) -> None:
        self._output = dict(_FACTORY)
        self.restart()

    def restart(self) -> None:
        """Measure."""
        self._commands = xsens.commands()
        self._measuring = True
        self._set()

    def report(self, value: Ahrs, valid: float, _now: float) -> bytes:
        """Return the message that is due."""
        if not self._measuring or not self._messages.due(valid):
            return b""
        quaternion = _axes_of(value, self._frame)
        x, y, z, w = quaternion
        kinds = {identifier & _KIND for identifier in self._output}
        told = xsens.Attitude(frame=self._frame, rates=(value.p, -value.q, -value.r))
        if xsens.QUATERNION in kinds:
            told = told._replace(quaternion=(w, x, y, z))
        if xsens.EULER_ANGLES in kinds:
            told = told._replace(angles=euler_from_quaternion(*quaternion))
        if xsens.RATE_OF_TURN not in kinds:
            told = told._replace(rates=(math.nan,) * 3)
        if xsens.SAMPLE_TIME_FINE in self._output:
            told = told._replace(time=valid)
        if xsens.STATUS_WORD in self._output:
            told = told._replace(status=_VALID)
        return xsens.encode(told, self._form)

    def answer(self, data: bytes) -> bytes:
        """Return the acknowledgement of each message, or an error."""
        return b"".join([self._obey(*told) for told in self._commands.feed(data)])

    def _obey(self, kind: int, data: bytes) -> bytes:
        if kind in (_GO_TO_CONFIG, _GO_TO_MEASUREMENT):
            self._measuring = kind == _GO_TO_MEASUREMENT
            return xsens.command(kind + 1)
        if kind != _OUTPUT or self._measuring or len(data) % 4:
            return xsens.command(_ERROR, bytes((_INVALID,)))
        if data:
            self._output = dict(struct.iter_unpack(">HH", data))
            self._set()
        return xsens.command(kind + 1, b"".join([struct.pack(">HH", *pair) for pair in self._output.items()]))

    def _set(self) -> None:
        turned = [one for one in self._output if one & _KIND in (xsens.QUATERNION, xsens.EULER_ANGLES)]
        first = turned[0] if turned else 0
        self._messages = Pace(self._output[first] if turned else 0.0)
        self._frame, self._form = xsens.FRAMES.get(first & _FRAME, "ENU"), first & _FORM


def _axes_of(value: Ahrs, frame: str) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) from axes forward, to port, up to those of the earth."""
    phi, theta, psi = value[:3]
    if frame == "NED":  # half a turn about x before the attitude
        x, y, z, w = quaternion_from_euler(phi, theta, psi)
        return w, z, -y, -x
    return quaternion_from_euler(phi, -theta, math.pi / 2.0 - psi if frame == "ENU" else -psi)


_GYROS_GOOD, _GYROS_BAD = 0b10_1110_0011, 0b10_0000_0011
_SOLUTION = 0x32
"""Roll, pitch and heading are valid."""


def sbg_sensor() -> Talker:
    """Return the program of an SBG that sends Euler angles and then the rates of the same moment."""

    def report(value: Ahrs, valid: float, _now: float) -> bytes:
        good = math.isfinite(sum(value[3:]))
        rates = sbg.Rates(valid, value[3:] if good else (0.0, 0.0, 0.0), _GYROS_GOOD if good else _GYROS_BAD)
        attitude = sbg.Attitude(valid, value[:3], deviations=(0.005, 0.005, 0.01), status=_SOLUTION)
        return sbg.encode(attitude) + sbg.encode(rates)

    return Talker(report)
