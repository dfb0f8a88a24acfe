"""The point that is flown to, and how far it still is, as stations show them.

Guidance tells only what it wants of depth, heading and speed. So the point is taken from where guidance has it: from
the setpoint in Guided, from the mission's item, and from the rally points on the way back.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.records.cycle import Cycle
from firmware_py.records.fence import Place, nearest_rally_point
from firmware_py.records.order import Loiter, Mode, Step, Surface, Waypoint

_NEVER = -1


class TargetVector(NamedTuple):
    """Distance, m, and bearing, rad."""

    distance: float
    bearing: float


class NavigationTarget:
    """Remembers which place a station gave, and by mode which rally point was chosen, for which item of a mission."""

    def __init__(self, plan_store: PlanStore) -> None:
        self._plan_store = plan_store
        self._mode = Mode.DISARMED
        self._given: Place | None = None
        self._homes: dict[Mode, tuple[int, Place | None]] = {}

    def update(self, cycle: Cycle) -> None:
        """Sees what a cycle was ordered, and where the vehicle was when it turned back."""
        mode, setpoint, eta = cycle.mode.mode, cycle.order.setpoint, cycle.state.eta
        if mode is not self._mode:
            self._mode, self._given = mode, None
            kept = self._homes.get(Mode.MISSION)
            self._homes = {Mode.MISSION: kept} if kept is not None and mode is not Mode.DISARMED else {}
        if mode is Mode.GUIDED:
            if math.isfinite(setpoint.x + setpoint.y):
                self._given = Place(setpoint.x, setpoint.y)
            elif math.isfinite(setpoint.psi_d):
                self._given = None
        elif self._homeward(cycle) and math.isfinite(eta.x + eta.y):
            item, (sought, _) = self._item(cycle), self._homes.get(mode, (_NEVER, None))
            if sought != item:
                self._homes[mode] = (
                    item,
                    nearest_rally_point(self._plan_store.rally, self._plan_store.fence, eta.x, eta.y),
                )

    def vector(self, cycle: Cycle) -> TargetVector:
        """To the point from where the vehicle is believed to be.

        Of a circle that nobody gave a place, the distance to its rim; without a point 0, and the heading that is asked
        for.
        """
        reference, eta, place = cycle.reference, cycle.state.eta, self._place(cycle)
        if place is None or not math.isfinite(eta.x + eta.y):
            across = reference.cross_track
            return TargetVector(abs(across) if math.isfinite(across) else 0.0, reference.psi_d)
        north, east = place.x - eta.x, place.y - eta.y
        return TargetVector(math.hypot(north, east), math.atan2(east, north))

    def _place(self, cycle: Cycle) -> Place | None:
        mode, step = cycle.mode.mode, self._step(cycle)
        if mode is Mode.GUIDED:
            return self._given
        if isinstance(step, Waypoint | Loiter):
            return Place(step.x, step.y)
        return self._homes.get(mode, (_NEVER, None))[1] if self._homeward(cycle) else None

    def _homeward(self, cycle: Cycle) -> bool:
        """Whether it is a rally point that is gone to, if there is one."""
        mode = cycle.mode.mode
        if mode is not Mode.MISSION:
            return mode is Mode.RETURN or mode is Mode.SURFACE
        step = self._step(cycle)
        return isinstance(step, Surface) and step.rally

    def _step(self, cycle: Cycle) -> Step | None:
        """That which a mission has come to."""
        steps, item = self._plan_store.steps, cycle.reference.item
        return steps[item] if cycle.mode.mode is Mode.MISSION and 0 <= item < len(steps) else None

    @staticmethod
    def _item(cycle: Cycle) -> int:
        return cycle.reference.item if cycle.mode.mode is Mode.MISSION else 0
