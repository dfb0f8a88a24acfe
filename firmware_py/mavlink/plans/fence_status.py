"""FENCE_STATUS: whether the vehicle is outside the fence or too deep, as the supervisor has found."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.records.cycle import Cycle
from firmware_py.records.fence import WITHIN

_NONE: int = dialect.FENCE_BREACH_NONE


class FenceStatus:
    """Counter of breaches: leaving the fence, or exceeding its depth."""

    def __init__(self) -> None:
        self._count, self._began_ms, self._breach = 0, 0, _NONE

    def update(self, cycle: Cycle) -> None:
        """Take the breach of a cycle, and count it when it begins."""
        before, self._breach = self._breach, _NONE
        if cycle.mode.too_deep:
            self._breach = dialect.FENCE_BREACH_MINALT
        elif cycle.mode.breach != WITHIN:
            self._breach = dialect.FENCE_BREACH_BOUNDARY
        if self.outside_fence and before == _NONE:
            self._count = min(self._count + 1, 65535)
            self._began_ms = cycle.tick.t_ns // 1_000_000 & 0xFFFFFFFF

    @property
    def outside_fence(self) -> bool:
        """Whether the vehicle is outside the fence, or too deep."""
        return self._breach != _NONE

    @property
    def status(self) -> Message:
        """The message FENCE_STATUS."""
        mitigation = dialect.FENCE_MITIGATE_UNKNOWN if self.outside_fence else dialect.FENCE_MITIGATE_NONE
        return dialect.MAVLink_fence_status_message(
            int(self.outside_fence), self._count, self._breach, self._began_ms, mitigation
        )
