"""The observer model is the plant's equal where the plant's equations are the published ones, and knows its slopes."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from sternplane.codegen import derive_jacobians

from firmware_py import params
from firmware_py.estimation.model import jacobians
from firmware_py.estimation.model.equations import COEFFICIENTS
from firmware_py.estimation.model.flow import race, race_slopes
from firmware_py.estimation.model.observer_model import GROUPS, ObserverModel
from firmware_py.estimation.model.state import EDDIES
from firmware_py.marine import Eta, Nu
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.plant import Plant

from .cases import MOVING, TEN, TRUTH, VEHICLE, WIDE, apart, case, differences, seeds, slopes, state

# --- the equations ---------------------------------------------------------------------------------------------------


def test_the_committed_file_is_what_the_equations_give() -> None:
    assert Path(jacobians.__file__).read_text() == derive_jacobians.generate()


@given(seeds)
def test_accelerations_are_the_plant_s_for_any_body_and_any_coefficients(seed: int) -> None:
    rng, at = np.random.default_rng(seed + 1), case(seed)
    r_G, r_B = rng.uniform(-0.1, 0.1, 3).tolist(), rng.uniform(-0.1, 0.1, 3).tolist()
    I_xy, I_yz, I_xz = rng.uniform(-200.0, 200.0, 3).tolist()
    body = dataclasses.replace(TRUTH.body, r_G=tuple(r_G), r_B=tuple(r_B), I_xy=I_xy, I_yz=I_yz, I_xz=I_xz, B=53900.0)
    believed = dataclasses.replace(
        VEHICLE.body,
        **dict(zip(("x_G", "y_G", "z_G", "x_B", "y_B", "z_B"), (*r_G, *r_B), strict=True)),
        I_xy=I_xy,
        I_yz=I_yz,
        I_xz=I_xz,
        buoyancy=53900.0,
    )
    c = {name: value * rng.uniform(0.5, 1.5) for name, value in dataclasses.asdict(VEHICLE.coefficients).items()}
    c["K_prop"], c["N_prop"] = 1e-3, -2e-3
    truth = dataclasses.replace(TRUTH, body=body, coefficients=dataclasses.replace(TRUTH.coefficients, **c))
    vehicle = dataclasses.replace(VEHICLE, body=believed, coefficients=dataclasses.replace(VEHICLE.coefficients, **c))
    sea = Environment(EnvironmentParams((*at.current, 0.0)), 0, 0.01)
    ds, dr, _, n = at.inputs
    eta = Eta(0.0, 0.0, 100.0, *at.angles)
    plant = Plant(truth, sea, 0.01, 1, eta, Nu(*at.nu), n, (ds, ds, dr, dr))
    model = ObserverModel(vehicle, TEN)
    got = model.rates(state(model, at), at.inputs)
    assert plant.nu_r[0] > 0.3
    assert apart(got[:3], plant.nu_dot[:3]) < 1e-9
    assert apart(got[3:6], plant.nu_dot[3:]) < 1e-9


def test_bow_planes_push_as_their_coefficients_say() -> None:
    model = ObserverModel(VEHICLE, ())
    x = model.state((2.0, 0, 0, 0, 0, 0), (0, 0, 0))
    up = np.subtract(model.rates(x, np.array([0, 0, 0.1, 8.0])), model.rates(x, np.array([0, 0, 0, 8.0])))
    tau = np.linalg.inv(model.arrays.inverse_mass) @ up[:6]
    half = 500.0 * 5.3**2 * 4.0 * 0.1
    assert tau[2] == pytest.approx(half * -1.3e-2)
    assert tau[4] == pytest.approx(half * 5.3 * 3.5e-3)


def test_500_rpm_trims_at_6_feet_per_second() -> None:
    model = ObserverModel(VEHICLE, ())
    x = model.state((1.8288, 0, 0, 0, 0, 0), (0, 0, 0))
    assert model.rates(x, np.array([0, 0, 0, 500.0 / 60.0])) == pytest.approx((0.0,) * 9, abs=1e-13)


# --- the slopes ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("names", [COEFFICIENTS, WIDE], ids=["every coefficient", "groups"])
@given(seeds)
@settings(max_examples=15)
def test_slopes_by_state_coefficients_and_current_are_those_of_finite_differences(
    names: tuple[str, ...], seed: int
) -> None:
    at, model = case(seed), ObserverModel(VEHICLE, names, EDDIES)
    x, rng = state(model, at), np.random.default_rng(seed)
    x[11:14] = rng.uniform(-0.3, 0.3, 3)
    x[14:] *= rng.uniform(0.8, 1.2, len(names))
    wanted = differences(lambda z: np.array(model.rates(z, at.inputs)), x)
    got = slopes(model, x, at.inputs)
    for i in range(model.size):
        label = (*MOVING, "x_c", "y_c", "x_e", "y_e", "z_e", *names)[i]
        assert np.abs(got[:, i] - wanted[:, i]).max() <= 1e-7 * max(np.abs(wanted[:, i]).max(), 1e-3), label


@given(seeds)
@settings(max_examples=20)
def test_slopes_by_inputs_are_those_of_finite_differences(seed: int) -> None:
    at, model = case(seed), ObserverModel(VEHICLE, ())
    x = state(model, dataclasses.replace(at, current=(0.0, 0.0)))
    inputs = np.add(at.inputs, (0.0, 0.0, 0.1, 0.5))
    D, n = np.zeros((6, 4)), inputs[3]
    s, e, _ = race(model.arrays.constants, x[0], n)
    _, _, e_n, jet_n = race_slopes(model.arrays.constants, x[0], n)
    jacobians.input_slopes(model.arrays.constants, *x[:6], inputs[0], inputs[1], s, e, e_n, jet_n, D)
    columns = []
    for i in range(4):
        h = 1e-4 * np.eye(4)[i]
        columns.append(np.subtract(model.rates(x, inputs + h), model.rates(x, inputs - h))[:6] / 2e-4)
    assert apart(model.arrays.inverse_mass @ D, np.array(columns).T) < 1e-7


# --- the list of names -----------------------------------------------------------------------------------------------


def test_a_group_is_the_sum_of_its_members_at_their_believed_size() -> None:
    at, members = case(7), GROUPS["Y_dot"]
    assert set(members) == {"Y_vdot", "Y_pdot", "Y_rdot"}
    one, many = ObserverModel(VEHICLE, ("Y_dot",)), ObserverModel(VEHICLE, members)
    assert one.believed == (1.0,)
    together, each = slopes(one, state(one, at), at.inputs), slopes(many, state(many, at), at.inputs)
    assert together[:, 11] == pytest.approx(each[:, 11:14] @ np.array(many.believed), rel=1e-12)


def test_the_buoyancy_lifts_and_turns_a_hull_whose_centre_of_buoyancy_is_off() -> None:
    """The scale's column of the slopes against differences of the vehicle's own buoyancy, nose up and rolled."""
    at = case(7)
    body = dataclasses.replace(VEHICLE.body, x_B=0.1, y_B=0.02, z_B=-0.03)
    vehicle = dataclasses.replace(VEHICLE, body=body)
    model = ObserverModel(vehicle, ("buoyancy",))
    assert model.believed == (1.0,)
    x, h = state(model, at), 1e-3
    moved = []
    for scale in (1.0 + h, 1.0 - h):
        other = dataclasses.replace(vehicle, body=dataclasses.replace(body, buoyancy=scale * body.buoyancy))
        moved.append(ObserverModel(other, ()).rates(x[: model.first], at.inputs))
    wanted = np.subtract(*moved)[:6] / (2.0 * h)
    assert abs(wanted[2]) > 1.0
    assert slopes(model, x, at.inputs)[:6, -1] == pytest.approx(wanted, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("M_q", "M_sd"), "no coefficient is called 'M_sd'; did you mean M_ds"),
        (("xyzzy",), "no coefficient is called 'xyzzy'; the names are"),
        (("M_q", "N_r", "M_q"), "'M_q' twice"),
        (("Y_vdot", "Y_dot"), "'Y_vdot' and 'Y_dot' both hold Y_vdot"),
    ],
)
def test_a_wrong_list_is_refused(names: tuple[str, ...], message: str) -> None:
    with pytest.raises(params.ParamError, match=message):
        ObserverModel(VEHICLE, names)


def test_a_mass_matrix_that_is_not_positive_definite_is_refused() -> None:
    c = dataclasses.replace(VEHICLE.coefficients, M_qdot=0.5)
    with pytest.raises(params.ParamError, match="not positive definite, first in q_dot"):
        ObserverModel(dataclasses.replace(VEHICLE, coefficients=c), TEN)
