"""The checks of an uploaded mission, for one from a file: mission.toml or a scenario."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_py.mavlink.plans.items import ItemRefused, Limits
from firmware_py.mavlink.plans.path_check import PathCheck
from firmware_py.params import ParamError
from firmware_py.reconfiguration import AutopilotParams, node_settings
from firmware_py.records.fence import Fence
from firmware_py.records.manoeuvrability import UNLIMITED, Manoeuvrability
from firmware_py.records.mission import Loiter, Manoeuvre, Mission, MissionItem, Waypoint


def refuse_mission(
    mission: Mission,
    params: AutopilotParams,
    fence: Fence,
    where: str,
    key: str,
    able: Manoeuvrability = UNLIMITED,
) -> None:
    """Refuse a mission that a station could not upload, or that asks for speeds that are not flown.

    Args:
        mission: the items.
        params: their limits: `safety.depth_max`, `safety.altitude_min`, `guidance.speed_max`, radii of circles.
        fence: the areas that items and legs must keep to.
        where: file of the mission.
        key: name of its list of tables, "waypoints" or "items".
        able: what the vehicle can do: circles are no tighter than its turns, and its planes need speed.

    Raises:
        ParamError: names the file, the item and the limit.
    """
    turning = params.guidance.turning.widened(able.turn_radius)
    limits = Limits(*node_settings(params).limits[:2], fence, turning)
    path_check = PathCheck(limits)
    depth_max = params.safety.depth_max
    for i, item in enumerate(mission.items):
        if isinstance(item, Waypoint | Loiter) and not item.above and item.z > depth_max:
            limit = f"safety.depth_max_m = {depth_max:g}"
            raise ParamError(f"{where}: {key}[{i}]: depth {item.z:.1f} m is over {limit}")
        try:
            path_check.check(i, item)
        except ItemRefused as refused:
            raise ParamError(f"{where}: {key}[{i}]: {refused}") from None
        if (speed := _speed(item)) > params.guidance.speed_max:
            limit = f"guidance.speed_max_m_s = {params.guidance.speed_max:g}"
            raise ParamError(f"{where}: {key}[{i}]: speed_m_s = {speed:g} is over {limit}")
        if 0.0 < speed < able.speed:
            least = f"{able.speed:.2f} m/s, below which planes do not hold the trim"
            raise ParamError(f"{where}: {key}[{i}]: speed_m_s = {speed:g} is under {least}")


def refuse_near_bottom(mission: Mission, bottoms: Sequence[float], altitude_min: float, where: str, key: str) -> None:
    """Refuse an item whose depth is nearer to the bottom than `altitude_min`, m.

    `bottoms` has the depth of the bottom, m, at each item; NaN where none is known.

    Raises:
        ParamError: names the file, the item and the limit.
    """
    for i, (item, bottom) in enumerate(zip(mission.items, bottoms, strict=True)):
        if isinstance(item, Waypoint | Loiter) and not item.above and bottom - item.z < altitude_min:
            raise ParamError(
                f"{where}: {key}[{i}]: depth {item.z:g} m, and the bottom is {bottom:g} m deep there: nearer than "
                f"safety.altitude_min_m = {altitude_min:g}"
            )


def _speed(item: MissionItem) -> float:
    if isinstance(item, Manoeuvre):
        return item.speed
    return item.u if isinstance(item, Waypoint | Loiter) else 0.0
