"""Echo sounders: a Blue Robotics Ping, and one that speaks NMEA 0183.

The time that sound takes is not simulated: a distance is true when it was measured, and is sent at once.
"""

from __future__ import annotations

import math
import struct

from firmware_py.wire.serial import nmea0183, ping
from firmware_py.wire.serial.nmea_messages import BelowTransducer
from sim_bridge.devices.lines.firmware import Pace, Talker

DEVICE_ID, GENERAL_INFO, SET_DEVICE_ID, PING_ENABLE = 1201, 1210, 1000, 1006
_FAR = 1e6
"""No distance of the protocol is larger, m."""
_TAKEN = {
    ping.SET_RANGE: 8,
    ping.SET_SPEED_OF_SOUND: 4,
    ping.SET_MODE_AUTO: 1,
    ping.SET_PING_INTERVAL: 2,
    ping.CONTINUOUS_START: 2,
    ping.CONTINUOUS_STOP: 2,
}
"""What it may be told, and the bytes of each; beside questions."""
_DISTANCES = (ping.DISTANCE, ping.DISTANCE_SIMPLE)


def nmea_sounder() -> Talker:
    """Return the program of one that sends DPT for each ping, with an empty distance where there is no echo."""

    def report(altitude: float, _valid: float, _now: float) -> bytes:
        return nmea0183.encode(BelowTransducer("DPT", altitude if altitude > 0.0 else math.nan, 0.0), "SD")

    return Talker(report)


class Ping:
    """The program of a Ping1D: silent until it is asked, or told to send each ping.

    The interval is at least that of the sensor. The range is not limited by what it is told.
    """

    hears = True

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Go back to the settings of the factory."""
        self._commands = ping.commands()
        self._sent: set[int] = set()
        self._pings = Pace(10.0)
        self._newest = ping.Distance(0.0, 0.0, 0.0, 0, 0.0, 0.0, 0)

    def report(self, altitude: float, valid: float, _now: float) -> bytes:
        """Return the messages of a ping that were asked for; an echo that there is not has no confidence."""
        found = 0.0 < altitude < _FAR
        self._newest = ping.Distance(
            altitude if found else 0.0, 0.98 if found else 0.0, 450e-6, round(valid * 100) % 2**32, 0.3, 60.0, 3
        )
        return b"".join([self._distance(kind) for kind in sorted(self._sent)]) if self._pings.due(valid) else b""

    def answer(self, data: bytes) -> bytes:
        """Return what is asked for; an ack or a nack for all else."""
        return b"".join([self._obey(*told) for told in self._commands.feed(data)])

    def _distance(self, kind: int) -> bytes:
        return ping.encode(self._newest if kind == ping.DISTANCE else self._newest._replace(ping_number=-1))

    def _obey(self, kind: int, payload: bytes) -> bytes:
        if kind == ping.GENERAL_REQUEST and len(payload) == 2:
            return self._asked(*struct.unpack("<H", payload))
        if not payload:  # the older way to ask
            return self._asked(kind)
        if _TAKEN.get(kind) != len(payload):
            return ping.encode(ping.Nack(kind, "not simulated, or of a wrong length"))
        value = int.from_bytes(payload[:2], "little")
        if kind in (ping.CONTINUOUS_START, ping.CONTINUOUS_STOP) and value not in _DISTANCES:
            return ping.encode(ping.Nack(kind, "not simulated"))
        if kind == ping.CONTINUOUS_START:
            self._sent.add(value)
        elif kind == ping.CONTINUOUS_STOP:
            self._sent.discard(value)
        elif kind == ping.SET_PING_INTERVAL:
            self._pings = Pace(1e3 / max(value, 1))
        return ping.encode(ping.Ack(kind))

    def _asked(self, kind: int) -> bytes:
        if kind in _DISTANCES:
            return self._distance(kind)
        told = {
            ping.PROTOCOL_VERSION: struct.pack("<4B", 1, 0, 0, 0),
            ping.DEVICE_INFORMATION: struct.pack("<6B", 1, 1, 3, 29, 0, 0),
            DEVICE_ID: b"\1",
            GENERAL_INFO: struct.pack("<5HB", 3, 29, 5000, round(1e3 / self._pings.rate), 3, 1),
        }
        return (
            ping.packet(kind, told[kind], source=1) if kind in told else ping.encode(ping.Nack(kind, "not simulated"))
        )
