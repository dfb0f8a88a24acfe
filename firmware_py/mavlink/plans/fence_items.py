"""Fence and rally points as stations write them: areas by corners or by radius, and places."""

from __future__ import annotations

import json

from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.commands.setpoints import WaterFrame
from firmware_py.mavlink.plans.items import INVALID, INVALID_PARAMS, UNSUPPORTED, ItemRefused, Limits, RawItem, place
from firmware_py.records.fence import MOST_CORNERS, MOST_PLACES, Area, Disc, Fence, Place, Polygon, plain

_POLYGONS = {
    dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION: True,
    dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION: False,
}
_CIRCLES = {
    dialect.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION: True,
    dialect.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION: False,
}
_RALLY: int = dialect.MAV_CMD_NAV_RALLY_POINT
_LEAST_CORNERS, _WIDEST = 3, 1e5


class FenceBuilder:
    """A fence that comes item by item. Heights are not heard: how deep it may go a parameter says."""

    def __init__(self, sea: WaterFrame, _: Limits) -> None:
        self._sea = sea
        self._areas: list[tuple[bool, Area]] = []
        self._corners: list[tuple[float, float]] = []
        self._side = (0, 0.0)
        """Command and number of corners of the polygon that is under way."""
        self._count = 0

    def add(self, raw: RawItem) -> None:
        """Takes the next item.

        Raises:
            Refused: it is no part of a fence.
        """
        self._count += 1
        if self._count > MOST_CORNERS:
            raise ItemRefused(dialect.MAV_MISSION_NO_SPACE, f"a fence may have {MOST_CORNERS} corners and circles")
        if raw.command in _CIRCLES:
            self._refuse_half()
            if not 0.0 < raw.p1 <= _WIDEST:
                raise ItemRefused(INVALID_PARAMS[0], f"a radius of {raw.p1:g} m")
            self._areas.append((_CIRCLES[raw.command], Disc(*place(raw, self._sea), raw.p1)))
        elif raw.command in _POLYGONS:
            self._corner(raw)
        else:
            raise ItemRefused(UNSUPPORTED, f"command {raw.command} is no corner and no circle of a fence")

    def finish(self) -> str:
        """The document for the core.

        Raises:
            Refused: a polygon without its last corners.
        """
        self._refuse_half()
        return json.dumps({"fence": plain(self.fence)})

    @property
    def fence(self) -> Fence:
        """What has come so far."""
        return Fence(*(tuple(area for side, area in self._areas if side is within) for within in (True, False)))

    def _corner(self, raw: RawItem) -> None:
        if not raw.p1 >= _LEAST_CORNERS or raw.p1 > MOST_CORNERS or raw.p1 != int(raw.p1):
            raise ItemRefused(INVALID_PARAMS[0], f"a polygon of {raw.p1:g} corners")
        side = raw.command, raw.p1
        if self._corners and side != self._side:
            self._refuse_half()
        self._side = side
        self._corners.append(place(raw, self._sea))
        if len(self._corners) == raw.p1:
            self._areas.append((_POLYGONS[raw.command], Polygon(tuple(self._corners))))
            self._corners = []

    def _refuse_half(self) -> None:
        if self._corners:
            raise ItemRefused(INVALID, f"a polygon with {len(self._corners)} of its {self._side[1]:g} corners")


class RallyBuilder:
    """Rally points that come one by one: places on the surface, whatever their height."""

    def __init__(self, sea: WaterFrame, limits: Limits) -> None:
        self._sea, self._limits = sea, limits
        self.points: list[Place] = []

    def add(self, raw: RawItem) -> None:
        """Takes the next item.

        Raises:
            Refused: it is no rally point, or beyond the fence.
        """
        if raw.command != _RALLY:
            raise ItemRefused(UNSUPPORTED, f"command {raw.command} is no rally point")
        if len(self.points) == MOST_PLACES:
            raise ItemRefused(dialect.MAV_MISSION_NO_SPACE, f"there may be {MOST_PLACES} rally points")
        point = Place(*place(raw, self._sea))
        if breach := self._limits.fence.breach(*point):
            raise ItemRefused(INVALID_PARAMS[4], breach)
        self.points.append(point)

    def finish(self) -> str:
        """The document for the core."""
        return json.dumps({"rally": {"points": self.points}})
