"""What a person is told of a vehicle file that the simulated vehicle does not match."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from sternplane.sitl import plausibility
from sternplane.sitl.flight import CONFIG, SCENARIOS, FlightRequest, prepare

from firmware_py import config_files
from firmware_py.marine import Origin
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans.items import UNLIMITED, PlanItem
from firmware_py.mavlink.plans.plan_builder import FENCE, FILES, PlanBuilder
from firmware_py.params import ParamError
from sim_bridge.scenarios import known


def test_actuators_that_the_simulated_vehicle_does_not_have_are_named_with_both_files() -> None:
    flight = prepare(FlightRequest(), {})
    assert flight.doubts == ()
    slow = replace(flight.truth, servo=replace(flight.truth.servo, limit=0.2, rate=0.1))
    weak = replace(slow, shaft=replace(slow.shaft, limit=10.0))
    vehicle = config_files.vehicle(flight.configuration)
    said = tuple(plausibility.doubts(vehicle, weak, "v.toml", "t.toml"))
    assert len(said) == 2 * len(vehicle.fins) + 1
    assert said[0] == "v.toml: fins[0]: delta_max_deg = 23, but servo.limit_deg = 11.4592 in t.toml"
    assert said[1] == "v.toml: fins[0]: rate_max_deg_s = 60, but servo.rate_deg_s = 5.72958 in t.toml"
    assert said[-1] == "v.toml: propeller.n_max_rpm = 1000, but shaft.limit_rpm = 600 in t.toml"


def test_limits_that_stations_have_sent_do_not_refuse_the_mission_of_the_next_start(tmp_path: Path) -> None:
    (tmp_path / "parameters.toml").write_text("[safety]\ndepth_max_m = 3.0\n")
    origin = prepare(FlightRequest(), {}).params.origin
    fence = PlanBuilder(FENCE, WaterFrame(Origin(origin.latitude, origin.longitude), 0.0), UNLIMITED)
    x, y = round(math.degrees(origin.latitude) * 1e7), round(math.degrees(origin.longitude) * 1e7)
    fence.add(PlanItem(mavlink.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION, 0, 1, 5000.0, 0.0, 0.0, 0.0, x, y, 0.0))
    (tmp_path / FILES[FENCE]).write_bytes(fence.file_content)
    flight = prepare(FlightRequest(state=tmp_path), {})
    assert flight.params.safety.depth_max == 3.0
    assert len(flight.configuration["fence"]["without"]) == 1


def test_a_mission_beyond_the_limits_of_the_files_is_refused(tmp_path: Path) -> None:
    brief = 'description = "Too deep."\nduration_s = 60.0\ncompletes = "time"\n'
    place = "x_m = 100.0\ny_m = 0.0\nspeed_m_s = 1.5\ndepth_m = 900.0\n"
    (tmp_path / "deep.toml").write_text(f"{brief}[[waypoints]]\n{place}")
    with pytest.raises(ParamError, match=r"deep.toml: waypoints\[0\]: depth 900.0 m is over safety.depth_max_m = 30"):
        prepare(FlightRequest(scenario=str(tmp_path / "deep.toml")), {})


SHALLOW = 'description = "x"\nduration_s = 60.0\ncompletes = "time"\n[environment]\nbottom_depth_m = {}\n'
ORDER = "[[orders]]\nt_s = 1.0\ndepth_m = {}\n"
POINT = "[[waypoints]]\nx_m = {}\ny_m = 0.0\nspeed_m_s = {}\ndepth_m = {}\n"


def doubts_of(folder: Path, text: str) -> tuple[str, ...]:
    path = folder / "mine.toml"
    path.write_text(text)
    found = prepare(FlightRequest(scenario=str(path)), {}).doubts
    return tuple(doubt.replace(f"{folder}/", "") for doubt in found)


def test_a_speed_that_the_planes_cannot_hold_is_refused_before_the_flight(tmp_path: Path) -> None:
    with pytest.raises(ParamError, match=r"mine.toml: waypoints\[1\]: speed_m_s = 0.3 is under 0.48 m/s"):
        doubts_of(tmp_path, SHALLOW.format(40.0) + POINT.format(100.0, 1.5, 5.0) + POINT.format(200.0, 0.3, 5.0))


def test_depths_beyond_the_limit_and_the_dvls_range_are_told_with_both_files(tmp_path: Path) -> None:
    early = 'faults = ["lost:station@0", "lost:station@5"]\n'
    assert doubts_of(tmp_path, early + SHALLOW.format(40.0)) == (
        "fault lost:station@0: no station was heard before: no rule tells of it, and no order comes through",
    )
    order, blind = doubts_of(tmp_path, SHALLOW.format(100.0) + ORDER.format(10.0) + ORDER.format(60.0))
    assert order == "mine.toml: orders[1]: depth_m = 60 is over safety.depth_max_m = 30: depth_max_action follows there"
    assert blind.startswith("mine.toml: orders[0]: no bottom lock: the bottom is 100 m deep, 90 m below the vehicle")
    assert "dvl.range_max_m = 50 in " in blind
    assert "npsauv2/sensors.toml" in blind


def test_the_bottom_counts_along_the_legs_of_a_mission(tmp_path: Path) -> None:
    trench = "bottom = [{north_m = 0, depth_m = 40}, {north_m = 60, depth_m = 90}, {north_m = 120, depth_m = 40}]\n"
    legs = [POINT.format(x, 1.5, 5.0) for x in (-50.0, 200.0, 400.0)]
    (blind,) = doubts_of(tmp_path, SHALLOW.format(40.0) + trench + "".join(legs))
    assert blind.startswith("mine.toml: waypoints[1]: no bottom lock: the bottom is 90 m deep, 85 m below")
    assert doubts_of(tmp_path, SHALLOW.format(40.0) + trench + legs[0]) == ()
    many = "".join(POINT.format(100.0 + x, 1.5, 5.0) for x in range(6))
    (blind,) = doubts_of(tmp_path, SHALLOW.format(60.0) + many)
    assert "waypoints[0], waypoints[1], waypoints[2], waypoints[3] and 2 more: no bottom lock" in blind


@pytest.mark.parametrize(
    ("bottom", "altitude", "unlocked", "unheard"),
    [
        (70.0, 45.0, False, False),
        (70.0, 55.0, True, False),  # the altimeter hears as far as 60 m
        (95.0, 45.0, True, True),  # the vehicle goes no deeper than 30 m
        (90.0, 70.0, True, True),
        (55.0, 70.0, True, False),  # from the surface
        (45.0, 70.0, False, False),
    ],
)
def test_altitudes_are_compared_with_what_dvl_and_altimeter_hear(
    tmp_path: Path, bottom: float, altitude: float, unlocked: bool, unheard: bool
) -> None:
    place = f"[[waypoints]]\nx_m = 100.0\ny_m = 0.0\nspeed_m_s = 1.5\naltitude_m = {altitude}\n"
    said = doubts_of(tmp_path, SHALLOW.format(bottom) + place)
    assert [one.startswith("mine.toml: waypoints[0]: no bottom lock") for one in said if "no bottom" in one] == [
        True
    ] * unlocked
    assert [one for one in said if "no bottom" not in one] == [
        one for one in said if one.startswith(f"mine.toml: waypoints[0]: altitude_m = {altitude:g}: no sensor hears")
    ]
    assert len(said) == unlocked + unheard
    assert all("altimeter.range_max_m = 60, dvl.range_max_m = 50 in " in one for one in said if "no sensor" in one)


@pytest.mark.parametrize("name", known(SCENARIOS))
def test_the_scenarios_that_come_with_it_give_rise_to_no_doubt(name: str) -> None:
    config = CONFIG.with_name("remus100") if "remus100" in name else CONFIG
    assert prepare(FlightRequest(scenario=name, config=config), {}).doubts == ()
