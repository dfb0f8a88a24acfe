"""Check of a mission's legs against the fence and the limits, item by item, jumps included.

The leg to the first position is known when the mission is started; `check_first_leg` checks it then. What is not known
beforehand is left to the supervisor, which watches the vehicle's position: the leg after a manoeuvre, the leg to a
rally point (chosen on entering: `guidance.rally_point`), circles widened by a speed ordered meanwhile, and how
far a corner is rounded.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.mavlink.plans.items import INVALID, INVALID_PARAMS, ItemRefused, Limits
from firmware_py.records.fence import Fence
from firmware_py.records.mission import Jump, Loiter, MissionItem, Surface, Waypoint

_MAX_ALTITUDE = 6000.0
_MISS_SHARE = 1.0 / 12.0
"""Share of its radius by which the vehicle may miss a circle, to either side."""
_MAX_STARTS = 16
"""Jumps forward to one item; the cost of checking an item is bounded."""


class _Target(NamedTuple):
    """A position, m, and the radius of the circle flown around it; 0 for a waypoint."""

    x: float
    y: float
    radius: float


class PathCheck:
    """Checks steps in order; remembers from which positions the next one can be reached."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._targets: list[tuple[int, _Target]] = []
        self._starts: set[_Target] = set()
        self._jumped_to: dict[int, set[_Target]] = {}

    def check(self, number: int, step: MissionItem) -> None:
        """Check the next step; `number` is the item by which jumps refer to it.

        Raises:
            ItemRefused: it, or a leg to it, is too deep, too near to the bottom or outside the fence.
        """
        for to in [to for to in self._jumped_to if to <= number]:
            self._starts |= self._jumped_to.pop(to)
        if isinstance(step, Jump):
            if step.times != 0:
                self._check_jump(number, step)
        elif isinstance(step, Waypoint | Loiter):
            self._check_leg_to(number, step)
        elif isinstance(step, Surface):
            self._starts = set()

    def _check_leg_to(self, number: int, step: Waypoint | Loiter) -> None:
        limits = self._limits
        if step.above and not limits.altitude_min <= step.z <= _MAX_ALTITUDE:
            raise ItemRefused(INVALID_PARAMS[6], f"{step.z:g} m above the bottom, minimum {limits.altitude_min:g} m")
        if not step.above and step.z > limits.depth_max:
            raise ItemRefused(INVALID_PARAMS[6], f"depth {step.z:.1f} m, limit {limits.depth_max:g} m")
        target = _target_of(step, limits)
        if why := _circle_problem(target, limits.fence):
            raise ItemRefused(INVALID_PARAMS[4], why)
        for start in self._starts:
            self._check_leg(start, target, "the leg to it")
        self._starts = {target}
        self._targets.append((number, target))

    def _check_jump(self, number: int, jump: Jump) -> None:
        """Check the leg back to a known position, or remember the jump forward until its item comes."""
        at = bisect_left(self._targets, jump.to, key=lambda target: target[0])
        if at < len(self._targets):
            for start in self._starts:
                self._check_leg(start, self._targets[at][1], "the leg back")
        elif jump.to > number:
            starts = self._jumped_to.setdefault(jump.to, set())
            starts |= self._starts
            if len(starts) > _MAX_STARTS:
                raise ItemRefused(INVALID, f"jumps lead to one item from more than {_MAX_STARTS} positions")
        if jump.times < 0:
            self._starts = set()

    def _check_leg(self, start: _Target, end: _Target, way: str) -> None:
        if why := _leg_problem(start, end, self._limits):
            raise ItemRefused(INVALID_PARAMS[4], f"{way} is {why}")


def check_first_leg(
    steps: Sequence[MissionItem], at: int, x: float, y: float, limits: Limits
) -> tuple[int, str] | None:
    """Check the straight leg from (x, y), m, to the first position of a mission from step `at` on.

    Returns:
        The step with that position, and what is wrong; None if nothing is, or the position is not known beforehand.
    """
    for _ in steps:
        step = steps[at] if at < len(steps) else None
        if isinstance(step, Waypoint | Loiter):
            why = _leg_problem(_Target(x, y, 0.0), _target_of(step, limits), limits)
            return (at, why) if why else None
        if not isinstance(step, Jump):
            break
        at = step.to if step.times != 0 else at + 1
    return None


def check_guided(here: tuple[float, float] | None, x: float, y: float, u: float, limits: Limits) -> str:
    """Return what is wrong with circling about (x, y), m, at u, m/s (0: cruising speed), or with the leg there.

    `here` is where the vehicle is, None if that is unknown.
    """
    turning = limits.turning
    target = _Target(x, y, turning.radius(0.0, turning.speed(u)))
    if why := limits.fence.problem_at(x, y):
        return f"the position is {why}"
    if why := _circle_problem(target, limits.fence):
        return f"the circle around the position, {target.radius:.0f} m in radius, is {why}"
    if (
        here is not None
        and not limits.fence.problem_at(*here)
        and (why := _leg_problem(_Target(*here, 0.0), target, limits))
    ):
        return f"the leg to the position is {why}"
    return ""


def _target_of(step: Waypoint | Loiter, limits: Limits) -> _Target:
    turning = limits.turning
    radius = turning.radius(step.radius, turning.speed(step.u)) if isinstance(step, Loiter) else 0.0
    return _Target(step.x, step.y, radius)


def _circle_problem(target: _Target, fence: Fence) -> str:
    """What is wrong with a circle, or with its centre if it has no radius."""
    if target.radius == 0.0:
        return fence.problem_at(target.x, target.y)
    rims = (
        fence.circle_problem(target.x, target.y, target.radius * share)
        for share in (1.0, 1.0 - _MISS_SHARE, 1.0 + _MISS_SHARE)
    )
    return next((why for why in rims if why), "")


def _leg_problem(start: _Target, end: _Target, limits: Limits) -> str:
    """From where a circle is left to where the next one is joined, which is on the line of their centres."""
    dx, dy = end.x - start.x, end.y - start.y
    far = math.hypot(dx, dy) or 1.0
    left, joined = start.radius / far, 1.0 - end.radius / far
    return limits.fence.leg_problem(
        start.x + left * dx, start.y + left * dy, start.x + joined * dx, start.y + joined * dy
    )
