"""A vehicle that came up and disarmed itself, and sinks again: nobody else would notice.

The watch begins when SURFACE ends by SURFACED, and ends with any order to arm or to disarm: from then on somebody has
the vehicle in hand, and may lower it by crane. A vehicle that an order disarmed, or that was just switched on, is not
watched.
"""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.records.event import Cause
from firmware_py.records.order import Arming, Mode, Order
from firmware_py.safety.conditions import Conditions
from firmware_py.safety.rules import surely_under_water
from firmware_py.safety.safety_params import SafetyParams


class SinkWatch(NamedTuple):
    """Whether the vehicle is watched, and for how many ticks it has been under water."""

    on: bool = False
    ticks: int = 0

    def after(self, c: Conditions, order: Order, params: SafetyParams) -> SinkWatch:
        """Return the watch after a tick."""
        if order.arming in (Arming.ARM, Arming.DISARM, Arming.FORCE_DISARM) or order.mode is Mode.DISARMED:
            return SinkWatch()
        under = self.on and surely_under_water(c, params)
        return SinkWatch(self.on, self.ticks + 1 if under else 0)

    def is_sunk(self, dt: float, params: SafetyParams) -> bool:
        """Return whether it has been under water for `sunk_time`."""
        return self.on and self.ticks > 0 and (self.ticks - 1) * dt >= params.sunk_time


def leaks(c: Conditions, cause: Cause) -> bool:
    """Return whether the vehicle came up because of a leak (`cause`), or has one now."""
    return c.leak or cause is Cause.LEAK
