"""Limits in the files of a configuration that contradict each other, or that keep another from being reached."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from firmware_py import app, config_files
from firmware_py.params import ParamError, load
from firmware_py.reconfiguration import AutopilotParams
from firmware_py.records.mission import Mission
from firmware_py.records.mission_tables import mission_to_plain
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.plant.truth import Truth, refuse_other_fins
from sim_bridge.truth_file import read_truth
from sternplane.sitl import plausibility
from sternplane.vehicles.finding import Finding, Grade

_SAME = 0.02


class Files(NamedTuple):
    """A configuration, read: what the autopilot believes, how it flies, and what is simulated."""

    folder: Path
    vehicle: Vehicle
    autopilot: AutopilotParams
    truth: Truth
    devices: DevicesParams


def read_files(folder: Path) -> Files:
    """Read a configuration, and build its autopilot.

    Raises:
        ParamError: in one line, which file and key is wrong, and what would be right.
    """
    configuration = {**config_files.read_configuration(folder), "mission": mission_to_plain(Mission()), "kept": {}}
    vehicle = config_files.vehicle(configuration)
    app.build(configuration)
    truth = read_truth(folder / "truth.toml")
    refuse_other_fins(truth, str(folder / "truth.toml"), len(vehicle.fins), str(folder / "vehicle.toml"))
    sensors = folder / "sensors.toml"
    devices = load(DevicesParams, config_files.read_table(DevicesParams, sensors, {}), str(sensors))
    return Files(folder, vehicle, config_files.autopilot_params(configuration), truth, devices)


def top_shaft(files: Files) -> tuple[float, str]:
    """Return the highest shaft speed that is reached, rev/s, and the key that sets it."""
    return min(
        (files.vehicle.propeller.n_max, "propeller.n_max_rpm in vehicle.toml"),
        (files.truth.shaft.limit, "shaft.limit_rpm in truth.toml"),
        (files.devices.esc.n_max, "esc.n_max_rpm in sensors.toml"),
    )


def contradictions(files: Files) -> Iterator[Finding]:
    """Yield what contradicts what, with both keys; one finding that all is well if nothing does."""
    found = [*_propeller(files), *_speeds(files), *_believed(files), *_sensors(files)]
    yield from found
    if not found:
        yield Finding("limits", Grade.PASS, "propeller, fins, speeds and water agree in all files")


def _propeller(files: Files) -> Iterator[Finding]:
    vehicle, (n, key) = files.vehicle, top_shaft(files)
    u_trim, n_trim = vehicle.propeller.u_trim, vehicle.propeller.n_trim
    reached = u_trim * n / n_trim
    if n < vehicle.propeller.n_max:
        yield Finding(
            "propeller",
            Grade.WARN if reached >= files.autopilot.guidance.speed_max else Grade.FAIL,
            f"{key} = {60.0 * n:g} is below propeller.n_max_rpm = {60.0 * vehicle.propeller.n_max:g} in vehicle.toml: "
            f"commands beyond it do nothing, and {reached:.2f} m/s is the fastest; raise it",
        )
    reverse = files.autopilot.control.ascent.n_reverse
    if reverse > n * (1.0 + _SAME):
        yield Finding(
            "propeller",
            Grade.WARN,
            f"control.ascent.n_reverse_rpm = {60.0 * reverse:g}: {key} allows {60.0 * n:g}",
        )


def _speeds(files: Files) -> Iterator[Finding]:
    vehicle, guidance, control = files.vehicle, files.autopilot.guidance, files.autopilot.control
    n, key = top_shaft(files)
    reached = vehicle.propeller.u_trim * n / vehicle.propeller.n_trim
    for name, speed in (
        ("speed_max_m_s", guidance.speed_max),
        ("cruise_speed_m_s", guidance.cruise_speed),
        ("surface_speed_m_s", guidance.surface_speed),
    ):
        if speed > reached * (1.0 + _SAME):
            grade = Grade.WARN if name == "speed_max_m_s" else Grade.FAIL
            text = f"guidance.{name} = {speed:g} is not reached: {key} = {60.0 * n:g} gives {reached:.2f} m/s"
            yield Finding("speed", grade, text)
    if control.u_max < guidance.speed_max:
        yield Finding(
            "speed",
            Grade.WARN,
            f"control.u_max_m_s = {control.u_max:g} is below guidance.speed_max_m_s = {guidance.speed_max:g}: laws are "
            "not designed for that speed",
        )
    velocity = files.autopilot.estimation.velocity
    slope, believed = velocity.u_trim / velocity.n_trim, vehicle.propeller.u_trim / vehicle.propeller.n_trim
    off = slope / believed - 1.0
    if abs(off) > _SAME:
        yield Finding(
            "speed",
            Grade.FAIL if abs(off) > 0.1 else Grade.WARN,
            f"estimation.velocity.u_trim_m_s / n_trim_rpm in autopilot.toml is {100.0 * off:+.0f} % off "
            "propeller.u_trim_m_s / n_trim_rpm in vehicle.toml: without DVL the vehicle would go by a wrong speed",
        )


def _believed(files: Files) -> Iterator[Finding]:
    vehicle, truth, devices = files.vehicle, files.truth, files.devices
    for doubt in plausibility.doubts(vehicle, truth, "vehicle.toml", "truth.toml"):
        if "propeller" not in doubt:  # told above, with the speed that it costs
            yield Finding("fins", Grade.WARN, doubt)
    most = max(fin.delta_max for fin in vehicle.fins)
    if devices.servo_hub.travel < most - 1e-9:
        yield Finding(
            "fins",
            Grade.FAIL,
            f"servo_hub.travel_deg = {math.degrees(devices.servo_hub.travel):g} in sensors.toml is below "
            f"delta_max_deg = {math.degrees(most):g} in vehicle.toml: what is commanded beyond it is not done",
        )
    for i, (fin, true) in enumerate(zip(vehicle.fins, truth.fins, strict=True)):
        if fin.name != true.name or abs(math.remainder(fin.hinge - true.hinge, math.tau)) > 1e-6:
            text = f"fins[{i}] is {fin.name}, hinge {math.degrees(fin.hinge):g} deg, in vehicle.toml, and "
            text += f"{true.name}, {math.degrees(true.hinge):g} deg, in truth.toml: commands go by number"
            yield Finding("fins", Grade.FAIL, text)
    if files.autopilot.safety.gate.n_rate > 2.0 * truth.shaft.rate:
        yield Finding(
            "propeller",
            Grade.WARN,
            f"safety.gate.n_rate_rpm_s = {60.0 * files.autopilot.safety.gate.n_rate:g}, but shaft.rate_rpm_s = "
            f"{60.0 * truth.shaft.rate:g} in truth.toml: what is commanded runs ahead of the shaft",
        )


def _sensors(files: Files) -> Iterator[Finding]:
    vehicle, truth, folder = files.vehicle, files.truth, files.folder
    density = files.autopilot.estimation.depth.density
    for name, value in (("hull.density_kg_m3", vehicle.hull.density), ("hull.rho_kg_m3 in truth.toml", truth.hull.rho)):
        if abs(value / density - 1.0) > _SAME:
            text = f"{name} = {value:g}, but estimation.depth.density_kg_m3 = {density:g}: depth is off by "
            yield Finding("water", Grade.WARN, f"{text}{100.0 * abs(value / density - 1.0):.1f} %")
    for text in plausibility.misplaced(vehicle, files.devices, "vehicle.toml", "sensors.toml"):
        yield Finding("sensors", Grade.WARN, text)
    try:
        plausibility.refuse_slow_sensors(
            files.autopilot, files.devices, str(folder / "autopilot.toml"), str(folder / "sensors.toml")
        )
    except ParamError as error:
        yield Finding("sensors", Grade.FAIL, str(error))
    altimeter = max(files.devices.dvl.range_max, files.devices.altimeter.range_max)
    if altimeter < 2.0 * files.autopilot.safety.altitude_min:
        text = f"no sensor sees the bottom farther than {altimeter:g} m, and safety.altitude_min_m = "
        yield Finding("sensors", Grade.WARN, f"{text}{files.autopilot.safety.altitude_min:g}")
