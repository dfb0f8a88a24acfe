"""SURFACE in the control: a pitch is held, with attitude and without; astern and at rest."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from firmware_py.control.ascent import settles, settling_bandwidth, steady_pitch
from firmware_py.control.control import Control, ControlParams
from firmware_py.marine import Eta, Nu
from firmware_py.params import ParamError
from firmware_py.records.command import AscentStage, Demand, ModeState
from firmware_py.records.order import NO_ORDER, Mode
from firmware_py.vehicle.linear_models import diving_coefficients, diving_model
from firmware_py.vehicle.turning import heaved_axis, pitch_axis
from firmware_py.vehicle.vehicle import Vehicle

from .test_control import LIMIT, REFERENCE, VEHICLE, state, tick

UP = math.radians(12.0)
REMUS = config_files.vehicle(config_files.read_configuration(configs() / "remus100"))
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


PITCHING = 0.71 * -steady_pitch(VEHICLE) * REFERENCE.u_d**2
"""Pitch up by planes up."""


def test_without_attitude_the_planes_are_fixed_and_the_rudder_is_centred() -> None:
    fixed = demand(AscentStage.BLIND, attitude_ok=False, psi=1.0, theta=-1.0)
    assert fixed.delta_s == pytest.approx(-UP / PITCHING)
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
    expected = -(UP + 1.2 * (UP - theta)) / PITCHING
    assert answer.delta_s == pytest.approx(max(-math.radians(29.0) / PITCHING, min(expected, 0.0)), abs=0.01)
    assert (answer.delta_s < -UP / PITCHING) is more


def test_without_attitude_the_planes_are_turned_from_where_the_hull_was_level() -> None:
    """REMUS 100, which is lighter than water, is level at -1.4 deg: without this it did not come up."""
    control, trim = Control(ControlParams(), VEHICLE), 0.0
    at, hold = state(theta=-0.02, u=REFERENCE.u_d), ModeState(Mode.HOLD, False, 0)
    for k in range(12000):
        delta_s = control.update(tick(k), hold, NO_ORDER, replace(REFERENCE, z_d=at.eta.z + 0.1), at).delta_s
        trim += (delta_s + at.eta.theta / -PITCHING - trim) * 0.01 / 20.0
    blind = replace(at, attitude_ok=False, velocity_ok=False)
    fixed = control.update(tick(12000), surface(AscentStage.BLIND), NO_ORDER, REFERENCE, blind).delta_s
    assert abs(trim) > 0.01
    assert fixed == pytest.approx(min(max(trim, -math.radians(3.0)), math.radians(3.0)) - UP / PITCHING, abs=1e-3)


@pytest.mark.parametrize(("vehicle", "u", "told"), [(VEHICLE, 1.3, 2.5), (VEHICLE, 1.5, 3.4), (REMUS, 1.3, 7.0)])
def test_the_pitch_of_steady_planes_is_where_pitch_and_heave_rest(vehicle: Vehicle, u: float, told: float) -> None:
    pitch, ((heave_w, _, heave_s), _) = pitch_axis(vehicle), heaved_axis(vehicle)
    theta = steady_pitch(vehicle) * u * u
    w = -heave_s * u / heave_w
    assert pitch.crosswise * u * w + pitch.restoring * theta + pitch.control * u * u == pytest.approx(0.0, abs=1e-9)
    assert -theta == pytest.approx(told, abs=0.1)


@pytest.mark.parametrize(
    ("part", "change", "named"), [("coefficients", {"Z_w": 0.0}, "Z_w"), ("body", {"z_G": 0.0, "z_B": 0.0}, "z_G")]
)
def test_a_hull_that_holds_no_steady_pitch_is_refused_by_name(part: str, change: dict[str, object], named: str) -> None:
    hull = replace(VEHICLE, **{part: replace(getattr(VEHICLE, part), **change)})
    with pytest.raises(ParamError, match=named):
        steady_pitch(hull)


def test_what_the_pitch_law_remembers_is_frozen_and_thawed() -> None:
    first, second = Control(ControlParams(), VEHICLE), Control(ControlParams(), VEHICLE)
    at = state(theta=0.1, u=1.5)
    for k in range(200):
        first.update(tick(k), surface(AscentStage.POWERED), NO_ORDER, REFERENCE, at)
    second.thaw(first.freeze())
    answers = [c.update(tick(200), surface(AscentStage.POWERED), NO_ORDER, REFERENCE, at) for c in (first, second)]
    assert answers[0] == answers[1]
    assert first.freeze() == second.freeze()


def poles(bandwidth: float, vehicle: Vehicle, u: float) -> list[complex]:
    """Return the poles of heave, pitch rate and pitch, Eq. 26 and the heave of Eq. 1, under the law."""
    pitch, ((heave_w, heave_q, heave_s), _) = pitch_axis(vehicle), heaved_axis(vehicle)
    hull = np.array(
        [
            [heave_w * u, heave_q * u, 0.0],
            [pitch.crosswise * u, pitch.damping * u, pitch.restoring],
            [0.0, 1.0, 0.0],
        ]
    )
    fin = np.array([heave_s, pitch.control, 0.0]) * u * u
    rate, angle = 2.0 * bandwidth + pitch.damping * u, bandwidth**2 + pitch.restoring
    law = np.array([0.0, -rate, -angle]) / (pitch.control * u * u)
    return list(np.linalg.eigvals(hull + np.outer(fin, law)))


@pytest.mark.parametrize("vehicle", [VEHICLE, REMUS], ids=["npsauv2", "remus100"])
@pytest.mark.parametrize("bandwidth", [0.3, 0.6, 0.9, 1.2, 1.5, 2.0, 3.0])
def test_what_settles_is_told_by_the_poles_of_pitch_and_heave(vehicle: Vehicle, bandwidth: float) -> None:
    for u in (0.5, 1.0, 1.5, 2.0):
        slowest = max(pole.real for pole in poles(bandwidth, vehicle, u))
        assert settles(bandwidth, vehicle, diving_coefficients(vehicle), u) == (slowest < -0.2 * bandwidth)


def test_a_hull_that_its_heave_turns_further_gets_a_quicker_law_and_another_the_one_asked_for() -> None:
    """REMUS 100 dived in SURFACE: with 0.6 1/s its pitch grew."""
    u = REMUS.propeller.u_trim
    assert max(pole.real for pole in poles(0.6, REMUS, u)) > 0.3
    quick = settling_bandwidth(0.6, REMUS, diving_coefficients(REMUS))
    assert 1.2 < quick < 1.6
    assert max(pole.real for pole in poles(quick, REMUS, u)) < -0.2
    assert settling_bandwidth(0.6, VEHICLE, diving_coefficients(VEHICLE)) == 0.6
    assert settling_bandwidth(2.0, REMUS, diving_coefficients(REMUS)) == 2.0
