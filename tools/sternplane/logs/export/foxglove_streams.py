"""Topics of a Foxglove export, in Foxglove's own schemas; twist and odometry in those of ROS 2.

Source: https://docs.foxglove.dev/docs/sdk/schemas.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from firmware_py.records.event import Severity
from sternplane.logs.export.odometry_streams import odometry_streams, twist
from sternplane.logs.export.ros_frames import BODY, TRUE_BODY, WORLD, Vector, diagonal, world_vector
from sternplane.logs.export.streams import Rows, Stream, Told, World, stamp

LOG = ("/log", "foxglove_msgs/Log")
PLAN = (("/plan", "foxglove_msgs/PosesInFrame"), ("/plan/map", "foxglove_msgs/GeoJSON"))
_APPROXIMATED = 1
_LEVELS = {
    Severity.EMERGENCY: 5,
    Severity.ALERT: 5,
    Severity.CRITICAL: 4,
    Severity.ERROR: 4,
    Severity.WARNING: 3,
    Severity.NOTICE: 2,
    Severity.INFO: 2,
    Severity.DEBUG: 1,
}
_BLUE, _BLACK, _ORANGE = (0.15, 0.39, 0.92, 1.0), (0.06, 0.09, 0.16, 1.0), (0.96, 0.62, 0.04, 1.0)
_NAN = math.nan


def streams(rows: Rows, world: World) -> Iterator[Stream]:
    """Yield the topics of a piece."""
    stamps, twists = rows.stamps, rows.of(*(f"state.nu.{one}" for one in "uvwpqr"))
    poses = {BODY: rows.poses()} | ({TRUE_BODY: rows.poses(true=True)} if rows.truth else {})

    def transforms(i: int) -> tuple[Any, ...] | None:
        known = [(name, pose) for name, all_poses in poses.items() if (pose := all_poses[i])]
        bodies = [(*stamps[i], WORLD, name, *pose.position, *pose.orientation) for name, pose in known]
        return (bodies,) if bodies else None

    def alone(name: str) -> Any:
        return lambda i: (pose := poses[name][i]) and (*stamps[i], WORLD, *pose.position, *pose.orientation)

    yield Stream("/tf", "foxglove_msgs/FrameTransforms", transforms)
    yield Stream("/pose", "foxglove_msgs/PoseInFrame", alone(BODY))
    if rows.truth:
        yield Stream("/pose/truth", "foxglove_msgs/PoseInFrame", alone(TRUE_BODY))

    yield Stream("/twist", "geometry_msgs/TwistStamped", lambda i: (*stamps[i], BODY, *twist(twists[i])))
    yield from odometry_streams(rows)
    yield from _places(rows, world)


def told(event: Told) -> tuple[Any, ...]:
    """Return an event as a message."""
    return *stamp(event.t_ns), _LEVELS[event.severity], event.text, "sternplane", "", 0


def plan(t_ns: int, waypoints: list[Vector], world: World) -> Iterator[tuple[Any, ...]]:
    """Yield a mission as each message of PLAN."""
    yield *stamp(t_ns), WORLD, [(*world_vector(*place), 0.0, 0.0, 0.0, 1.0) for place in waypoints]
    places = [world.degrees(x, y)[::-1] for x, y, _ in waypoints]  # longitude comes first
    legs = {"type": "Feature", "geometry": {"type": "LineString", "coordinates": places}, "properties": {}}
    points = [
        {
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": place},
            "properties": {"name": f"waypoint {number}, {z:g} m deep"},
        }
        for number, (place, (_, _, z)) in enumerate(zip(places, waypoints, strict=True), 1)
    ]
    features = [legs, *points] if len(points) > 1 else points
    yield (json.dumps({"type": "FeatureCollection", "features": features}),)


def _places(rows: Rows, world: World) -> Iterator[Stream]:
    """Yield the fixes that were heard, and where the vehicle believed to be and was, for maps.

    Altitudes count from where the configuration's surface_altitude does.
    """
    fixes = rows.heard("fix", "latitude", "longitude", "std")
    depths = rows.of("state.eta.z")

    def fix(i: int) -> tuple[Any, ...] | None:
        if (heard := fixes[i]) is None:
            return None
        latitude, longitude, std = heard[1]
        place = (math.degrees(latitude), math.degrees(longitude), world.surface - depths[i][0])
        return _location(heard[0], place, std, _NAN, _ORANGE)

    yield Stream("/fix", "foxglove_msgs/LocationFix", fix)
    estimated = ("state.eta.x", "state.eta.y", "state.eta.z", "state.eta.psi", "state.position_std")
    places = [("estimate", rows.of(*estimated), _BLUE)]
    if rows.truth:
        true = [(*row, 0.0) for row in rows.of_truth("eta.x", "eta.y", "eta.z", "eta.psi")]
        places.append(("truth", true, _BLACK))
    for what, values, colour in places:
        yield Stream(f"/fix/{what}", "foxglove_msgs/LocationFix", _place(rows, world, values, colour))


def _place(rows: Rows, world: World, values: list[tuple[Any, ...]], colour: tuple[float, ...]) -> Any:
    def row(i: int) -> tuple[Any, ...] | None:
        x, y, z, psi, together = values[i]
        if i % rows.places_every or not math.isfinite(x + y):
            return None
        place = (*world.degrees(x, y), world.surface - z)
        return _location(rows.stamps[i], place, math.sqrt(0.5) * together, psi, colour)

    return row


def _location(
    when: tuple[int, int], place: Vector, std: float, heading: float, colour: tuple[float, ...]
) -> tuple[Any, ...]:
    """Return a LocationFix without what is not told: the variance of the heading, and the velocity."""
    covariance = diagonal(std * std, std * std, 0.0)
    return *when, BODY, *place, *covariance, _APPROXIMATED, heading, *4 * (_NAN,), *colour, []
