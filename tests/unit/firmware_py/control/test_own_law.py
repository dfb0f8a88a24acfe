"""A law of one's own: its angles are limited like any, what is not finite ends it, and SURFACE is never its own."""

from __future__ import annotations

import dataclasses
import math

import pytest

from firmware_py.control.control import Control, ControlParams
from firmware_py.control.own_law import Law, Steering
from firmware_py.own_part import Guard, NoParams, OwnClass
from firmware_py.part_name import PartName
from firmware_py.records.command import Demand, ModeState
from firmware_py.records.order import NO_ORDER, Mode
from tests.unit.firmware_py.control.test_control import LIMIT, REFERENCE, VEHICLE, hold, mode, state, tick

OWN = ControlParams(law=PartName("mine"))


class Told(Law):
    """Says what the test says."""

    says: object = (0.0, 0.0)
    asked = 0

    def update(self, tick, reference, state):
        Told.asked += 1
        if isinstance(Told.says, Exception):
            raise Told.says
        return Told.says


@pytest.fixture
def control() -> Control:
    Told.says, Told.asked = (0.0, 0.0), 0
    return Control(OWN, VEHICLE, Guard("law", OwnClass("mine", Told, NoParams()), VEHICLE))


def test_its_angles_are_limited_faded_at_low_speed_and_given_the_excitation(control: Control) -> None:
    Told.says = (0.1, -0.05)
    assert (hold(control, state()).delta_s, hold(control, state(), k=1).delta_r) == (0.1, -0.05)
    Told.says = (9.0, -9.0)
    demand = hold(control, state(), k=3)
    assert (demand.delta_s, demand.delta_r) == pytest.approx((LIMIT, -LIMIT))
    Told.says = (0.1, 0.1)
    assert hold(control, state(u=0.25), k=4).delta_s == pytest.approx(0.05)
    excited = dataclasses.replace(REFERENCE, delta_s=0.02, grip=0.5)
    assert hold(control, state(), excited, k=5).delta_s == pytest.approx(0.07)


def test_without_a_propeller_of_its_own_the_built_in_speed_control_has_it(control: Control) -> None:
    built_in = hold(Control(ControlParams(), VEHICLE), state(u=1.5))
    Told.says = (0.0, 0.0)
    assert hold(control, state(u=1.5)).n == built_in.n
    Told.says = Steering(0.0, 0.0, 1e9, sigma_z=0.3)
    demand = hold(control, state(u=1.5), k=1)
    assert (demand.n, demand.sigma_z) == (VEHICLE.propeller.n_max, 0.3)


@pytest.mark.parametrize(
    "wrong",
    [
        (math.nan, 0.0),
        (0.0, math.inf),
        (0.1,),
        None,
        ("left", 0.0),
        Steering(0.0, 0.0, math.nan),
        ZeroDivisionError("x"),
    ],
    ids=str,
)
def test_a_wrong_answer_ends_it_and_the_sliding_mode_law_goes_on_at_once(control: Control, wrong: object) -> None:
    off = state(z=9.5, psi=0.1)
    hold(control, off)
    Told.says = wrong
    demand = hold(control, off, k=1)
    (event,) = control.told()
    assert event.names[:2] == ("law", "mine")
    sliding = Control(ControlParams(), VEHICLE)
    expected: Demand = hold(sliding, off, k=1)
    assert (demand.delta_s, demand.delta_r) == pytest.approx((expected.delta_s, expected.delta_r), abs=0.02)
    assert demand.delta_s > 0.0 < demand.delta_r
    Told.says = (0.0, 0.0)
    assert hold(control, off, k=2).delta_s > 0.0
    assert control.told() == ()
    control.update(tick(3), mode(Mode.DISARMED), NO_ORDER, REFERENCE, off)
    assert hold(control, off, k=4).delta_s == 0.0


def test_coming_up_and_the_sticks_are_never_its_own(control: Control) -> None:
    for k, which in enumerate((Mode.SURFACE, Mode.MANUAL, Mode.DISARMED)):
        control.update(tick(k), ModeState(which, False, 0), NO_ORDER, REFERENCE, state())
    assert Told.asked == 0
    hold(control, state(x=math.nan), k=3)
    assert Told.asked == 1  # its place does not matter to a law
    hold(control, state(theta=math.nan), k=4)
    assert Told.asked == 1
