"""Odometry, as ROS 2 has it: pose and twist together, with what is known of their variance.

Foxglove shows nav_msgs/Odometry too, in its versions from before it had a schema of its own for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from sternplane.logs.export.ros_frames import BODY, TRUE_BODY, WORLD, body_vector, diagonal
from sternplane.logs.export.streams import Pose, Rows, Stream

_MOTIONS = [f"nu.{one}" for one in "uvwpqr"]
_NO_SPREAD = 36 * (0.0,)


def odometry_streams(rows: Rows) -> Iterator[Stream]:
    """Yield the estimated odometry of a piece, and the true one where there is a truth."""
    stamps, poses, twists = rows.stamps, rows.poses(), rows.of(*(f"state.{name}" for name in _MOTIONS))
    spread = rows.of("state.position_std", "state.depth_std", "state.velocity_std")

    def estimated(i: int) -> tuple[Any, ...] | None:
        if (pose := poses[i]) is None:
            return None
        place, depth, speed = spread[i]
        of_place = diagonal(*2 * (0.5 * place * place,), depth * depth, 0.0, 0.0, 0.0)
        of_speed = diagonal(*2 * (speed * speed,), 0.0, 0.0, 0.0, 0.0)
        return *stamps[i], WORLD, BODY, *flat(pose), *of_place, *twist(twists[i]), *of_speed

    yield Stream("/odometry", "nav_msgs/Odometry", estimated)
    if not rows.truth:
        return
    true_poses, moves = rows.poses(true=True), rows.of_truth(*_MOTIONS)

    def true(i: int) -> tuple[Any, ...] | None:
        if (pose := true_poses[i]) is None:
            return None
        return *stamps[i], WORLD, TRUE_BODY, *flat(pose), *_NO_SPREAD, *twist(moves[i]), *_NO_SPREAD

    yield Stream("/odometry/truth", "nav_msgs/Odometry", true)


def flat(pose: Pose) -> tuple[float, ...]:
    """Return a pose as the numbers of a message."""
    return *pose.position, *pose.orientation


def twist(nu: tuple[Any, ...]) -> tuple[float, ...]:
    """Return a body velocity, forward-starboard-down, as the numbers of a message."""
    u, v, w, p, q, r = nu
    return *body_vector(u, v, w), *body_vector(p, q, r)
