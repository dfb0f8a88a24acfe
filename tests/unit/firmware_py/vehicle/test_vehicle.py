from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.params import ParamError, dump, load
from firmware_py.vehicle.coefficients import Coefficients
from firmware_py.vehicle.linear_models import diving_model, steering_model
from firmware_py.vehicle.vehicle import Vehicle

FILE = Path(__file__).resolve().parents[4] / "configs" / "npsauv2" / "vehicle.toml"


def table() -> dict:
    return tomllib.loads(FILE.read_text())


VEHICLE = load(Vehicle, table(), "vehicle.toml")


def fins(*layout: tuple[str, float, str]) -> list[dict]:
    return [{"name": name, "hinge_deg": hinge, "station": station} for name, hinge, station in layout]


def test_file_is_read_whole_and_written_back() -> None:
    assert VEHICLE.hull.length == 5.3
    assert VEHICLE.propeller.n_trim == pytest.approx(500 / 60)
    assert [fin.name for fin in VEHICLE.fins] == ["stern_port", "stern_starboard", "rudder_upper", "rudder_lower"]
    assert load(Vehicle, dump(VEHICLE), "again") == VEHICLE


def test_the_paper_s_ten_coefficients_are_healey_and_lienard_s() -> None:
    c = VEHICLE.coefficients
    assert (c.M_q, c.M_ds, c.Z_q, c.Z_ds) == (-6.8e-2, -4.1e-2, -1.4e-1, -7.3e-2)
    assert (c.N_r, c.N_dr, c.N_v) == (-1.6e-2, -1.3e-2, -7.4e-3)
    assert (c.Y_dr, c.Y_r, c.Y_v) == (2.7e-2, 3e-2, -1e-1)


@given(st.floats(0.3, 5.0))
def test_signs_of_the_linear_models(u: float) -> None:
    dive, steer = diving_model(VEHICLE, u), steering_model(VEHICLE, u)
    assert dive.b[0] < 0.0  # positive stern plane: bow down
    assert steer.b[1] < 0.0  # positive rudder: to port
    assert dive.A[0][0] < 0.0  # pitch is damped
    assert dive.A[0][1] < 0.0  # weight below buoyancy rights it
    assert dive.A[2][1] == -u
    assert steer.A[0][0] < 0.0
    assert steer.A[1][1] < 0.0


@given(st.floats(0.3, 5.0), st.floats(1.1, 3.0))
def test_damping_goes_with_speed_and_fins_with_its_square(u: float, factor: float) -> None:
    for model in (diving_model, steering_model):
        slow, fast = model(VEHICLE, u), model(VEHICLE, factor * u)
        assert fast.A[0][0] == pytest.approx(factor * slow.A[0][0])
        assert fast.b[0] == pytest.approx(factor**2 * slow.b[0])


def test_models_at_rest_are_finite() -> None:
    assert diving_model(VEHICLE, 0.0).b[0] == 0.0
    assert steering_model(VEHICLE, 0.0).b[0] == 0.0


def test_steering_matches_newton_on_the_coupled_rows() -> None:
    """M (v_dot, r_dot) of the model's answer must be the forces of Eq. 30."""
    u, v, r, delta = 1.5, 0.3, 0.1, 0.2
    L, rho, m, c = 5.3, 1000.0, 5454.54, VEHICLE.coefficients
    A, b = steering_model(VEHICLE, u)
    v_dot, r_dot = (row[0] * v + row[1] * r + gain * delta for row, gain in zip(A[:2], b[:2], strict=True))
    Y = rho / 2 * L**2 * (u * c.Y_v * v + u * u * c.Y_dr * delta) + (rho / 2 * L**3 * c.Y_r - m) * u * r
    N = rho / 2 * L**3 * (u * c.N_v * v + u * u * c.N_dr * delta) + rho / 2 * L**4 * u * c.N_r * r
    assert (m - rho / 2 * L**3 * c.Y_vdot) * v_dot - rho / 2 * L**4 * c.Y_rdot * r_dot == pytest.approx(Y)
    assert -rho / 2 * L**4 * c.N_vdot * v_dot + (13587.0 - rho / 2 * L**5 * c.N_rdot) * r_dot == pytest.approx(N)


@pytest.mark.parametrize(
    ("layout", "message"),
    [
        ([], "fins is empty"),
        (
            fins(*((f"f{i}", i % 2 * 90, "stern") for i in range(16))),
            "fins: 16 are too many; one command holds 15",
        ),
        (fins(("a", 0, "stern"), ("", 90, "stern")), "fins[1]: name is empty"),
        (fins(("a", 0, "stern"), ("a", 90, "stern")), "'a' occurs 2 times"),
        (fins(("a", 90, "stern"), ("b", 90, "stern")), "none acts on delta_s"),
        (fins(("a", 0, "stern"), ("b", 180, "stern")), "none acts on delta_r"),
        (fins(("a", 45, "stern"), ("b", 45, "stern")), "are not independent"),
        (fins(("a", 0, "stern"), ("b", 90, "stern"), ("c", 30, "bow")), "bow plane 'c' has hinge_deg 30"),
        (fins(("a", 0, "stern"), ("b", 0, "bow")), "none acts on delta_r"),
    ],
)
def test_an_impossible_layout_is_one_line(layout: list[dict], message: str) -> None:
    with pytest.raises(ParamError, match=r"^vehicle.toml: fins") as caught:
        load(Vehicle, {**table(), "fins": layout}, "vehicle.toml")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("name", "value"), [("M_ds", 0.0), ("N_dr", 1.3e-2)])
def test_fins_that_do_nothing_or_the_opposite_are_refused(name: str, value: float) -> None:
    wrong = table()
    wrong["coefficients"][name] = value
    with pytest.raises(ParamError, match=f"{name} must be negative"):
        load(Vehicle, wrong, "vehicle.toml")


@pytest.mark.parametrize("name", ["Y_v", "Z_w", "K_p", "M_q", "N_r"])
def test_water_that_drives_a_motion_in_place_of_braking_it_is_refused(name: str) -> None:
    wrong = table()
    wrong["coefficients"][name] = 1e-3
    with pytest.raises(ParamError, match=f"{name} must not be positive: water brakes that motion"):
        load(Vehicle, wrong, "vehicle.toml")


NEEDED = {"Z_w", "M_q", "M_ds", "Y_v", "Y_r", "Y_dr", "N_v", "N_r", "N_dr"}
"""What the laws are designed from (Eq. 26, Eq. 30), beside added mass."""


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(Coefficients)])
def test_a_coefficient_that_is_left_out_is_zero_unless_no_law_can_do_without(name: str) -> None:
    short = table()
    del short["coefficients"][name]
    if name not in NEEDED:
        assert getattr(load(Vehicle, short, "v").coefficients, name) == 0.0
        return
    with pytest.raises(ParamError, match=rf"^v: coefficients: {name} is missing \(a number in \[-10, 10\]\)"):
        load(Vehicle, short, "v")


@pytest.mark.parametrize(
    ("place", "key", "value"),
    [("body", "mass_kg", 1e300), ("body", "I_y_kg_m2", 0.0), ("hull", "length_m", 1e3), ("coefficients", "M_q", -68.0)],
)
def test_what_no_vehicle_can_have_is_out_of_bounds(place: str, key: str, value: float) -> None:
    wrong = table()
    wrong[place][key] = value
    with pytest.raises(ParamError, match=f"^v: {place}: {key} = ") as caught:
        load(Vehicle, wrong, "v")
    assert "out of bounds" in str(caught.value)


@pytest.mark.parametrize(
    ("model", "name", "value"),
    [
        (diving_model, "M_qdot", 0.1),
        (steering_model, "Y_vdot", 0.1),
        (steering_model, "N_rdot", 0.1),
        (steering_model, "N_vdot", 1.0),
    ],
)
def test_added_mass_that_leaves_no_inertia_is_named(model: Callable, name: str, value: float) -> None:
    wrong = table()
    wrong["coefficients"][name] = value
    if name == "N_vdot":
        wrong["coefficients"]["Y_rdot"] = value
    with pytest.raises(ParamError, match=f"^coefficients: .*{name}"):
        model(load(Vehicle, wrong, "v"), 1.8)


def test_a_coefficient_that_does_not_exist_is_named() -> None:
    wrong = table()
    wrong["coefficients"]["M_qq"] = 1.0
    with pytest.raises(ParamError, match="coefficients: M_qq is unknown"):
        load(Vehicle, wrong, "vehicle.toml")


def test_propeller_that_cannot_reach_its_trim_is_refused() -> None:
    wrong = table()
    wrong["propeller"]["n_max_rpm"] = 400.0
    with pytest.raises(ParamError, match="n_max_rpm is below n_trim_rpm"):
        load(Vehicle, wrong, "vehicle.toml")


def test_effectiveness_of_plus_x_and_bow_planes() -> None:
    plus = VEHICLE.effectiveness
    assert plus.s == (0.5, 0.5, 0.0, 0.0)
    assert plus.r == (0.0, 0.0, 0.5, 0.5)
    assert plus.delta_s_max == pytest.approx(0.40142572795)
    x = load(
        Vehicle, {**table(), "fins": fins(*((f"f{i}", h, "stern") for i, h in enumerate((45, 135, 45, 135))))}, "x"
    )
    assert x.effectiveness.s == pytest.approx((0.35355339, -0.35355339) * 2)
    assert x.effectiveness.r == pytest.approx((0.35355339,) * 4)
    bow = load(Vehicle, {**table(), "fins": [*table()["fins"], *fins(("bow", 0, "bow"))]}, "bow")
    assert bow.effectiveness.s[4] == pytest.approx(3.5e-3 / -4.1e-2)
    assert bow.effectiveness.r[4] == 0.0
