"""Fence and rally items: areas given by corners or by radius, and rally points."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans.items import (
    INVALID,
    INVALID_PARAMS,
    UNSUPPORTED,
    ItemRefused,
    Limits,
    PlanItem,
    position,
)
from firmware_py.records.fence import MAX_CORNERS, MAX_RALLY_POINTS, Area, Disc, Fence, Place, Polygon
from firmware_py.records.order import FenceChange, RallyChange

_POLYGONS = {
    dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION: True,
    dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION: False,
}
_CIRCLES = {
    dialect.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION: True,
    dialect.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION: False,
}
_RALLY: int = dialect.MAV_CMD_NAV_RALLY_POINT
_MIN_CORNERS, _MAX_RADIUS = 3, 1e5


class FenceBuilder:
    """Builds a fence item by item. Heights are ignored: a parameter sets the greatest depth."""

    def __init__(self, water_frame: WaterFrame, _: Limits) -> None:
        self._water_frame = water_frame
        self._areas: list[tuple[bool, Area]] = []
        self._corners: list[tuple[float, float]] = []
        self._side = (0, 0.0)
        """Command and number of corners of the polygon that is being received."""
        self._count = 0

    def add(self, item: PlanItem) -> None:
        """Add the next item.

        Raises:
            ItemRefused: it is not a fence item.
        """
        self._count += 1
        if self._count > MAX_CORNERS:
            raise ItemRefused(dialect.MAV_MISSION_NO_SPACE, f"a fence may have {MAX_CORNERS} corners and circles")
        if item.command in _CIRCLES:
            self._refuse_incomplete()
            if not 0.0 < item.p1 <= _MAX_RADIUS:
                raise ItemRefused(INVALID_PARAMS[0], f"a radius of {item.p1:g} m")
            self._areas.append((_CIRCLES[item.command], Disc(*position(item, self._water_frame), item.p1)))
        elif item.command in _POLYGONS:
            self._corner(item)
        else:
            raise ItemRefused(UNSUPPORTED, f"command {item.command} is not a fence item")

    def finish(self) -> FenceChange:
        """Return the change for `Order.changes`.

        Raises:
            ItemRefused: the last corners of a polygon are missing.
        """
        self._refuse_incomplete()
        return FenceChange(self.fence)

    @property
    def fence(self) -> Fence:
        """The fence of the items so far."""
        return Fence(*(tuple(area for side, area in self._areas if side is within) for within in (True, False)))

    def _corner(self, item: PlanItem) -> None:
        if not item.p1 >= _MIN_CORNERS or item.p1 > MAX_CORNERS or item.p1 != int(item.p1):
            raise ItemRefused(INVALID_PARAMS[0], f"a polygon of {item.p1:g} corners")
        side = item.command, item.p1
        if self._corners and side != self._side:
            self._refuse_incomplete()
        self._side = side
        self._corners.append(position(item, self._water_frame))
        if len(self._corners) == item.p1:
            self._areas.append((_POLYGONS[item.command], Polygon(tuple(self._corners))))
            self._corners = []

    def _refuse_incomplete(self) -> None:
        if self._corners:
            raise ItemRefused(INVALID, f"a polygon with {len(self._corners)} of its {self._side[1]:g} corners")


class RallyBuilder:
    """Builds the rally points item by item: positions on the surface, whatever their height."""

    def __init__(self, water_frame: WaterFrame, limits: Limits) -> None:
        self._water_frame, self._limits = water_frame, limits
        self.points: list[Place] = []

    def add(self, item: PlanItem) -> None:
        """Add the next item.

        Raises:
            ItemRefused: it is not a rally point, or outside the fence.
        """
        if item.command != _RALLY:
            raise ItemRefused(UNSUPPORTED, f"command {item.command} is not a rally point")
        if len(self.points) == MAX_RALLY_POINTS:
            raise ItemRefused(dialect.MAV_MISSION_NO_SPACE, f"there may be {MAX_RALLY_POINTS} rally points")
        point = Place(*position(item, self._water_frame))
        if breach := self._limits.fence.problem_at(*point):
            raise ItemRefused(INVALID_PARAMS[4], breach)
        self.points.append(point)

    def finish(self) -> RallyChange:
        """Return the change for `Order.changes`."""
        return RallyChange(tuple(self.points))
