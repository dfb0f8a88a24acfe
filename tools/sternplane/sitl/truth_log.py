"""What a plant logs: the true state and, where each keeps its own time, what it hears of the vehicle's."""

from __future__ import annotations

from collections.abc import Callable

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.storage.recorder import TRUTH_TOPIC, LogWriter
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.message_table import NODE_STATUS
from firmware_py.wire.dronecan.transfer import STREAM, can_id
from sim_bridge.bridge import Bridge
from sternplane.logs.truth_beside import TIME_TOPIC, VehicleTime


class VehicleClock:
    """A bus that takes note of the vehicle's NodeStatus, a message of one frame, as it goes by."""

    def __init__(self, bus: FramePort, vehicle_id: int) -> None:
        self._bus, self._status = bus, can_id(NODE_STATUS, vehicle_id, 0)
        self._uptime: float | None = None
        self.send, self.losses, self.close = bus.send, bus.losses, bus.close

    @property
    def sound(self) -> bool:
        """Return whether the bus is up."""
        return self._bus.sound

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the frames that have arrived, at most `limit`."""
        frames = self._bus.drain(limit)
        for identifier, data in frames:
            if identifier & STREAM == self._status:
                self._hear(data)
        return frames

    def take(self) -> float | None:
        """Return the uptime that was told since the last call, s; None: none was."""
        uptime, self._uptime = self._uptime, None
        return uptime

    def _hear(self, data: bytes) -> None:
        try:
            self._uptime = float(NODE_STATUS.decode(data[:-1]).uptime_sec)
        except DecodeError:
            return


def kept(bridge: Bridge, log: LogWriter | None, dt_ns: int, clock: VehicleClock | None = None) -> Callable[[int], None]:
    """Return a step of the plant that also logs the true state, and what was heard of the vehicle's time."""
    if log is None:
        return bridge.step
    log.channel(TRUTH_TOPIC, bridge.truth())
    log.channel(TIME_TOPIC, VehicleTime(0.0))

    def step(k: int) -> None:
        bridge.step(k)
        log.write(TRUTH_TOPIC, k * dt_ns, bridge.truth())
        if clock is not None and (uptime := clock.take()) is not None:
            log.write(TIME_TOPIC, k * dt_ns, VehicleTime(uptime))

    return step
