"""Whether autopilot and simulated vehicle fit each other: what is refused, and what a person is told."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from firmware_py import config_files, mission_check
from firmware_py.params import ParamError, prefix_errors
from firmware_py.reconfiguration import AutopilotParams
from firmware_py.records.fence import NO_FENCE
from firmware_py.records.manoeuvrability import Manoeuvrability
from firmware_py.records.mission import Loiter, Waypoint
from firmware_py.vehicle.manoeuvrability import ManoeuvrabilityModel
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.plant.truth import Truth
from sim_bridge.scenarios import Scenario

_RATE_SLACK = 2.0
"""A commanded rate over the servo's by more than this factor is a mistake; a little more lets the servo do its best."""
_AFLOAT = 1.0
"""Not deeper than this, m, the vehicle is at the surface."""
_MOST_NAMED = 4
"""So many places are named."""


def refuse_slow_sensors(params: AutopilotParams, devices: DevicesParams, autopilot: str, sensors: str) -> None:
    """Refuse a sensor that is given up before its next reading; `autopilot` and `sensors` name the files.

    `params` are those of the files alone: what stations have changed does not keep a vehicle from starting again.

    Raises:
        ParamError: names both files and both keys.
    """
    safety = params.safety
    for sensor, rate, key, timeout in (
        ("ahrs", devices.ahrs.rate, "attitude_timeout_s", safety.attitude_timeout),
        ("ahrs", devices.ahrs.rate, "gate.ahrs_timeout_s", safety.gate.ahrs_timeout),
        ("pressure", devices.pressure.rate, "depth_timeout_s", safety.depth_timeout),
        ("fix", devices.fix.rate, "fix_timeout_s", safety.fix_timeout),
    ):
        if rate * timeout < 1.0:
            raise ParamError(
                f"{sensors}: {sensor}.rate_hz = {rate:g}: safety.{key} = {timeout:g} in {autopilot} gives it up "
                "before its next reading"
            )


def refuse_payload(devices: DevicesParams, sensors: str) -> None:
    """Refuse sensors of one's own where there is no bus for their messages.

    Raises:
        ParamError: names the file and the key.
    """
    if devices.payload:
        raise ParamError(f"{sensors}: payload: there is no bus over mavlink-hil that could carry it; leave --link away")


def refuse_other_scale(vehicle: Vehicle, devices: DevicesParams, vehicle_file: str, sensors: str) -> None:
    """Refuse a full scale that differs: over mavlink-hil a command is a share of it.

    Raises:
        ParamError: names both files and both keys.
    """
    if any(fin.delta_max != devices.servo_hub.travel for fin in vehicle.fins):
        keys = "servo_hub.travel_deg must be delta_max_deg of every fin"
    elif vehicle.propeller.n_max != devices.esc.n_max:
        keys = "esc.n_max_rpm must be propeller.n_max_rpm"
    else:
        return
    raise ParamError(f"{sensors}: {keys} in {vehicle_file}: over mavlink-hil a command is a share of it")


def abilities(configuration: Mapping[str, Any]) -> Manoeuvrability:
    """Return what the vehicle of a configuration can do by its file.

    Raises:
        ParamError: names the file and the key.
    """
    with prefix_errors(configuration["files"]["vehicle"]):
        return ManoeuvrabilityModel(config_files.vehicle(configuration)).of(None, ())


def refuse_mission(scenario: Scenario, where: str, params: AutopilotParams, able: Manoeuvrability) -> None:
    """Refuse a scenario's mission that no station could upload.

    Limits and fences that stations have sent, and that were kept, do not count: a vehicle that starts again must start.

    Args:
        scenario: with the mission and the bottom.
        where: its file.
        params: of the files alone.
        able: what the vehicle can do.

    Raises:
        ParamError: names the file, the item and the limit.
    """
    key = _items_key(scenario)
    mission_check.refuse_mission(scenario.mission, params, NO_FENCE, where, key, able)
    mission_check.refuse_near_bottom(scenario.mission, scenario.bottoms, params.safety.altitude_min, where, key)


def doubtful_course(
    scenario: Scenario, where: str, params: AutopilotParams, devices: DevicesParams, sensors: str
) -> Iterator[str]:
    """Yield what of a scenario's orders and mission is hardly meant, a sentence each.

    These are depths beyond the limit, which no station could order but a scenario may to see what follows; the loss of
    a station that was never heard; and a bottom beyond the DVL's range: under water at the start, at the depths that
    are ordered, as if the vehicle stayed there, and along the mission. At the surface it has fixes. An altitude of the
    mission is one that a sensor must hear.
    """
    limit = f"safety.depth_max_m = {params.safety.depth_max:g}"
    for i, order in enumerate(scenario.orders):
        if order.depth > params.safety.depth_max:
            yield f"{where}: orders[{i}]: depth_m = {order.depth:g} is over {limit}: depth_max_action follows there"
    for fault in scenario.injected:
        if fault.target == "station" and fault.t == 0.0:
            yield f"fault {fault.text}: no station was heard before: no rule tells of it, and no order comes through"
    reach = devices.dvl.range_max
    far = [(name, bottom, z) for name, bottom, z in _places(scenario, params.safety.depth_max) if bottom - z > reach]
    if far:
        names, (_, bottom, z) = [*dict.fromkeys(name for name, _, _ in far)], far[0]
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        yield (
            f"{where}: {', '.join(names[:_MOST_NAMED])}{more}: no bottom lock: the bottom is {bottom:g} m deep, "
            f"{bottom - z:g} m below the vehicle, and dvl.range_max_m = {reach:g} in {sensors}; without the DVL's "
            "velocity the position drifts, and learning does not begin"
        )
    yield from _unheard_altitudes(scenario, where, params.safety.depth_max, devices, sensors)


def _unheard_altitudes(
    scenario: Scenario, where: str, deepest: float, devices: DevicesParams, sensors: str
) -> Iterator[str]:
    """Yield the places above the bottom from which neither altimeter nor DVL reach down to it."""
    dvl, altimeter = devices.dvl.range_max, devices.altimeter.range_max
    key, bottom_at = _items_key(scenario), scenario.environment.bottom_at
    for i, item in enumerate(scenario.mission.items):
        if not isinstance(item, Waypoint | Loiter) or not item.above:
            continue
        height = bottom_at(item.x) - _depth_of(item, bottom_at(item.x), deepest)
        if height > max(dvl, altimeter):
            yield (
                f"{where}: {key}[{i}]: altitude_m = {item.z:g}: no sensor hears the bottom there, {height:g} m below: "
                f"altimeter.range_max_m = {altimeter:g}, dvl.range_max_m = {dvl:g} in {sensors}; the vehicle goes by "
                "where the bottom was last heard, or stays at its depth"
            )


def _depth_of(item: Waypoint | Loiter, bottom: float, deepest: float) -> float:
    """Return how deep the vehicle is at an item, m; where it goes by the bottom no deeper than its limit."""
    return min(max(bottom - item.z, 0.0), deepest) if item.above else item.z


def _places(scenario: Scenario, deepest: float) -> Iterator[tuple[str, float, float]]:
    """Yield name, depth of the bottom and of the vehicle, m, of the places that a scenario leads to.

    `deepest`: no altitude leads deeper, m.
    """
    start, key, bottom_at = scenario.start, _items_key(scenario), scenario.environment.bottom_at
    before = start.x
    if start.depth > _AFLOAT:
        yield "start", bottom_at(start.x), start.depth
    for i, order in enumerate(scenario.orders):
        if order.depth > _AFLOAT:
            yield f"orders[{i}]", bottom_at(start.x), order.depth
    for i, item in enumerate(scenario.mission.items):
        if isinstance(item, Waypoint | Loiter):
            low, high = sorted((before, item.x))
            corners = [corner.north for corner in scenario.environment.bottom if low < corner.north < high]
            for x in (item.x, *corners):
                yield f"{key}[{i}]", bottom_at(x), _depth_of(item, bottom_at(x), deepest)
            before = item.x


def _items_key(scenario: Scenario) -> str:
    return "waypoints" if scenario.waypoints else "items"


def misplaced(vehicle: Vehicle, devices: DevicesParams, vehicle_file: str, sensors: str) -> Iterator[str]:
    """Yield the sensors that sit elsewhere than the vehicle file believes."""
    for name in ("dvl", "pressure", "altimeter", "fix"):
        believed, true = getattr(vehicle.sensors, name), getattr(devices, name).at
        if believed != true:
            yield f"{vehicle_file}: sensors.{name}_m = {list(believed)}, but {name}.at_m = {list(true)} in {sensors}"


def doubts(vehicle: Vehicle, truth: Truth, vehicle_file: str, truth_file: str) -> Iterator[str]:
    """Yield what the vehicle file believes of its actuators that the simulated ones do not have."""
    servo = truth.servo
    for i, fin in enumerate(vehicle.fins):
        if fin.delta_max > servo.limit:
            yield (
                f"{vehicle_file}: fins[{i}]: delta_max_deg = {math.degrees(fin.delta_max):g}, but servo.limit_deg = "
                f"{math.degrees(servo.limit):g} in {truth_file}"
            )
        if fin.rate_max > _RATE_SLACK * servo.rate:
            yield (
                f"{vehicle_file}: fins[{i}]: rate_max_deg_s = {math.degrees(fin.rate_max):g}, but servo.rate_deg_s = "
                f"{math.degrees(servo.rate):g} in {truth_file}"
            )
    if vehicle.propeller.n_max > truth.shaft.limit:
        yield (
            f"{vehicle_file}: propeller.n_max_rpm = {60.0 * vehicle.propeller.n_max:g}, but shaft.limit_rpm = "
            f"{60.0 * truth.shaft.limit:g} in {truth_file}"
        )
