"""Stern and bow planes that are known to be stuck: what they do together, and whether the others can oppose it."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence

from firmware_py.marine import clip
from firmware_py.records.health import ActuatorFault, FinHealth
from firmware_py.records.sensing import Heard

_RESERVE = 0.8
"""Share of what the healthy planes can do that may be needed against the stuck ones."""
_STALL = math.radians(45.0)
"""Beyond this angle, the most that a vehicle file takes for a limit, a fin stalls: it does no more than here, rad."""


class PlaneJam(enum.IntEnum):
    """What planes that are stuck do beyond what the others can oppose."""

    NONE = 0
    UP = 1
    """The bow goes up."""
    DOWN = 2
    """The bow goes down, or it is not known where."""


class Planes:
    """The effect of each fin on pitch: `shares` on delta_s (positive: bow down), `limits` of the angles, rad.

    A report that is older than `timeout`, s, counts no longer.
    """

    def __init__(self, shares: Sequence[float], limits: Sequence[float], timeout: float) -> None:
        self._fins, self._timeout = tuple(zip(shares, limits, strict=True)), timeout

    def jam(
        self, t: float, faults: Sequence[ActuatorFault], angles: Sequence[Heard[float]], left: Sequence[FinHealth] = ()
    ) -> PlaneJam:
        """Return what the fins do at the time `t`, s, that are jammed or hard over.

        An angle that is neither reported nor known by what is `left` of a fin counts as the worst; one beyond
        the stall counts as that there. A fin that fell silent may have jammed elsewhere than where it last reported.
        """
        if not self._fins or not any(faults):
            return PlaneJam.NONE
        least = greatest = authority = 0.0
        known = [fin.stuck for fin in left] or [math.nan] * len(faults)
        for (share, limit), fault, heard, stuck in zip(self._fins, faults, angles, known, strict=True):
            reach = abs(share) * limit
            if fault not in (ActuatorFault.JAMMED, ActuatorFault.HARD_OVER):
                authority += 0.0 if fault is ActuatorFault.LOST else reach
                continue
            reported = heard.usable(t, self._timeout) and math.isfinite(heard.value)
            angle = clip(heard.value if reported else stuck, -_STALL, _STALL)
            if angle == angle:
                least, greatest = least + share * angle, greatest + share * angle
            else:
                least, greatest = least - reach, greatest + reach
        if greatest > _RESERVE * authority and greatest > 0.0:
            return PlaneJam.DOWN
        return PlaneJam.UP if -least > _RESERVE * authority else PlaneJam.NONE
