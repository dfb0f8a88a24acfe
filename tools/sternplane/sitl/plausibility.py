"""Whether autopilot and simulated vehicle fit each other: what is refused, and what a person is told."""

from __future__ import annotations

import math
from collections.abc import Iterator

from firmware_py import mission_check
from firmware_py.params import ParamError
from firmware_py.reconfiguration import AutopilotParams
from firmware_py.records.fence import NO_FENCE
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.plant.truth import Truth
from sim_bridge.scenarios import Scenario

_RATE_SLACK = 2.0
"""A commanded rate over the servo's by more than this factor is a mistake; a little more lets the servo do its best."""


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


def refuse_mission(scenario: Scenario, where: str, params: AutopilotParams) -> None:
    """Refuse a scenario's mission that no station could upload.

    Limits and fences that stations have sent, and that were kept, do not count: a vehicle that starts again must start.

    Args:
        scenario: with the mission and the bottom.
        where: its file.
        params: of the files alone.

    Raises:
        ParamError: names the file, the item and the limit.
    """
    key = "waypoints" if scenario.waypoints else "items"
    mission_check.refuse_mission(scenario.mission, params, NO_FENCE, where, key)
    mission_check.refuse_near_bottom(scenario.mission, scenario.bottoms, params.safety.altitude_min, where, key)


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
