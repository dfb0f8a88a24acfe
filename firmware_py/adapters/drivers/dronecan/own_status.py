"""What the autopilot says of itself in NodeStatus: health and mode from the supervisor's state."""

from __future__ import annotations

from firmware_py.records.cycle import Cycle
from firmware_py.records.health import SourceState
from firmware_py.tick import Tick
from firmware_py.wire.dronecan.node_messages import NodeStatus

OK, WARNING, ERROR, CRITICAL = 0, 1, 2, 3
OPERATIONAL, INITIALIZATION, OFFLINE = 0, 1, 7


class OwnStatus:
    """The latest status; INITIALIZATION until attitude and depth are known for the first time.

    Health is CRITICAL in a failsafe without attitude or depth, ERROR in any other, and WARNING while a sensor, an
    actuator or a node of the bus is not sound, velocity is not known, or cycles are late. The vendor's code is the mode
    in the low byte and the cause of the mode in the high one.
    """

    def __init__(self) -> None:
        self._health, self._mode, self._code = OK, INITIALIZATION, 0
        self._uptime = 0

    def update(self, cycle: Cycle) -> None:
        """Take over the state of a cycle."""
        state, mode = cycle.state, cycle.mode
        known = state.attitude_ok and state.depth_ok
        if known:
            self._mode = OPERATIONAL
        if mode.failsafe:
            self._health = ERROR if known else CRITICAL
        else:
            self._health = OK if self._sound(cycle) else WARNING
        self._code = mode.mode & 0xFF | (mode.cause & 0xFF) << 8

    def message(self, tick: Tick) -> NodeStatus:
        """Return the message at a tick."""
        self._uptime = int(tick.t)
        return NodeStatus(self._uptime, self._health, self._mode, 0, self._code)

    def leaving(self) -> NodeStatus:
        """Return the last message of a run: nobody needs to wait until this node counts as lost."""
        return NodeStatus(self._uptime, self._health, OFFLINE, 0, self._code)

    @staticmethod
    def _sound(cycle: Cycle) -> bool:
        state, frame = cycle.state, cycle.frame
        return (
            state.attitude_ok
            and state.depth_ok
            and state.velocity_ok
            and not state.leak
            and not cycle.mode.late
            and not (frame.two_senders | frame.unhealthy | frame.replaced)
            and all(sensor.state is SourceState.GOOD for sensor in state.sensors)
            and cycle.actuators.faultless
        )
