"""Message streams: a table of intervals, spread so that no tick has to send all of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from firmware_py.mavlink.base.codec import dialect

_MS = 1_000_000
_SHORTEST_NS = 20 * _MS
_NEVER = 1 << 62


class StreamTiming(NamedTuple):
    """Sent every `period_ns`, first at `phase_ns`."""

    period_ns: int
    phase_ns: int


def _timing(hz: int, phase_ms: int) -> StreamTiming:
    return StreamTiming(1000 * _MS // hz, phase_ms * _MS)


# At 100 Hz no two of these fall into one tick: within each 100 ms, messages of one rate share a place and take turns.
DEFAULT_STREAMS: dict[int, StreamTiming] = {
    dialect.MAVLINK_MSG_ID_ATTITUDE: _timing(10, 0),
    dialect.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY: _timing(10, 50),
    dialect.MAVLINK_MSG_ID_LOCAL_POSITION_NED: _timing(5, 10),
    dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: _timing(5, 110),
    dialect.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: _timing(5, 20),
    dialect.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT: _timing(5, 120),
    dialect.MAVLINK_MSG_ID_VFR_HUD: _timing(2, 30),
    dialect.MAVLINK_MSG_ID_ALTITUDE: _timing(2, 130),
    dialect.MAVLINK_MSG_ID_RPM: _timing(2, 230),
    dialect.MAVLINK_MSG_ID_SCALED_PRESSURE2: _timing(2, 330),
    dialect.MAVLINK_MSG_ID_ESTIMATOR_STATUS: _timing(2, 430),
    dialect.MAVLINK_MSG_ID_HEARTBEAT: _timing(1, 40),
    dialect.MAVLINK_MSG_ID_SYS_STATUS: _timing(1, 140),
    dialect.MAVLINK_MSG_ID_BATTERY_STATUS: _timing(1, 240),
    dialect.MAVLINK_MSG_ID_SYSTEM_TIME: _timing(1, 340),
    dialect.MAVLINK_MSG_ID_WATER_DEPTH: _timing(1, 440),
    dialect.MAVLINK_MSG_ID_SCALED_IMU: _timing(5, 60),
    dialect.MAVLINK_MSG_ID_ODOMETRY: _timing(5, 160),
    dialect.MAVLINK_MSG_ID_DISTANCE_SENSOR: _timing(2, 70),
    dialect.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT: _timing(2, 170),
    dialect.MAVLINK_MSG_ID_GPS_RAW_INT: _timing(1, 540),
    dialect.MAVLINK_MSG_ID_HOME_POSITION: _timing(1, 640),
    dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: _timing(1, 740),
    dialect.MAVLINK_MSG_ID_CURRENT_MODE: _timing(1, 840),
    dialect.MAVLINK_MSG_ID_MISSION_CURRENT: _timing(1, 940),
    dialect.MAVLINK_MSG_ID_FENCE_STATUS: _timing(1, 270),
}

HIGH_LATENCY_STREAMS = {dialect.MAVLINK_MSG_ID_HIGH_LATENCY2: StreamTiming(5000 * _MS, 0)}
"""The streams of a high-latency link."""


class Streams:
    """The streams of one link. A late message is sent once, and then again at its own times."""

    def __init__(self, defaults: Mapping[int, StreamTiming]) -> None:
        self._defaults = defaults
        self._period = {name: set_interval.period_ns for name, set_interval in defaults.items()}
        self._due = {name: set_interval.phase_ns for name, set_interval in defaults.items()}
        self._next = min(self._due.values(), default=_NEVER)

    def due(self, t_ns: int, most: int) -> list[int]:
        """Return the ids that are due, longest waiting first, at most `most`; the rest waits."""
        if t_ns < self._next:
            return []
        ready = sorted([(due, name) for name, due in self._due.items() if due <= t_ns])[:most]
        for due, name in ready:
            period = self._period[name]
            self._due[name] = due + ((t_ns - due) // period + 1) * period
        self._next = min(self._due.values())
        return [name for _, name in ready]

    def interval_us(self, name: int) -> int:
        """Return the interval of a message as MESSAGE_INTERVAL has it; -1 if it is not sent."""
        return self._period[name] // 1000 if name in self._period else -1

    def set_interval(self, name: int, interval_us: float, t_ns: int) -> bool:
        """Set an interval: -1 never, 0 default, else us, at least 20 ms; return False if it is not an interval."""
        if interval_us == -1.0:
            self._period.pop(name, None)
            self._due.pop(name, None)
        elif interval_us == 0.0:
            self._due.pop(name, None)
            if name in self._defaults:
                period, phase = self._defaults[name]
                self._period[name] = period
                self._due[name] = phase + max(0, -(-(t_ns - phase) // period)) * period
        elif 0.0 < interval_us < 2.0**31:
            self._period[name] = max(_SHORTEST_NS, int(interval_us) * 1000)
            self._due[name] = t_ns + self._period[name]
        else:
            return False
        self._next = min(self._due.values(), default=_NEVER)
        return True
