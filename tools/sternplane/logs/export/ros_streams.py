"""Topics of a rosbag2 export: pose, twist, odometry, TF, location, plan and log as ROS 2 has them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from firmware_py.records.event import Severity
from sternplane.logs.export.odometry_streams import flat, odometry_streams, twist
from sternplane.logs.export.ros_frames import BODY, TRUE_BODY, WORLD, Vector, diagonal, world_vector
from sternplane.logs.export.streams import Rows, Stream, Told, World, stamp

LOG, PLAN = ("/rosout", "rcl_interfaces/Log"), (("/plan", "nav_msgs/Path"),)
_FIX, _GPS, _NOT_KNOWN = 0, 1, 0
_APPROXIMATED = 1
_LEVELS = {
    Severity.EMERGENCY: 50,
    Severity.ALERT: 50,
    Severity.CRITICAL: 40,
    Severity.ERROR: 40,
    Severity.WARNING: 30,
    Severity.NOTICE: 20,
    Severity.INFO: 20,
    Severity.DEBUG: 10,
}


def streams(rows: Rows, world: World) -> Iterator[Stream]:
    """Yield the topics of a piece."""
    stamps, poses, twists = rows.stamps, rows.poses(), rows.of(*(f"state.nu.{one}" for one in "uvwpqr"))
    true_poses = rows.poses(true=True) if rows.truth else [None] * len(poses)

    def transforms(i: int) -> tuple[Any, ...] | None:
        bodies = ((BODY, poses[i]), (TRUE_BODY, true_poses[i]))
        known = [(*stamps[i], WORLD, name, *flat(pose)) for name, pose in bodies if pose]
        return (known,) if known else None

    def pose_alone(i: int) -> tuple[Any, ...] | None:
        pose = poses[i]
        return pose and (*stamps[i], WORLD, *flat(pose))

    yield Stream("/tf", "tf2_msgs/TFMessage", transforms)
    yield from odometry_streams(rows)
    yield Stream("/pose", "geometry_msgs/PoseStamped", pose_alone)
    yield Stream("/twist", "geometry_msgs/TwistStamped", lambda i: (*stamps[i], BODY, *twist(twists[i])))
    yield from _places(rows, world)


def told(event: Told) -> tuple[Any, ...]:
    """Return an event as a message."""
    return *stamp(event.t_ns), _LEVELS[event.severity], "sternplane", event.text, "", "", 0


def plan(t_ns: int, waypoints: list[Vector], _world: World) -> Iterator[tuple[Any, ...]]:
    """Yield a mission as each message of PLAN; poses have no orientation."""
    head = (*stamp(t_ns), WORLD)
    yield *head, [(*head, *world_vector(*place), 0.0, 0.0, 0.0, 1.0) for place in waypoints]


def _places(rows: Rows, world: World) -> Iterator[Stream]:
    """Yield the fixes that were heard, and where the vehicle believed to be and was, for maps.

    The altitude is not known: it counts from the WGS 84 ellipsoid there.
    """
    fixes = rows.heard("fix", "latitude", "longitude", "std")

    def fix(i: int) -> tuple[Any, ...] | None:
        if (heard := fixes[i]) is None:
            return None
        latitude, longitude, std = heard[1]
        return _location(heard[0], math.degrees(latitude), math.degrees(longitude), std, _GPS)

    yield Stream("/fix", "sensor_msgs/NavSatFix", fix)
    places = [("estimate", rows.of("state.eta.x", "state.eta.y", "state.position_std"))]
    if rows.truth:
        places.append(("truth", [(x, y, 0.0) for x, y in rows.of_truth("eta.x", "eta.y")]))
    for what, values in places:
        yield Stream(f"/fix/{what}", "sensor_msgs/NavSatFix", _place(rows, world, values))


def _place(rows: Rows, world: World, values: list[tuple[Any, ...]]) -> Any:
    def row(i: int) -> tuple[Any, ...] | None:
        x, y, together = values[i]
        if i % rows.places_every or not math.isfinite(x + y):
            return None
        return _location(rows.stamps[i], *world.degrees(x, y), math.sqrt(0.5) * together, _NOT_KNOWN)

    return row


def _location(when: tuple[int, int], latitude: float, longitude: float, std: float, service: int) -> tuple[Any, ...]:
    covariance = diagonal(std * std, std * std, 0.0)
    return *when, BODY, _FIX, service, latitude, longitude, math.nan, *covariance, _APPROXIMATED
