"""The vehicle's time of what a device stamps with the time of its own clock."""

from __future__ import annotations

import math

WINDOW_S = 2.0
"""So long is looked for the message that came with the least delay, s: quartz clocks part by less than 0.2 ms in it."""
JUMP_S = 0.5
"""A stamp that is later than this by the clock as it was known tells that the clock was set, or has begun again, s."""
LATEST_S = 1e11
"""No clock says more, s: nanoseconds in 64 bits are less. A larger stamp leaves nothing of the vehicle's time."""
_ROUNDING = 1e-6
"""So much earlier than it came is what comes at once, s: sums of large times are not exact."""


class DeviceClock:
    """Takes off what a line, a buffer or a late tick adds to a delay; not what is the same for all messages.

    No message comes before it was stamped, so the smallest difference between arrival and stamp in a while is that of
    the clocks, and the least delay. A clock that was set forward, or back by more than JUMP_S, is followed at once; one
    that was set back by less after two windows.

    Args:
        wrap: the clock begins again from 0 after so long, s.
    """

    def __init__(self, wrap: float = math.inf) -> None:
        self._wrap = wrap
        self._offset = math.nan
        """The least delay that is known, with the difference of the clocks."""
        self._least = math.inf
        """By how much more all messages of this window were late."""
        self._t_window = 0.0

    def at(self, stamp: float, t: float) -> float:
        """Return when it was so late by the device's clock, for a message that came at `t`, s: never after that.

        What has no stamp, and the first message by a clock, is from when it came.
        """
        if not abs(stamp) <= LATEST_S:
            return t
        if self._wrap < math.inf and math.isfinite(self._offset):
            self._offset += self._wrap * round((t - stamp - self._offset) / self._wrap)
        late = t - stamp - self._offset
        self._least = min(self._least, late)
        if not 0.0 <= late <= JUMP_S:
            self._begin(t - stamp - _ROUNDING, t)
        elif t - self._t_window >= WINDOW_S:
            self._begin(self._offset + self._least, t)
        return min(stamp + self._offset, t)  # of one stamp the same each time: what is told twice is not newer

    def _begin(self, offset: float, t: float) -> None:
        self._offset, self._least, self._t_window = offset, math.inf, t
