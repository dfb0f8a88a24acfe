"""The file of the truth: complete, and faults named."""

from __future__ import annotations

import copy
import dataclasses
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firmware_py import params
from firmware_py.params import ParamError
from firmware_py.wire.dronecan.equipment_messages import ActuatorCommand, ArrayCommand
from firmware_py.wire.dronecan.message_table import ARRAY_COMMAND
from sim_bridge.plant.coefficients import PlantCoefficients, length_power
from sim_bridge.plant.packing import C, constants, fin_table, mass_matrix
from sim_bridge.plant.truth import MOST_FINS, FinStation, PlantFin, Truth, refuse_other_fins

CONFIG = Path(__file__).resolve().parents[3] / "configs" / "npsauv2" / "truth.toml"
TABLE = tomllib.loads(CONFIG.read_text())


def load(table: dict[str, Any]) -> Truth:
    return params.load(Truth, table, "truth.toml")


def test_the_vehicle_of_the_source() -> None:
    truth = load(TABLE)
    body = truth.body
    assert (body.m, body.W, body.B) == (5454.54, 53400.0, 53400.0)
    assert (body.I_x, body.I_y, body.I_z) == (2038.0, 13587.0, 13587.0)
    assert body.I_xy == body.I_yz == body.I_xz == -13.58
    assert (body.r_G, body.r_B) == ((0.0, 0.0, 0.061), (0.0, 0.0, 0.0))
    assert (truth.hull.L, truth.hull.rho, truth.hull.C_dy, truth.hull.C_dz) == (5.3, 1000.0, 0.5, 0.6)
    assert (truth.hull.height, truth.hull.width) == (0.53, 0.53)
    assert (truth.propeller.eta_n, truth.propeller.C_d0, truth.propeller.C_t) == (0.012, 0.00385, 0.008)
    assert truth.servo.limit == pytest.approx(math.radians(23.0))
    assert [fin.name for fin in truth.fins] == ["stern_port", "stern_starboard", "rudder_upper", "rudder_lower"]


NEEDED = {"Z_w", "M_q", "M_ds", "Y_v", "Y_r", "Y_dr", "N_v", "N_r", "N_dr"}


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(PlantCoefficients)])
def test_a_coefficient_that_is_left_out_is_zero_unless_nothing_steers_without(name: str) -> None:
    table = copy.deepcopy(TABLE)
    del table["coefficients"][name]
    if name not in NEEDED:
        assert getattr(load(table).coefficients, name) == 0.0
        return
    with pytest.raises(ParamError, match=f"coefficients: {name} is missing"):
        load(table)


@pytest.mark.parametrize(
    ("place", "key", "value", "message"),
    [
        ("coefficients", "Y_vdott", 1.0, "Y_vdott is unknown; did you mean Y_vdot"),
        ("body", "m_kg", -1.0, "m_kg = -1.0: out of bounds"),
        ("hull", "height", 0.53, "write height_m"),
        ("servo", "limit_deg", 120.0, "limit_deg"),
        ("body", "m_kg", 1e300, "body: m_kg = 1e\\+300: out of bounds"),
        ("hull", "L_m", 530.0, "hull: L_m = 530.0: out of bounds"),
        ("coefficients", "M_q", -11.0, r"coefficients: M_q = -11.0: out of bounds, must be a number in \[-10, 10\]"),
    ],
)
def test_faults_are_named(place: str, key: str, value: float, message: str) -> None:
    table = copy.deepcopy(TABLE)
    table[place][key] = value
    with pytest.raises(ParamError, match=message):
        load(table)


def test_a_bow_plane_must_lie_flat_and_fins_have_their_own_names() -> None:
    with pytest.raises(ParamError, match="bow plane 'b'"):
        PlantFin("b", FinStation.BOW, 0.5, (1.0, 0.0, 0.0), 0.1)
    table = copy.deepcopy(TABLE)
    table["fins"][1]["name"] = "stern_port"
    with pytest.raises(ParamError, match="two fins are called 'stern_port'"):
        load(table)


def with_fins(count: int) -> dict[str, Any]:
    fins = [TABLE["fins"][i % 4] | {"name": f"fin_{i}"} for i in range(count)]
    return {**TABLE, "fins": fins}


def test_there_are_no_more_fins_than_one_command_carries() -> None:
    most = load(with_fins(MOST_FINS))
    assert len(ARRAY_COMMAND.encode(ArrayCommand((ActuatorCommand(0, 1, 0.1),) * len(most.fins)))) > 0
    with pytest.raises(ValueError, match="15"):
        ARRAY_COMMAND.encode(ArrayCommand((ActuatorCommand(0, 1, 0.1),) * (MOST_FINS + 1)))
    for count in (0, 16):
        with pytest.raises(ParamError, match=rf"^truth\.toml: fins: {count} of them; write 1 to 15"):
            load(with_fins(count))


def test_a_fin_without_a_name_is_refused() -> None:
    table = copy.deepcopy(TABLE)
    table["fins"][2]["name"] = " "
    with pytest.raises(ParamError, match=r"^truth\.toml: fins\[2\]: name is empty"):
        load(table)


def test_another_number_of_fins_than_the_autopilot_believes_in_is_refused_with_both_files() -> None:
    refuse_other_fins(load(TABLE), "truth.toml", 4, "vehicle.toml")
    with pytest.raises(ParamError, match=r"^truth\.toml: fins: 4 of them, but 6 in vehicle\.toml; write the same"):
        refuse_other_fins(load(TABLE), "truth.toml", 6, "vehicle.toml")


def test_the_substeps_are_one_unless_the_file_says_otherwise() -> None:
    assert load({key: value for key, value in TABLE.items() if key != "substeps"}).substeps == 1
    assert load({**TABLE, "substeps": 100}).substeps == 100
    for wrong in (0, 101, 1.5):
        with pytest.raises(ParamError, match=rf"truth\.toml: substeps = {wrong}: .* a whole number in \[1, 100\]"):
            load({**TABLE, "substeps": wrong})


def test_what_was_read_can_be_written_and_read_again() -> None:
    truth = load(TABLE)
    assert load(params.dump(truth)) == truth


@pytest.mark.parametrize(
    ("power", "names"),
    [
        (2, "X_vv X_ww X_vdr X_wds X_dsds X_drdr X_wdsn X_dsdsn X_wdb Y_v Y_vw Y_dr Z_w Z_vv Z_ds Z_wn Z_dsn Z_db"),
        (3, "X_udot Y_vdot Z_wdot X_wq X_vp X_vr X_qds X_rdr X_qdsn X_qdb Y_p Y_r Y_wr Z_q Z_qn Z_vr"),
        (3, "K_v K_vw K_prop M_w M_vv M_ds M_wn M_dsn M_db N_v N_vw N_dr N_prop"),
        (4, "X_pp X_pr Y_pq Y_qr Z_rr Y_pdot Y_rdot Z_qdot K_vdot M_wdot N_vdot K_p K_wr K_pn M_q M_qn N_r"),
        (5, "K_pdot K_rdot M_qdot N_pdot N_rdot K_pq K_qr M_pp M_rr N_pq N_qr"),
    ],
)
def test_the_name_of_a_coefficient_tells_its_dimension(power: int, names: str) -> None:
    """As in the appendix of the paper, its L^3 of the added masses corrected."""
    assert {length_power(name) for name in names.split()} == {power}


@pytest.mark.parametrize("name", ["X", "Q_v", "X_", "X_zz", "Yv", "Y_vx"])
def test_a_name_that_spells_no_term_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="does not spell"):
        length_power(name)


def test_the_packed_constants_are_where_their_names_say() -> None:
    c = constants(load(TABLE))
    assert len(c) == len(C)
    assert (c[C.m], c[C.z_G], c[C.L], c[C.radius]) == (5454.54, 0.061, 5.3, 0.265)
    assert c[C.M_qdot] == pytest.approx(-1.7e-2 * 500.0 * 5.3**5)
    assert c[C.advance] * 500.0 / 60.0 == pytest.approx(1.8288, rel=1e-15)


def test_a_singular_mass_matrix_is_refused() -> None:
    truth = load(TABLE)
    heavy = dataclasses.replace(truth.coefficients, X_udot=5454.54 / (500.0 * 5.3**3))
    still = dataclasses.replace(truth.body, r_G=(0.0, 0.0, 0.0))
    with pytest.raises(ParamError, match="singular"):
        mass_matrix(dataclasses.replace(truth, body=still, coefficients=heavy))


def test_the_mass_matrix_with_a_centre_of_gravity_anywhere_is_that_of_the_moved_body() -> None:
    """Kinetic energy of a rigid body is that of its mass at G plus that of its rotation (Koenig)."""
    truth = load(TABLE)
    body = dataclasses.replace(truth.body, r_G=(0.3, -0.2, 0.1))
    none = PlantCoefficients(**{field.name: 0.0 for field in dataclasses.fields(PlantCoefficients)})
    M = mass_matrix(dataclasses.replace(truth, body=body, coefficients=none))
    nu = np.array([1.0, -0.5, 0.3, 0.2, -0.4, 0.6])
    omega, r_G = nu[3:], np.array(body.r_G)
    I_o = np.array(
        [
            [body.I_x, -body.I_xy, -body.I_xz],
            [-body.I_xy, body.I_y, -body.I_yz],
            [-body.I_xz, -body.I_yz, body.I_z],
        ]
    )
    I_G = I_o - body.m * (r_G @ r_G * np.eye(3) - np.outer(r_G, r_G))
    v_G = nu[:3] + np.cross(omega, r_G)
    assert nu @ M @ nu == pytest.approx(body.m * v_G @ v_G + omega @ I_G @ omega, rel=1e-12)


def test_the_shares_of_a_layout() -> None:
    rows = fin_table(load(TABLE))
    np.testing.assert_allclose(rows[:, 4:7].sum(axis=0), [1.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(rows[0, 4:7], [0.5, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(rows[3, 4:7], [0.0, 0.5, 0.0], atol=1e-15)


def test_an_inertia_that_no_body_has_is_refused() -> None:
    table = copy.deepcopy(TABLE)
    table["body"] |= {"I_xy_kg_m2": 9000.0, "I_xz_kg_m2": 9000.0}
    with pytest.raises(ParamError, match="body: no body has these moments and products of inertia"):
        load(table)
