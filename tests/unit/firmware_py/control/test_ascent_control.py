"""SURFACE in the control: a pitch is held, with attitude and without; astern and at rest."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from firmware_py.control.control import Control, ControlParams
from firmware_py.marine import Eta, Nu
from firmware_py.records.command import AscentStage, Demand, ModeState
from firmware_py.records.order import NO_ORDER, Mode
from firmware_py.vehicle.linear_models import diving_model

from .test_control import LIMIT, REFERENCE, VEHICLE, state, tick

UP = math.radians(12.0)
STILL = (AscentStage.REVERSE, AscentStage.STOPPED)


def surface(stage: AscentStage, pitch: float = UP) -> ModeState:
    return ModeState(Mode.SURFACE, False, 0, ascent=stage, pitch=pitch)


def demand(stage: AscentStage, attitude_ok: bool = True, **at: float) -> Demand:
    control = Control(ControlParams(), VEHICLE)
    return control.update(tick(0), surface(stage), NO_ORDER, REFERENCE, replace(state(**at), attitude_ok=attitude_ok))


def test_astern_the_propeller_turns_backwards_and_the_planes_oppose() -> None:
    astern = demand(AscentStage.REVERSE, theta=-0.6)
    assert astern.n == pytest.approx(-700.0 / 60.0)
    assert astern.delta_s == -LIMIT
    assert astern.delta_r == 0.0
    assert demand(AscentStage.REVERSE, theta=-0.6, u=-0.1).delta_s == 0.0  # going astern they would do the contrary


def test_at_rest_the_propeller_stops() -> None:
    assert demand(AscentStage.STOPPED, theta=-0.6).n == 0.0
    assert demand(AscentStage.STOPPED, theta=-0.6).delta_s == -LIMIT


@pytest.mark.parametrize("stage", [AscentStage.POWERED, AscentStage.LEVEL, AscentStage.WAITING])
def test_under_power_pitch_and_heading_are_held(stage: AscentStage) -> None:
    assert demand(stage, theta=0.0).delta_s < 0.0 < demand(stage, theta=0.5).delta_s
    assert demand(stage, theta=UP, psi=0.05).delta_r > 0.0
    assert demand(stage).n > 0.0


@pytest.mark.parametrize("u", [0.8, 1.5, 2.5])
def test_the_pitch_law_brings_the_diving_model_to_the_desired_pitch(u: float) -> None:
    control, dt = Control(ControlParams(), VEHICLE), 0.01
    model, theta, q, highest = diving_model(VEHICLE, u), -0.2, 0.0, 0.0
    for k in range(4000):
        answer = control.update(
            tick(k), surface(AscentStage.POWERED, 0.1), NO_ORDER, REFERENCE, state(theta=theta, q=q, u=u)
        )
        q += dt * (model.A[0][0] * q + model.A[0][1] * theta + model.b[0] * answer.delta_s)
        theta += dt * q
        highest = max(highest, theta)
    assert theta == pytest.approx(0.1, abs=0.01)
    assert highest < 0.15


def test_without_attitude_the_planes_are_fixed_and_the_rudder_is_centred() -> None:
    fixed = demand(AscentStage.BLIND, attitude_ok=False, psi=1.0, theta=-1.0)
    assert fixed.delta_s == pytest.approx(-math.radians(5.0))
    assert fixed.delta_r == 0.0
    assert fixed.n > 0.0
    for stage in STILL:
        assert demand(stage, attitude_ok=False, theta=-1.0).delta_s == 0.0


@pytest.mark.parametrize(("theta", "more"), [(-0.2, True), (0.5, False)])
def test_without_attitude_velocities_tell_of_the_pitch(theta: float, more: bool) -> None:
    control, z, u, dt = Control(ControlParams(), VEHICLE), 20.0, 1.5, 0.01
    for k in range(500):
        z -= dt * u * math.sin(theta)
        seen = replace(state(), eta=Eta(0, 0, z, 0, 0.9, 0), nu=Nu(u, 0, 0, 0, 0, 0), attitude_ok=False)
        answer = control.update(tick(k), surface(AscentStage.BLIND), NO_ORDER, REFERENCE, seen)
    expected = -math.radians(5.0) - 0.5 * (UP - theta)
    assert answer.delta_s == pytest.approx(max(-math.radians(12.0), min(expected, 0.0)), abs=0.01)
    assert (answer.delta_s < -math.radians(5.0)) is more


def test_what_the_pitch_law_remembers_is_frozen_and_thawed() -> None:
    first, second = Control(ControlParams(), VEHICLE), Control(ControlParams(), VEHICLE)
    at = state(theta=0.1, u=1.5)
    for k in range(200):
        first.update(tick(k), surface(AscentStage.POWERED), NO_ORDER, REFERENCE, at)
    second.thaw(first.freeze())
    answers = [c.update(tick(200), surface(AscentStage.POWERED), NO_ORDER, REFERENCE, at) for c in (first, second)]
    assert answers[0] == answers[1]
    assert first.freeze() == second.freeze()
