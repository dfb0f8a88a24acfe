"""The laws against the paper's printed numbers: each printed magnitude lies in the rounding box of what was printed."""

from __future__ import annotations

import dataclasses
import itertools
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from firmware_py.control.sliding_mode_design import control_law, design_sliding_mode, sliding_surface
from firmware_py.control.sliding_mode_params import PAPER_DEPTH_GAINS, PAPER_HEADING_GAINS
from firmware_py.params import load
from firmware_py.vehicle.linear_models import LinearModel, diving_model, steering_model
from firmware_py.vehicle.vehicle import Vehicle

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "npsauv2"
VEHICLE = load(Vehicle, tomllib.loads((CONFIG / "vehicle.toml").read_text()), "vehicle.toml")
U = 1.832  # Eq. 27, third row


def box(printed: str) -> tuple[float, float]:
    """Every number that is printed so."""
    half = 0.5 * 10.0 ** -len(printed.partition(".")[2])
    return float(printed) - half, float(printed) + half


def corners(*printed: str) -> Iterator[tuple[float, ...]]:
    return itertools.product(*(box(number) for number in printed))


def believing(**errors: float) -> Vehicle:
    """The vehicle with coefficients that are wrong by a share of their value, as those of Table 1 are."""
    values = {name: getattr(VEHICLE.coefficients, name) * (1.0 + error) for name, error in errors.items()}
    return dataclasses.replace(VEHICLE, coefficients=dataclasses.replace(VEHICLE.coefficients, **values))


def overlaps(values: list[float], printed: str) -> bool:
    low, high = box(printed)
    return min(values) <= high and max(values) >= low


def test_equation_27_follows_from_the_estimates_of_table_1() -> None:
    models = [diving_model(believing(M_q=0.01 * q, M_ds=0.01 * d), u) for q, d, u in corners("0.12", "0.26", "1.8320")]
    assert overlaps([m.A[0][0] for m in models], "-1.002")
    assert overlaps([m.A[0][1] for m in models], "-0.066")
    assert overlaps([m.b[0] for m in models], "-0.209")
    assert not overlaps([diving_model(VEHICLE, U).A[0][0]], "-1.002")  # nor does it follow from the true ones


def test_equation_31_follows_from_the_estimates_of_table_1() -> None:
    sway = {"Y_v": -0.2329, "Y_r": 0.0961, "Y_dr": 0.1453}
    model = steering_model(believing(**sway), U)
    for value, printed in ((model.A[0][0], "-0.209"), (model.A[0][1], "-0.605"), (model.b[0], "0.145")):
        assert overlaps([value], printed)
    # Table 1 gives no signs; with the best of them the yaw row stays a little off the print.
    signs = itertools.product((-1, 1), repeat=3)
    yaw = [steering_model(believing(**sway, N_v=0.0013 * a, N_r=0.0033 * b, N_dr=0.0058 * c), U) for a, b, c in signs]
    off = [max(abs(m.A[1][0] + 0.054), abs(m.A[1][1] + 0.569), abs(m.b[1] + 0.152)) for m in yaw]
    assert min(off) < 0.005


def test_rudder_force_goes_with_the_square_of_the_length_unlike_the_print_of_equation_30() -> None:
    hull, c = VEHICLE.hull, VEHICLE.coefficients
    force = 0.5 * hull.density * hull.length**2 * c.Y_dr * U * U
    sway_inertia = VEHICLE.body.mass - 0.5 * hull.density * hull.length**3 * c.Y_vdot
    assert steering_model(VEHICLE, U).b[0] == pytest.approx(
        force / sway_inertia, rel=0.1
    )  # the rest is the coupling with yaw


def printed_dive() -> list[LinearModel]:
    entries = corners("-1.002", "-0.066", "-1.8320", "-0.209")
    return [LinearModel(((a, c, 0.0), (1.0, 0.0, 0.0), (0.0, u, 0.0)), (b, 0.0, 0.0)) for a, c, u, b in entries]


def printed_turn() -> list[LinearModel]:
    entries = corners("-0.209", "-0.605", "-0.054", "-0.569", "0.145", "-0.152")
    return [LinearModel(((a, b, 0.0), (c, d, 0.0), (0.0, 1.0, 0.0)), (e, f, 0.0)) for a, b, c, d, e, f in entries]


def test_depth_surface_and_gains_of_equations_28_and_29() -> None:
    designs = [
        design_sliding_mode(m, PAPER_DEPTH_GAINS.poles, -1.0, PAPER_DEPTH_GAINS.delta_sw, PAPER_DEPTH_GAINS.phi_b)
        for m in printed_dive()
    ]
    assert overlaps([d.s[0] for d in designs], "28.18")
    assert overlaps([d.s[1] for d in designs], "14.37")
    assert all(d.s[2] == pytest.approx(-1.0) for d in designs)
    assert overlaps([d.k[0] for d in designs], "2.3531")
    assert overlaps([d.k[1] for d in designs], "0.0062")
    assert overlaps([-1.0 / d.s_b for d in designs], "0.1698")
    assert overlaps([d.eta / abs(d.s_b) for d in designs], "2.3")
    assert overlaps([d.eta for d in designs], "13.5")
    assert all(d.phi_b == 4.0 for d in designs)


def test_heading_surface_and_gains_of_equations_32_and_33() -> None:
    gains = PAPER_HEADING_GAINS
    designs = [design_sliding_mode(m, gains.poles, 1.0, gains.delta_sw, gains.phi_b) for m in printed_turn()]
    assert overlaps([d.s[0] for d in designs], "0.15")
    assert overlaps([d.s[1] for d in designs], "1.65")
    assert all(d.s[2] == pytest.approx(1.0) for d in designs)
    assert overlaps([d.k[0] for d in designs], "0.5260")
    assert overlaps([d.k[1] for d in designs], "0.1621")
    assert overlaps([-1.0 / d.s_b for d in designs], "4.3465")
    assert overlaps([d.eta / abs(d.s_b) for d in designs], "1.5")
    assert overlaps([d.eta for d in designs], "0.345")
    assert all(d.phi_b == 0.05 for d in designs)


def test_signs_are_those_of_equation_25_and_not_of_the_print() -> None:
    dive = design_sliding_mode(diving_model(VEHICLE, U), PAPER_DEPTH_GAINS.poles, -1.0, 2.3, 4.0)._replace(eta=0.0)
    turn = design_sliding_mode(steering_model(VEHICLE, U), PAPER_HEADING_GAINS.poles, 1.0, 1.5, 0.05)._replace(eta=0.0)
    assert control_law(dive, (0.01, 0.0, 0.0), 0.0)[0] == pytest.approx(-0.0235, rel=0.01)  # printed + 2.3531 q
    assert control_law(dive, (0.0, 0.01, 0.0), 0.0)[0] < 0.0  # printed + 0.0062 theta
    assert dive.s[2] / dive.s_b == pytest.approx(0.170, rel=0.01)  # of z_d_dot; printed - 0.1698
    assert control_law(turn, (0.01, 0.0, 0.0), 0.0)[0] < 0.0  # printed + 0.5260 v
    assert control_law(turn, (0.0, 0.01, 0.0), 0.0)[0] < 0.0  # printed + 0.1621 r
    assert turn.s[2] / turn.s_b < 0.0  # of psi_d_dot; printed + 4.3465


def test_switching_terms_have_the_printed_sign() -> None:
    dive = design_sliding_mode(diving_model(VEHICLE, U), PAPER_DEPTH_GAINS.poles, -1.0, 2.3, 4.0)
    turn = design_sliding_mode(steering_model(VEHICLE, U), PAPER_HEADING_GAINS.poles, 1.0, 1.5, 0.05)
    for sliding, authority in ((dive, 2.3), (turn, 1.5)):
        s = sliding.s
        far = (0.0, 0.0, 100.0 * s[2])  # sigma >> phi_b
        assert control_law(sliding, far, 0.0)[0] == pytest.approx(authority, rel=1e-6)


def test_surface_alone_is_the_design_s_surface() -> None:
    s, k, s_b = sliding_surface(diving_model(VEHICLE, U), PAPER_DEPTH_GAINS.poles, -1.0)
    whole = design_sliding_mode(diving_model(VEHICLE, U), PAPER_DEPTH_GAINS.poles, -1.0, 2.3, 4.0)
    assert (s, k, s_b) == (whole.s, whole.k, whole.s_b)
    assert s_b == pytest.approx(sum(a * b for a, b in zip(s, diving_model(VEHICLE, U).b, strict=True)))
