"""The place that is flown to, and how far it is: whose word it is, and for how long it holds."""

from __future__ import annotations

import math

import pytest

from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.marine import Eta, Nu
from firmware_py.records.command import ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.fence import Place
from firmware_py.records.mission import Mission, Surface, Waypoint
from firmware_py.records.order import KEEP_SETPOINT, Mode, Order, Setpoint
from firmware_py.tick import Tick

NAN = math.nan
NORTH, FAR = Place(0.0, 300.0), Place(900.0, 0.0)


class Flight:
    """A vehicle that is put where a test wants it."""

    def __init__(self, *items: Waypoint | Surface, rally: tuple[Place, ...] = ()) -> None:
        self.guidance = Guidance(GuidanceParams(), Mission(items), rally=rally)
        self.k = 0

    def at(self, x: float, y: float, mode: Mode, setpoint: Setpoint = KEEP_SETPOINT, psi: float = 0.0) -> Reference:
        state = StateEstimate(
            Eta(x, y, 5, 0, 0, psi), Nu(1.8, 0, 0, 0, 0, 0), 1.0, 0.1, 0.01, 20.0, True, True, True, False
        )
        self.k += 1
        order = Order(setpoint=setpoint)
        return self.guidance.update(Tick(self.k, 10_000_000), ModeState(mode, False, 0), order, state)


def shown(reference: Reference) -> tuple[float, float]:
    """Distance, m, and bearing, deg."""
    return reference.target_distance, math.degrees(reference.target_bearing)


def known(place: Place) -> bool:
    return math.isfinite(place.x + place.y)


def test_a_place_holds_until_another_a_heading_or_a_mode_is_ordered() -> None:
    vehicle, place = Flight(), Setpoint(NAN, NAN, NAN, 30.0, 40.0)
    vehicle.at(0, 0, Mode.MANUAL)
    assert not known(vehicle.at(0, 0, Mode.HOLD, place).target)
    assert shown(vehicle.at(0, 0, Mode.GUIDED, place)) == pytest.approx((50.0, 53.13), abs=0.01)
    assert shown(vehicle.at(0, 40, Mode.GUIDED, Setpoint(8.0, NAN, 1.0))) == pytest.approx((30.0, 0.0))
    assert shown(vehicle.at(0, 0, Mode.GUIDED, Setpoint(NAN, NAN, NAN, 0.0, -7.0))) == pytest.approx((7.0, -90.0))
    assert not known(vehicle.at(0, 0, Mode.GUIDED, Setpoint(NAN, 1.0, NAN)).target)
    vehicle.at(0, 0, Mode.GUIDED, place)
    vehicle.at(0, 0, Mode.LOITER)
    around = vehicle.at(0, 0, Mode.GUIDED)  # around where it was
    assert not known(around.target)
    assert around.target_distance == abs(around.cross_track)


def test_of_a_mission_it_is_the_item_that_it_has_come_to() -> None:
    vehicle = Flight(Waypoint(100.0, 0.0, 5.0, 0.0), Waypoint(0.0, 200.0, 5.0, 0.0), Surface())
    vehicle.at(0, 0, Mode.MANUAL)
    assert vehicle.at(0, 0, Mode.MISSION).target == (100.0, 0.0)
    reference = vehicle.at(100, 0, Mode.MISSION)
    assert (reference.item, reference.target) == (1, (0.0, 200.0))
    assert reference.target_distance == pytest.approx(math.hypot(100, 200))
    assert not known(vehicle.at(0, 200, Mode.MISSION).target)
    assert not known(vehicle.at(0, 0, Mode.HOLD).target)


@pytest.mark.parametrize("mode", [Mode.RETURN, Mode.SURFACE])
def test_the_way_back_goes_to_the_point_that_was_the_nearest_when_it_began(mode: Mode) -> None:
    vehicle = Flight(rally=(FAR, NORTH))
    vehicle.at(0, 0, Mode.MANUAL)
    reference = vehicle.at(0, 0, mode)
    assert (reference.target, reference.rally) == (NORTH, NORTH)
    assert shown(reference) == pytest.approx((300.0, 90.0))
    assert vehicle.at(700, 0, mode).target == NORTH
    assert not known(vehicle.at(700, 0, Mode.HOLD).rally)
    assert vehicle.at(700, 0, mode).target == FAR
    lonely = Flight()
    lonely.at(0, 0, Mode.MANUAL)
    assert not known(lonely.at(0, 0, mode).rally)


def test_a_mission_that_returns_keeps_its_point_until_it_is_flown_again_from_elsewhere() -> None:
    vehicle = Flight(Surface(rally=True), rally=(FAR, NORTH))
    vehicle.at(0, 0, Mode.MANUAL)
    assert vehicle.at(0, 0, Mode.MISSION).rally == NORTH
    vehicle.at(700, 0, Mode.LOITER)
    assert vehicle.at(700, 0, Mode.MISSION).rally == NORTH
    vehicle.at(700, 0, Mode.DISARMED)
    assert vehicle.at(700, 0, Mode.MISSION).rally == FAR


def test_a_state_that_is_not_finite_leaves_the_target_as_it_was() -> None:
    vehicle = Flight(Waypoint(100.0, 0.0, 5.0, 0.0))
    vehicle.at(0, 0, Mode.MANUAL)
    before = vehicle.at(0, 0, Mode.MISSION)
    after = vehicle.at(NAN, 0, Mode.MISSION)
    assert (after.target, after.target_distance) == (before.target, before.target_distance)
