"""Every field that says how deep the vehicle is, in a lake and at sea."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.marine import Eta, Nu
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from tests.unit.firmware_py.mavlink.station import cycle, node, parse, told


@pytest.mark.parametrize(
    ("surface", "depth", "amsl"),
    [
        (0.0, 12.345, -12.345),
        (300.0, 12.345, 287.655),
        (300.0, 0.0, 300.0),
        (300.0, -0.25, 300.25),  # on the crane
        (-430.0, 10.0, -440.0),  # in the Dead Sea
    ],
)
def test_each_field_says_the_depth_in_its_own_way(surface: float, depth: float, amsl: float) -> None:
    said = told(surface, eta=Eta(0.0, 0.0, depth, 0.0, 0.0, 0.0), altitude=7.5)
    position = said["GLOBAL_POSITION_INT"]
    assert position.relative_alt == round(-depth * 1000)
    assert position.alt == round(amsl * 1000)
    assert said["LOCAL_POSITION_NED"].z == pytest.approx(depth, abs=1e-6)
    assert said["VFR_HUD"].alt == pytest.approx(amsl, abs=1e-4)
    altitude = said["ALTITUDE"]
    assert altitude.altitude_relative == pytest.approx(-depth, abs=1e-6)
    assert altitude.altitude_local == pytest.approx(-depth, abs=1e-6)
    assert altitude.altitude_amsl == pytest.approx(amsl, abs=1e-4)
    assert altitude.bottom_clearance == 7.5
    assert altitude.altitude_terrain == 7.5
    assert said["WATER_DEPTH"].distance == 7.5
    assert said["WATER_DEPTH"].alt == pytest.approx(amsl, abs=1e-4)
    assert said["ODOMETRY"].z == pytest.approx(depth, abs=1e-6)
    assert said["DISTANCE_SENSOR"].current_distance == 750
    assert said["HOME_POSITION"].altitude == round(surface * 1000)
    assert said["HOME_POSITION"].z == 0.0
    assert said["GPS_RAW_INT"].alt == round(surface * 1000)  # a fix is had at the surface


@pytest.mark.parametrize(("surface", "depth", "amsl"), [(0.0, 12.4, -12), (300.0, 12.4, 288), (300.0, 0.0, 300)])
def test_high_latency_says_the_altitude_and_the_depth(surface: float, depth: float, amsl: int) -> None:
    vehicle = node(surface, configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])
    (said,) = parse(vehicle.report(cycle(0, eta=Eta(0.0, 0.0, depth, 0.0, 0.0, 0.0)))[0])
    assert said.altitude == amsl
    assert (said.custom1 + 127 * said.custom2) / 10 == pytest.approx(depth)


@pytest.mark.parametrize(("theta", "w", "climb"), [(30.0, 0.0, 10), (-30.0, 0.0, -10), (0.0, 0.5, -5)])
def test_high_latency_says_a_climb_as_positive(theta: float, w: float, climb: int) -> None:
    vehicle = node(configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])
    eta, nu = Eta(0.0, 0.0, 5.0, 0.0, math.radians(theta), 0.0), Nu(2.0, 0.0, w, 0.0, 0.0, 0.0)
    (said,) = parse(vehicle.report(cycle(0, eta=eta, nu=nu))[0])
    assert said.climb_rate == climb  # 0.1 m/s


@settings(max_examples=25)
@given(st.floats(-2.0, 6000.0), st.floats(-400.0, 6000.0))
def test_home_is_at_the_surface_of_any_water(depth: float, surface: float) -> None:
    said = told(surface, eta=Eta(0.0, 0.0, depth, 0.0, 0.0, 0.0))
    position = said["GLOBAL_POSITION_INT"]
    assert abs(position.alt - position.relative_alt - surface * 1000) <= 1.0
    assert said["VFR_HUD"].alt - said["ALTITUDE"].altitude_relative == pytest.approx(surface, abs=1e-2)
    assert said["LOCAL_POSITION_NED"].z == -said["ALTITUDE"].altitude_relative


def test_a_dive_goes_down_in_every_frame() -> None:
    # Bow down by 30 deg at 2 m/s: 1 m/s deeper, 1.732 m/s ahead, which is east.
    said = told(eta=Eta(0.0, 0.0, 5.0, 0.0, math.radians(-30.0), math.radians(90.0)), nu=Nu(2.0, 0, 0, 0, 0, 0))
    local, position, hud = said["LOCAL_POSITION_NED"], said["GLOBAL_POSITION_INT"], said["VFR_HUD"]
    assert (local.vx, local.vy, local.vz) == pytest.approx((0.0, math.sqrt(3.0), 1.0), abs=1e-6)
    assert (position.vx, position.vy, position.vz) == (0, 173, 100)
    assert hud.climb == pytest.approx(-1.0)
    assert hud.groundspeed == pytest.approx(math.sqrt(3.0))


def test_a_bottom_that_is_not_seen_is_said_in_each_messages_own_words() -> None:
    said = told(altitude=math.nan)
    assert said["ALTITUDE"].bottom_clearance < 0.0
    assert said["ALTITUDE"].altitude_terrain < -1000.0
    assert said["WATER_DEPTH"].healthy == 0
    assert math.isnan(said["WATER_DEPTH"].distance)


def test_the_waters_pressure_is_the_second_one_in_hectopascal() -> None:
    said = told()
    assert said["SCALED_PRESSURE2"].press_abs == pytest.approx(1500.0)
    assert "SCALED_PRESSURE" not in said
