"""MAV_STATE of the heartbeat: boot, standby, active, or critical after a failsafe."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.modes import shown_mode
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode


class SystemState:
    """The mode and the failsafe of the supervisor; it remembers the mode that a failsafe ended."""

    def __init__(self) -> None:
        self.mode = Mode.DISARMED
        self.intended = Mode.MANUAL
        """The mode that was in force before a failsafe ended it."""
        self.failsafe = False
        self._booted = False

    @property
    def state(self) -> int:
        """MAV_STATE; BOOT until attitude and depth are known for the first time."""
        if self.failsafe:
            return int(dialect.MAV_STATE_CRITICAL)
        if self.mode is not Mode.DISARMED:
            return int(dialect.MAV_STATE_ACTIVE)
        return int(dialect.MAV_STATE_STANDBY if self._booted else dialect.MAV_STATE_BOOT)

    def update(self, cycle: Cycle) -> None:
        """Take mode and failsafe from a cycle."""
        self._booted = self._booted or (cycle.state.attitude_ok and cycle.state.depth_ok)
        self.mode, self.failsafe = cycle.mode.mode, cycle.mode.failsafe
        if not self.failsafe:
            self.intended = shown_mode(cycle.mode)
