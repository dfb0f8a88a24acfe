"""Depth and heading laws, whole, on the linear models they are designed from."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from firmware_py.control.control import Control, ControlParams, LawKind
from firmware_py.control.sliding_mode_law import SlidingModeLaw
from firmware_py.control.sliding_mode_params import GainSet
from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.guidance.reference_model import Shape
from firmware_py.marine import Eta, Nu, wrap
from firmware_py.params import load
from firmware_py.records.command import ModeState
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.mission import Mission
from firmware_py.records.order import NO_ORDER, Mode, Order, Setpoint
from firmware_py.tick import Tick
from firmware_py.vehicle.linear_models import LinearModel, diving_model, steering_model
from firmware_py.vehicle.vehicle import Vehicle

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "npsauv2"
VEHICLE = load(Vehicle, tomllib.loads((CONFIG / "vehicle.toml").read_text()), "vehicle.toml")
HOLD = ModeState(Mode.HOLD, False, 0)
DISARMED = ModeState(Mode.DISARMED, False, 0)
DT_NS = 10_000_000
LIMIT = math.radians(23.0)
PAPER = ControlParams(gains=GainSet.PAPER)
OWN = ControlParams()
PID = ControlParams(law=LawKind.PID)
STEP = GuidanceParams(shape=Shape.STEP)
SMOOTH = GuidanceParams()


class LinearPlant:
    """Two linear models side by side, exact under a held input; the fins stop at their travel."""

    def __init__(
        self, u: float, depth: float = 10.0, bias: float = 0.0, current: float = 0.0, truth: Vehicle = VEHICLE
    ):
        self.u, self.bias, self.current = u, bias, current
        self.dive, self.turn = np.array([0.0, 0.0, depth]), np.zeros(3)
        self._dive, self._turn = _held(diving_model(truth, u)), _held(steering_model(truth, u))

    def step(self, delta_s: float, delta_r: float) -> None:
        for x, (Phi, gamma), delta in ((self.dive, self._dive, delta_s), (self.turn, self._turn, delta_r)):
            x[:] = Phi @ x + gamma * (min(max(delta, -LIMIT), LIMIT) + self.bias)

    @property
    def state(self) -> StateEstimate:
        (q, theta, z), (v, r, psi) = map(np.ndarray.tolist, (self.dive, self.turn))
        w = self.u * (math.sin(theta) - theta) / math.cos(theta)  # so that z_dot = -u theta, as the model has it
        eta, nu = Eta(0.0, 0.0, z, 0.0, theta, wrap(psi)), Nu(self.u, v + self.current, w, 0.0, q, r * math.cos(theta))
        return StateEstimate(eta, nu, 1.0, 0.1, 0.01, 50.0, True, True, True, False)


def _held(model: LinearModel) -> tuple[np.ndarray, np.ndarray]:
    block = np.zeros((4, 4))
    block[:3, :3], block[:3, 3] = model.A, model.b
    block *= DT_NS * 1e-9
    whole = np.eye(4) + block + block @ block / 2.0 + block @ block @ block / 6.0
    return whole[:3, :3], whole[:3, 3]


def fly(
    plant: LinearPlant, control: ControlParams, guidance: GuidanceParams, setpoint: Setpoint, seconds: float
) -> dict:
    """Holds for 2 s, then goes for the setpoint; the history from there on, one array per name."""
    law, guide = Control(control, VEHICLE), Guidance(guidance, Mission())
    rows = []
    guide.update(Tick(0, DT_NS), DISARMED, NO_ORDER, plant.state)
    for k in range(round(seconds * 100) + 200):
        state, tick = plant.state, Tick(k, DT_NS)
        reference = guide.update(tick, HOLD, Order(setpoint=setpoint) if k == 200 else NO_ORDER, state)
        demand = law.update(tick, HOLD, NO_ORDER, reference, state)
        plant.step(demand.delta_s, demand.delta_r)
        row = (state.eta.z, state.eta.psi, reference.z_d, reference.psi_d, demand.delta_s, demand.delta_r)
        rows.append((*row, demand.sigma_z, demand.sigma_psi))
    names = ("z", "psi", "z_d", "psi_d", "delta_s", "delta_r", "sigma_z", "sigma_psi")
    return dict(zip(names, np.array(rows[200:]).T, strict=True))


def settled(way: np.ndarray, share: float) -> float:
    """When a way from 0 to 1 last was off 1 by more than `share`, s."""
    return (np.nonzero(np.abs(way - 1.0) > share)[0][-1] + 1) * 0.01


def test_paper_gains_settle_a_metre_in_about_20_s_without_overshoot() -> None:
    way = fly(LinearPlant(1.832), PAPER, STEP, Setpoint(11.0, 0.0, 1.832), 50.0)["z"] - 10.0
    assert way.max() < 1.01
    assert 14.0 < settled(way, 0.05) < 24.0


def test_paper_gains_turn_without_overshoot() -> None:
    way = fly(LinearPlant(1.832), PAPER, STEP, Setpoint(10.0, 0.1, 1.832), 50.0)["psi"] / 0.1
    assert way.max() < 1.02
    assert 5.0 < settled(way, 0.05) < 20.0


@pytest.mark.parametrize("u", [0.6, 1.0, 1.8288, 3.5])
def test_own_gains_answer_a_small_step_over_the_same_way_at_every_speed(u: float) -> None:
    depth, heading = (dataclasses.replace(gains, integral_time=0.0) for gains in (OWN.depth, OWN.heading))
    control = dataclasses.replace(OWN, depth=depth, heading=heading)
    flown = fly(LinearPlant(u), control, STEP, Setpoint(10.02, 0.002, u), 80.0 / u)
    dive, turn = (flown["z"] - 10.0) / 0.02, flown["psi"] / 0.002
    assert dive.max() < 1.01
    assert turn.max() < 1.05
    lags = 1.0 / 0.9 + 1.0 / 0.4 + 1.0 / 0.45  # the area above a step response of those poles at the trim speed, s
    at_least = 0.607  # slower poles would have the planes hold against the righting moment
    assert np.sum(1.0 - dive) * 0.01 * max(u / 1.8288, at_least) == pytest.approx(lags, rel=0.02)
    # The rudder's side force puts a zero at 0.317 u / 1.8288 into the heading, which takes as much away again.
    lags = 1.0 / 1.0 + 1.0 / 0.45 + 1.0 / 0.5 - 1.0 / 0.317
    assert u * np.sum(1.0 - turn) * 0.01 == pytest.approx(1.8288 * lags, rel=0.05)


def test_pid_gains_answer_a_small_step_over_the_same_way_at_every_speed() -> None:
    """All but the righting moment of the hull, which does not go with the speed, is scaled."""
    ways = []
    for u in (1.2, 1.8288, 3.0):
        flown = fly(LinearPlant(u), PID, STEP, Setpoint(10.02, 0.002, u), 60.0 / u)
        at = np.linspace(0.0, 59.0, 60) / u
        t = 0.01 * np.arange(len(flown["z"]))
        ways.append([np.interp(at, t, (flown["z"] - 10.0) / 0.02), np.interp(at, t, flown["psi"] / 0.002)])
    for way in (ways[0], ways[2]):
        for axis, trim in zip(way, ways[1], strict=True):
            assert np.abs(axis - trim).max() < 0.04
    assert ways[1][0].max() > 0.95  # it arrives
    assert ways[1][1].max() > 0.95


@pytest.mark.parametrize("control", [PAPER, OWN, PID], ids=["paper", "own", "pid"])
@pytest.mark.parametrize("u", [1.2, 1.8288])
def test_feed_forward_keeps_the_model_on_a_smooth_reference(control: ControlParams, u: float) -> None:
    flown = fly(LinearPlant(u), control, SMOOTH, Setpoint(13.0, 1.0, u), 90.0)
    assert np.ptp(flown["z_d"]) == pytest.approx(3.0, abs=1e-4)
    assert np.abs(flown["delta_s"]).max() > 0.03  # it had to work for it
    assert np.abs(flown["z"] - flown["z_d"]).max() < 0.01
    assert np.abs(flown["psi"] - flown["psi_d"]).max() < math.radians(0.3)


@pytest.mark.parametrize("control", [OWN, PID], ids=["own", "pid"])
def test_a_steady_moment_is_learned(control: ControlParams) -> None:
    plant = LinearPlant(1.8288, bias=math.radians(1.5))
    flown = fly(plant, control, SMOOTH, Setpoint(10.0, 0.0, 1.8288), 300.0)
    assert np.abs(flown["z"][:2000] - 10.0).max() > 0.01
    assert np.abs(flown["z"][-100:] - 10.0).max() < 0.005
    assert np.abs(flown["psi"][-100:]).max() < math.radians(0.1)


def test_a_current_in_the_sway_over_ground_changes_nothing() -> None:
    setpoint = Setpoint(10.0, 0.5, 1.8288)
    still = fly(LinearPlant(1.8288), OWN, SMOOTH, setpoint, 30.0)
    flowing = fly(LinearPlant(1.8288, current=0.3), OWN, SMOOTH, setpoint, 30.0)
    assert np.array_equal(still["psi"], flowing["psi"])


@pytest.mark.parametrize("factor", [0.5, 1.5])
def test_own_gains_stand_coefficients_that_are_half_as_wrong_again(factor: float) -> None:
    names = ("M_q", "M_ds", "N_r", "N_dr", "N_v", "Y_r", "Y_dr", "Y_v")
    wrong = {name: getattr(VEHICLE.coefficients, name) * factor for name in names}
    truth = dataclasses.replace(VEHICLE, coefficients=dataclasses.replace(VEHICLE.coefficients, **wrong))
    flown = fly(LinearPlant(1.8288, truth=truth), OWN, SMOOTH, Setpoint(12.0, 0.5, 1.8288), 90.0)
    assert np.abs(flown["z"] - flown["z_d"]).max() < 0.5
    assert np.abs(flown["z"][-1000:] - 12.0).max() < 0.02
    assert np.abs(flown["psi"] - flown["psi_d"]).max() < math.radians(8.0)
    assert np.abs(flown["psi"][-1000:] - 0.5).max() < math.radians(0.5)


def test_sigma_is_kept_small_on_a_smooth_reference_and_is_zero_under_pid() -> None:
    setpoint = Setpoint(12.0, 0.5, 1.8288)
    own = fly(LinearPlant(1.8288), OWN, SMOOTH, setpoint, 30.0)
    assert 0.0 < np.abs(own["sigma_z"]).max() < 0.1
    assert not fly(LinearPlant(1.8288), PID, SMOOTH, setpoint, 5.0)["sigma_z"].any()


@pytest.mark.parametrize("u", [0.5, 0.8, 1.2, 1.8288, 3.0])
def test_planes_are_not_held_against_the_righting_moment(u: float) -> None:
    law, pitch = SlidingModeLaw(OWN.depth, diving_model(VEHICLE, 1.8288), -1.0), math.radians(-20.0)
    law.schedule(diving_model(VEHICLE, u), u / 1.8288, 0.0)
    _, sigma = law.update((0.0, pitch, 0.0), 0.0, 10.0, 0.01)
    held, on_the_surface = law.update((0.0, pitch, sigma), 0.0, 10.0, 0.01)  # sigma's last entry is -1
    assert on_the_surface == pytest.approx(0.0, abs=1e-12)
    assert held <= 1e-9


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_trim_that_is_wrong_is_forgotten_outside_the_boundary_layer_and_one_that_is_right_grows_no_further(
    sign: float,
) -> None:
    law = SlidingModeLaw(OWN.depth, diving_model(VEHICLE, 1.8288), -1.0)
    far = (0.0, 0.0, sign * 50.0)  # too deep or too high by so much, m
    wrong = -sign * OWN.depth.trim_max  # it takes away from what the switching term does

    def after(trim: float, seconds: float) -> float:
        law.thaw(trim)
        for _ in range(round(100 * seconds)):
            law.update(far, 0.0, 10.0, 0.01)
        return law.freeze()

    assert OWN.depth.trim_max < OWN.depth.delta_sw
    assert after(wrong, 1.0) != wrong
    assert after(wrong, OWN.depth.integral_time) == pytest.approx(0.0, abs=math.radians(0.05))
    assert after(-wrong, OWN.depth.integral_time) == -wrong
