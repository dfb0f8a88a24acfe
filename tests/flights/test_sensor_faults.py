"""Whole flights with a sensor that lies, judged by the plant: it is named, and the vehicle is where it should be."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.reading import Log, read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.records.event import Cause
from firmware_py.records.health import SensorHealth, SourceFault, SourceState
from firmware_py.records.order import Mode
from tests.straight_run import hold, mission, under_way

DIVE = under_way(50.0, 8.0, mission([(30.0, 8.0), (400.0, 12.0)]))
SPIKES = (
    "spike:pressure=29@18",
    "spike:ahrs.yaw=90@20",
    "spike:ahrs.pitch=60@22",
    "spike:dvl.u=8@24",
    "spike:dvl.w=-3@26",
    "spike:altimeter=-30@28",
    "spike:dvl.altitude=-29@30",
    "spike:leak=60@32",
    "set:altimeter=1@36+0.7",
)


def flown(folder: Path, *faults: str, seed: int = 1000) -> Log:
    place = folder / "dive.toml"
    place.write_text(DIVE)
    fly(prepare(FlightRequest(scenario=str(place), faults=faults, seed=seed), {}), folder / "log.mcap")
    return read(folder / "log.mcap")


def states(log: Log, sensor: str) -> np.ndarray:
    return np.array([getattr(cycle.state.sensors, sensor).state for cycle in log.cycles])


def suspect_at(log: Log, sensor: str) -> float:
    return float(log.columns["t"][np.flatnonzero(states(log, sensor) == SourceState.SUSPECT)[0]])


@pytest.mark.parametrize(
    ("fault", "within"), [("freeze:pressure@20", 0.5), ("drift:pressure=-0.5@20", 1.0), ("drift:pressure=0.1@20", 3.5)]
)
def test_a_pressure_that_lies_while_it_dives_takes_it_no_deeper(tmp_path: Path, fault: str, within: float) -> None:
    log = flown(tmp_path, fault)
    t, z = log.columns["t"], log.truth["eta.z"]
    assert 0.0 <= suspect_at(log, "pressure") - 20.0 <= within
    assert z.max() < 13.0
    assert z[-1] < 2.0  # it came up, for depth was lost
    error = np.abs(log.columns["state.eta.z"] - z)
    assert error[(t > 20.0) & (t < 30.0)].max() < 0.5


def test_single_false_values_of_any_sensor_and_0_7_s_of_a_false_altitude_change_no_mode(tmp_path: Path) -> None:
    log = flown(tmp_path, *SPIKES)
    t = log.columns["t"]
    assert len(set(log.columns["mode.mode"][t > 2.0])) == 1
    assert np.abs(log.columns["state.eta.z"] - log.truth["eta.z"])[t > 5.0].max() < 0.3
    for sensor in SensorHealth._fields:
        if sensor != "altitude":  # seven false echoes in a row are a fault
            assert set(states(log, sensor)) == {SourceState.GOOD}


def test_a_step_of_the_heading_is_named_at_once_and_not_followed(tmp_path: Path) -> None:
    log = flown(tmp_path, "bias:ahrs.yaw=20@15")
    assert suspect_at(log, "ahrs") - 15.0 <= 0.2
    assert np.abs(log.truth["eta.psi"]).max() < math.radians(5.0)
    assert np.abs(log.truth["eta.y"]).max() < 3.0


def ended(folder: Path, duration: float, *faults: str, bottom: float = 40.0) -> Log:
    """Fly level at 8 m, under faults from the start on."""
    place = folder / "level.toml"
    place.write_text(under_way(duration, 8.0, mission([(30.0, 8.0), (400.0, 8.0)]), bottom=bottom))
    fly(prepare(FlightRequest(scenario=str(place), faults=faults, seed=1000), {}), folder / "log.mcap")
    return read(folder / "log.mcap")


def test_a_pitch_that_follows_its_own_wrong_gyro_is_what_is_wrong_and_the_vehicle_comes_up(tmp_path: Path) -> None:
    log = ended(tmp_path, 70.0, "drift:ahrs.pitch=1@15", "bias:ahrs.q=1@15")
    t, z = log.columns["t"], log.truth["eta.z"]
    faults = {cycle.state.sensors.ahrs.fault for cycle in log.cycles}
    assert SourceFault.CONTRADICTED in faults
    assert suspect_at(log, "ahrs") - 15.0 <= 10.0
    assert {cycle.state.sensors.pressure.state for cycle in log.cycles} == {SourceState.GOOD}
    assert {cycle.state.sensors.dvl.fault for cycle in log.cycles} <= {SourceFault.NONE, SourceFault.UNDECIDED}
    assert z.max() < 14.0
    assert z[-1] < 2.0
    assert np.abs(log.columns["state.eta.z"] - z)[t > 5.0].max() < 0.5


def test_a_pressure_that_drifts_without_dvl_is_not_followed_far(tmp_path: Path) -> None:
    log = ended(tmp_path, 80.0, "off:dvl@3", "drift:pressure=-0.3@20")
    assert suspect_at(log, "pressure") - 20.0 <= 25.0
    assert log.truth["eta.z"].max() < 16.0
    assert log.truth["eta.z"][-1] < 2.0


SHALLOW = under_way(60.0, 0.6, mission([(30.0, 0.6), (150.0, 25.0)]))
RIDGE = under_way(100.0, 4.0, mission([(45.0, 6.0), (85.0, 10.0), (175.0, 28.0), (300.0, 28.0)])).replace(
    "bottom_depth_m = 40.0",
    "bottom_depth_m = 40.0\nbottom = [{north_m = -50, depth_m = 40}, {north_m = 120, depth_m = 18}, "
    "{north_m = 135, depth_m = 18}, {north_m = 165, depth_m = 40}]",
)


ALTITUDE = "[[waypoints]]\nx_m = {}\ny_m = 0.0\naltitude_m = {}\nspeed_m_s = 1.8\n"
RISING = ((50.0, 20.0), (200.0, 6.0))
UPHILL = under_way(
    85.0, 9.0, mission([]), *(ALTITUDE.format(*place) for place in ((30.0, 10.0), (400.0, 5.0)))
).replace(
    "bottom_depth_m = 40.0",
    "bottom_depth_m = 20.0\nbottom = [" + ", ".join(f"{{north_m = {x}, depth_m = {z}}}" for x, z in RISING) + "]",
)


def course(folder: Path, text: str, *faults: str, seed: int = 1000) -> Log:
    place = folder / "course.toml"
    place.write_text(text)
    outcome = fly(prepare(FlightRequest(scenario=str(place), faults=faults, seed=seed), {}), folder / "log.mcap")
    assert "aground" not in outcome.reason
    return read(folder / "log.mcap")


@pytest.mark.parametrize("kind", ["off", "freeze"])
def test_a_vehicle_that_no_longer_sees_the_bottom_that_it_follows_comes_up_and_touches_nothing(
    tmp_path: Path, kind: str
) -> None:
    log = course(tmp_path, UPHILL, f"{kind}:dvl@25", f"{kind}:altimeter@25")
    t, z = log.columns["t"], log.truth["eta.z"]
    surfacing = t[log.columns["mode.mode"] == Mode.SURFACE]
    assert 2.0 < surfacing[0] - 25.0 < 8.0
    assert z[-1] < 1.0
    assert np.min(np.interp(log.truth["eta.x"], *zip(*RISING, strict=True)) - z) > 3.0
    assert {cycle.mode.cause for cycle in log.cycles if cycle.mode.mode is Mode.SURFACE} == {Cause.TERRAIN_LOST}


@pytest.mark.parametrize(
    "faults",
    [("freeze:pressure@0",), ("set:pressure=0.6@2", "noise:pressure=0.02@2.2")],
    ids=["frozen", "blocked"],
)
def test_a_pressure_that_never_leaves_the_surface_takes_the_vehicle_nowhere(
    tmp_path: Path, faults: tuple[str, ...]
) -> None:
    log = course(tmp_path, SHALLOW, *faults)
    assert suspect_at(log, "pressure") < 40.0
    assert log.truth["eta.z"].max() < 3.5
    assert log.truth["eta.z"][-1] < 1.5
    assert {cycle.state.sensors.dvl.fault for cycle in log.cycles} <= {SourceFault.NONE, SourceFault.UNDECIDED}


@pytest.mark.parametrize(
    "faults",
    [("freeze:altimeter@0",), ("set:altimeter=28@10", "noise:altimeter=0.05@10.1")],
    ids=["frozen", "stuck"],
)
def test_an_altimeter_that_is_stuck_condemns_no_sound_dvl_over_a_ridge(tmp_path: Path, faults: tuple[str, ...]) -> None:
    log = course(tmp_path, RIDGE, *faults)
    assert {cycle.state.sensors.dvl.fault for cycle in log.cycles} <= {SourceFault.NONE, SourceFault.UNDECIDED}
    assert suspect_at(log, "altitude") < 25.0
    assert log.truth["eta.z"].max() < 17.2


def test_a_dvl_that_is_frozen_at_the_surface_from_the_start_is_named_and_misleads_nobody(tmp_path: Path) -> None:
    text = under_way(45.0, 0.0, mission([(30.0, 3.0), (400.0, 8.0)])).replace("u_m_s = 1.8", "").replace("n_rpm", "# ")
    log = course(tmp_path, text, "freeze:dvl@0")
    t, faults = log.columns["t"], [cycle.state.sensors.dvl.fault for cycle in log.cycles]
    assert t[faults.index(SourceFault.FROZEN)] < 20.0
    assert set(states(log, "altitude")) == {SourceState.GOOD}
    off = np.abs(log.columns["state.nu.u"] - log.truth["nu.u"])
    assert off[t > 25.0].max() < 0.3


@pytest.mark.parametrize(
    ("slope", "faults"),
    [(0.0556, ("drift:pressure=-0.1@43",)), (0.1667, ("off:dvl@5", "drift:pressure=-0.3@43"))],
    ids=["DVL", "no DVL"],
)
def test_a_pressure_that_drifts_as_the_bottom_falls_takes_the_vehicle_no_3_m_below_its_limit(
    tmp_path: Path, slope: float, faults: tuple[str, ...]
) -> None:
    """Altitude and pressure then tell the same depth of the bottom as before, and DVL and pitch seem to be wrong."""
    places = ((-50, 40.0), (76, 40.0), (576, 40.0 + 500.0 * slope))
    falls = ", ".join(f"{{north_m = {x}, depth_m = {z}}}" for x, z in places)
    water = f"bottom_depth_m = 40.0\nbottom = [{falls}]"
    limit = "[autopilot.safety]\ndepth_max_m = 30.0\n"
    text = under_way(110.0, 28.0, limit, hold(28.0)).replace("bottom_depth_m = 40.0", water)
    log = course(tmp_path, text, *faults)
    z = log.truth["eta.z"]
    assert z.max() < 33.0
    assert z[-1] < 24.0  # it comes up
    assert SourceState.SUSPECT in set(states(log, "pressure"))


@pytest.mark.parametrize(("other", "only"), [("dvl", "altimeter"), ("altimeter", "dvl.altitude")])
def test_the_only_altitude_that_is_stuck_takes_a_dive_by_altitude_not_to_the_bottom(
    tmp_path: Path, other: str, only: str
) -> None:
    places = [(40.0, 12.0), (300.0, 5.0)]
    waypoints = mission(places).replace("depth_m", "altitude_m")
    text = under_way(110.0, 13.0, waypoints, bottom=25.0)
    log = course(tmp_path, text, f"off:{other}@5", f"set:{only}=9@35", f"noise:{only}=0.05@35.2")
    z = log.truth["eta.z"]
    assert z.max() < 23.5
    assert z[-1] < 21.0
    sensor = "dvl" if other == "altimeter" else "altitude"
    assert SourceFault.UNDECIDED in {getattr(cycle.state.sensors, sensor).fault for cycle in log.cycles}


def test_a_slope_that_is_followed_by_one_altitude_alone_is_believed(tmp_path: Path) -> None:
    waypoints = mission([(400.0, 8.0)]).replace("depth_m", "altitude_m")
    slope = "bottom_depth_m = 20.0\nbottom = [{north_m = 60, depth_m = 20}, {north_m = 200, depth_m = 35}]"
    text = under_way(110.0, 12.0, waypoints, bottom=20.0).replace("bottom_depth_m = 20.0", slope)
    log = course(tmp_path, text, "off:dvl@5")
    assert log.truth["eta.z"].max() > 20.0
    assert set(states(log, "altitude")) == {SourceState.GOOD}


def test_the_depth_is_as_unsure_as_what_contradicts_the_pressure(tmp_path: Path) -> None:
    """A DVL that creeps on makes it 7 m deeper, the safer reading; it said 0.3 m of that, and 0.03 m at first."""
    place = tmp_path / "dive.toml"
    course = mission([(45.0, 6.0), (85.0, 10.0), (175.0, 28.0), (400.0, 28.0)])
    place.write_text(under_way(95.0, 4.0, course, current=(-0.8, 0.1), learning=True))
    request = FlightRequest(scenario=str(place), faults=("drift:dvl.u=0.02@30",), seed=20)
    fly(prepare(request, {}), tmp_path / "log.mcap")
    log = read(tmp_path / "log.mcap")
    error = np.abs(log.columns["state.eta.z"] - log.truth["eta.z"])
    assert SourceFault.UNDECIDED in {cycle.state.sensors.pressure.fault for cycle in log.cycles}
    assert error.max() > 3.0
    assert np.all(error < np.maximum(0.15, 3.0 * log.columns["state.depth_std"]))
