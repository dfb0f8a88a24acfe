"""The point that is flown to: whose word it is, and for how long it holds."""

from __future__ import annotations

import dataclasses
import math

import pytest

from firmware_py.marine import Eta
from firmware_py.mavlink.commands.setpoints import WaterFrame
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.mavlink.telemetry.navigation_target import NavigationTarget
from firmware_py.records.cycle import Cycle
from firmware_py.records.fence import Place
from firmware_py.records.order import KEEP_SETPOINT, NO_ORDER, Mode, Order, Setpoint, Surface, Waypoint

from .station import ORIGIN, cycle, node, parse

NAN = math.nan
NORTH, FAR = Place(0.0, 30.0), Place(900.0, 0.0)


def at(x: float, y: float, mode: Mode, setpoint: Setpoint = KEEP_SETPOINT, item: int = 0, across: float = NAN) -> Cycle:
    order = NO_ORDER if setpoint is KEEP_SETPOINT else Order(setpoint=setpoint)
    found = cycle(mode=mode, order=order, eta=Eta(x, y, 5.0, 0.0, 0.0, 0.0))
    return dataclasses.replace(found, reference=dataclasses.replace(found.reference, item=item, cross_track=across))


def aiming(*steps, rally: tuple[Place, ...] = ()) -> NavigationTarget:
    chart = PlanStore(WaterFrame(ORIGIN, 0.0))
    chart.steps, chart.rally = steps, rally
    return NavigationTarget(chart)


def shown(target: NavigationTarget, now: Cycle) -> tuple[float, float]:
    """Distance, m, and bearing, deg."""
    target.update(now)
    vector = target.vector(now)
    return vector.distance, math.degrees(vector.bearing)


def test_a_place_holds_until_another_a_heading_or_a_mode_is_ordered() -> None:
    target, place = aiming(), Setpoint(NAN, NAN, NAN, 30.0, 40.0)
    assert shown(target, at(0, 0, Mode.HOLD, place)) == (0.0, 0.0)
    assert shown(target, at(0, 0, Mode.GUIDED, place)) == pytest.approx((50.0, 53.13), abs=0.01)
    assert shown(target, at(0, 40, Mode.GUIDED, Setpoint(8.0, NAN, 1.0))) == pytest.approx(
        (30.0, 0.0)
    )  # deeper, slower
    assert shown(target, at(0, 0, Mode.GUIDED, Setpoint(NAN, NAN, NAN, 0.0, -7.0))) == pytest.approx((7.0, -90.0))
    assert shown(target, at(0, 0, Mode.GUIDED, Setpoint(NAN, 1.0, NAN))) == (0.0, 0.0)
    shown(target, at(0, 0, Mode.GUIDED, place))
    shown(target, at(0, 0, Mode.LOITER))
    assert shown(target, at(0, 0, Mode.GUIDED, across=-4.0)) == (4.0, 0.0)  # around where it was


def test_of_a_mission_it_is_the_item_that_it_has_come_to() -> None:
    target = aiming(Waypoint(10.0, 0.0, 5.0, 0.0), Waypoint(0.0, 20.0, 5.0, 0.0), Surface())
    for item, distance in ((0, 10.0), (1, 20.0), (2, 0.0), (3, 0.0), (-1, 0.0)):
        assert shown(target, at(0, 0, Mode.MISSION, item=item))[0] == pytest.approx(distance)
    assert shown(target, at(0, 0, Mode.HOLD, item=1))[0] == 0.0


def test_the_way_back_goes_to_the_point_that_was_the_nearest_when_it_began() -> None:
    for mode in (Mode.RETURN, Mode.SURFACE):
        target = aiming(rally=(FAR, NORTH))
        assert shown(target, at(NAN, NAN, mode)) == (0.0, 0.0)
        assert shown(target, at(0, 0, mode)) == pytest.approx((30.0, 90.0))
        assert shown(target, at(880, 0, mode))[0] == pytest.approx(math.hypot(880, 30))
        shown(target, at(880, 0, Mode.HOLD))
        assert shown(target, at(880, 0, mode))[0] == pytest.approx(20.0)
        assert shown(aiming(), at(0, 0, mode)) == (0.0, 0.0)


def test_a_mission_that_returns_keeps_its_point_while_others_have_the_word() -> None:
    target = aiming(Surface(rally=True), rally=(FAR, NORTH))
    assert shown(target, at(0, 0, Mode.MISSION))[0] == pytest.approx(30.0)
    shown(target, at(880, 0, Mode.LOITER))
    assert shown(target, at(880, 0, Mode.MISSION))[0] == pytest.approx(math.hypot(880, 30))
    shown(target, at(880, 0, Mode.DISARMED))
    assert shown(target, at(880, 0, Mode.MISSION))[0] == pytest.approx(20.0)


@pytest.mark.parametrize(("x", "distance"), [(1e7, 65534), (NAN, 0), (-3.0, 3)])
def test_what_a_field_cannot_say_stays_within_it(x: float, distance: int) -> None:
    boat, place = node(), Setpoint(NAN, NAN, NAN, 0.0, 0.0)
    said = [
        message
        for k in range(100)
        for message in parse(boat.report(dataclasses.replace(at(x, 0, Mode.GUIDED, place), tick=cycle(k).tick))[0])
    ]
    assert {m.wp_dist for m in said if m.get_type() == "NAV_CONTROLLER_OUTPUT"} == {distance}
