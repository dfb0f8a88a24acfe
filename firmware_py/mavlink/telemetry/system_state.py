"""How the vehicle stands, as every heartbeat says it: booting, standing by, under way, or brought up by a failsafe."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import dialect
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode


class SystemState:
    """Remembers what was ordered and what became of it."""

    def __init__(self) -> None:
        self.mode = Mode.DISARMED
        self.intended = Mode.DISARMED
        """The mode that was in force before a failsafe took it away."""
        self.failsafe = False
        self._awake = False

    @property
    def state(self) -> int:
        """The MAV_STATE; BOOT until attitude and depth were known for the first time."""
        if self.failsafe:
            return int(dialect.MAV_STATE_CRITICAL)
        if self.mode is not Mode.DISARMED:
            return int(dialect.MAV_STATE_ACTIVE)
        return int(dialect.MAV_STATE_STANDBY if self._awake else dialect.MAV_STATE_BOOT)

    def update(self, cycle: Cycle) -> None:
        """It is a failsafe that surfaces, unless someone ordered it, or the mission or the way back was done."""
        mode, before = cycle.mode.mode, self.mode
        self._awake = self._awake or (cycle.state.attitude_ok and cycle.state.depth_ok)
        if mode is before:
            return
        done = (before is Mode.MISSION and cycle.mode.mission_done) or _returned(cycle)
        self.failsafe = mode is Mode.SURFACE and cycle.order.mode is not Mode.SURFACE and not done
        self.mode = mode
        if not self.failsafe:
            self.intended = mode


def _returned(cycle: Cycle) -> bool:
    return any(event.endswith(": return done") for event in cycle.events)
