"""Mission, fence and rally points that stations sent in an earlier run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.config_files import Configuration, autopilot_params
from firmware_py.marine import Origin
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans import plan_builder
from firmware_py.mavlink.plans.plan_builder import PlanBuilder
from firmware_py.params import prefix_errors
from firmware_py.records.fence import fence_to_plain
from firmware_py.records.mission_tables import mission_from_plain, mission_to_plain
from firmware_py.records.order import Change, FenceChange, MissionChange, RallyChange


def with_kept_plans(configuration: Configuration, state: Path | None) -> dict[str, Any]:
    """Return the configuration with the mission, fence and rally points that stations sent in an earlier run.

    Raises:
        ParamError: a saved plan cannot be used; the error names the file.
    """
    tables: dict[str, Any] = {}
    for plan in _kept_plans(configuration, state).values():
        tables |= _table(plan.finish()[1])
    return {**configuration, **tables}


def _table(change: Change) -> dict[str, Any]:
    """Return a plan as a configuration has it."""
    if isinstance(change, MissionChange):
        return {"mission": mission_to_plain(change.mission)}
    if isinstance(change, FenceChange):
        return {"fence": fence_to_plain(change.fence)}
    return {"rally": {"points": [list(point) for point in change.points]}} if isinstance(change, RallyChange) else {}


def plans(configuration: Configuration, state: Path | None) -> dict[int, PlanBuilder]:
    """Return mission, fence and rally points as stations may read and change them.

    Raises:
        ParamError: a saved plan cannot be used; the error names the file.
    """
    found = _kept_plans(configuration, state)
    if plan_builder.MISSION not in found:
        frame = _water_frame(configuration)
        found[plan_builder.MISSION] = plan_builder.plan_of_mission(mission_from_plain(configuration["mission"]), frame)
    return found


def _kept_plans(configuration: Configuration, state: Path | None) -> dict[int, PlanBuilder]:
    found: dict[int, PlanBuilder] = {}
    for kind, name in plan_builder.FILES.items():
        if state is not None and (state / name).exists():
            found[kind] = _read_kept(configuration, state, kind)
    return found


def kept_table(configuration: Configuration, state: Path, kind: int) -> dict[str, Any]:
    """Return a saved plan of a kind of `plan_builder.FILES` as a configuration has it.

    Raises:
        OSError, UnicodeDecodeError: the file cannot be read.
        ParamError: it cannot be used; the error names it.
    """
    return _table(_read_kept(configuration, state, kind).finish()[1])


def _read_kept(configuration: Configuration, state: Path, kind: int) -> PlanBuilder:
    path = state / plan_builder.FILES[kind]
    with prefix_errors(str(path)):
        return plan_builder.read_plan(kind, read_regular(path).decode(), _water_frame(configuration))


def _water_frame(configuration: Configuration) -> WaterFrame:
    params = autopilot_params(configuration)
    origin = Origin(params.origin.latitude, params.origin.longitude)
    return WaterFrame(origin, params.mavlink.telemetry.surface_altitude)
