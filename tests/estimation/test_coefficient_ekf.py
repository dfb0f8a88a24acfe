"""The coefficient filter: scales from the vehicle file alone, lists that cannot be right, and states that stay put."""

from __future__ import annotations

import dataclasses
import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from sternplane.sitl.busless_flight import SENSOR_STD, measure

from firmware_py import app, config_files
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.params import ParamError

from .cases import CONFIGS, TRUTH, VEHICLE
from .flights import DT, flown

TRIAL = flown()
Z = measure(TRIAL, SENSOR_STD, [5.0] * 3 + [100.0] * 6, seed=3)
VARIANCE = SENSOR_STD**2
BANK = (0.0, 0.02, 0.05)


def started(values: dict[str, float] | None = None, **changes: object) -> CoefficientEkf:
    ekf = CoefficientEkf(VEHICLE, CoefficientParams(**changes))
    ekf.start(TRIAL.x[0, :6].tolist(), TRIAL.x[0, 6:].tolist(), SENSOR_STD, values)
    return ekf


def errors(ekf: CoefficientEkf) -> dict[str, float]:
    """Relative to the plant's own."""
    values = zip(ekf.names, ekf.estimate().values.tolist(), strict=True)
    return {name: value / getattr(TRUTH.coefficients, name) - 1.0 for name, value in values}


def test_scales_come_from_the_vehicle_file_wherever_it_starts() -> None:
    half = dataclasses.replace(VEHICLE.coefficients, M_q=0.5 * VEHICLE.coefficients.M_q)
    doubted = CoefficientEkf(dataclasses.replace(VEHICLE, coefficients=half), CoefficientParams())
    for values in (None, dict.fromkeys(TEN, 0.0)):
        ekf = started(values)
        place = ekf.model.place("M_q")
        assert ekf.estimate().std[0] == pytest.approx(0.7 * abs(VEHICLE.coefficients.M_q))
        assert doubted.prior[place] == pytest.approx(0.5 * ekf.prior[place])


def test_from_nothing_but_the_size_it_finds_them_where_the_motion_tells() -> None:
    ekf = started(dict.fromkeys(TEN, 0.0))
    assert ekf.run(DT, TRIAL.inputs, Z, VARIANCE).steps == len(Z)
    found = errors(ekf)
    for name in ("M_q", "M_ds", "N_r", "N_dr"):
        assert abs(found[name]) < 0.1


@pytest.mark.parametrize("turbulence", [(0.0,), BANK], ids=["one filter", "bank"])
def test_steps_one_by_one_are_the_compiled_run_to_the_last_bit(turbulence: tuple[float, ...]) -> None:
    one, other = started(turbulence=turbulence), started(turbulence=turbulence)
    for inputs, z in zip(TRIAL.inputs[:300], Z[:300], strict=True):
        assert one.step(inputs, DT, z, VARIANCE)
    other.run(DT, TRIAL.inputs[:300], Z[:300], VARIANCE)
    assert (one.x.tobytes(), one.P.tobytes()) == (other.x.tobytes(), other.P.tobytes())
    assert one.log_likelihood.tobytes() == other.log_likelihood.tobytes()


def test_what_does_not_learn_stays_to_the_last_bit_and_what_does_is_no_surer_for_it() -> None:
    free, held = started(walk=0.01), started(walk=0.01)
    place = held.model.place("N_dr")
    held.permit(np.array([name != "N_dr" for name in held.names]))
    before = held.x[0, place], held.P[0, place, place]
    for ekf in (free, held):
        ekf.run(DT, TRIAL.inputs, Z, VARIANCE)
    assert (held.x[0, place], held.P[0, place, place]) == before
    others = [held.model.place(name) for name in TEN if name != "N_dr"]
    loose, tight = held.P[0].diagonal()[others], free.P[0].diagonal()[others]
    assert (loose > tight * (1.0 - 1e-6)).all()
    assert held.tuning.learns[place] == 0.0


def test_in_short_it_says_what_it_says_at_length() -> None:
    ekf = started(turbulence=BANK)
    ekf.run(DT, TRIAL.inputs[:500], Z[:500], VARIANCE)
    told, (mean, std, weights) = ekf.estimate(), ekf.bank.combine()
    assert mean.tobytes() == told.mean.tobytes()
    assert weights.tobytes() == told.weights.tobytes()
    np.testing.assert_allclose(std, np.sqrt(told.covariance.diagonal()), rtol=1e-9)


def test_a_reset_of_motion_keeps_the_rest_and_one_of_the_current_too() -> None:
    ekf = started(turbulence=BANK)
    ekf.run(DT, TRIAL.inputs[:1500], Z[:1500], VARIANCE)
    first = ekf.model.first
    x, P = ekf.x.copy(), ekf.P.copy()
    ekf.resume([1.0, 0.1, 0.2, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0], SENSOR_STD)
    assert ekf.x[:, :9].tolist() == [[1.0, 0.1, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0]] * 3
    kept = [9, 10, *range(14, ekf.model.size)]
    np.testing.assert_array_equal(ekf.x[:, kept], x[:, kept])
    np.testing.assert_array_equal(ekf.P[:, kept][:, :, kept], P[:, kept][:, :, kept])
    assert not ekf.P[:, :9, 9:].any()
    np.testing.assert_allclose(ekf.P[:, 11, 11], np.square(ekf.intensity))

    ekf.bank.reset_current()
    assert not ekf.x[:, 9:11].any()
    assert not ekf.P[:, 9:11, first:].any()
    np.testing.assert_allclose(ekf.P[:, [9, 10], [9, 10]], 0.3**2)
    np.testing.assert_array_equal(ekf.P[:, first:, first:], P[:, first:, first:])
    assert np.linalg.eigvalsh(ekf.P).min() >= 0.0


@pytest.mark.parametrize(
    "poison",
    [
        lambda ekf: ekf.x.__setitem__((1, 4), math.nan),
        lambda ekf: ekf.P.__setitem__((2, 4, 4), math.inf),
        lambda ekf: ekf.P.__setitem__((2, 4, 4), -1.0),
        lambda ekf: ekf.log_likelihood.__setitem__(0, math.inf),
    ],
    ids=["state", "covariance", "negative covariance", "log-likelihood"],
)
def test_a_step_that_leads_to_a_number_that_is_none_says_so_and_a_start_mends_it(poison) -> None:
    ekf = started(turbulence=BANK)
    poison(ekf)
    assert not ekf.step(TRIAL.inputs[0], DT, Z[0], VARIANCE)
    ekf.start(TRIAL.x[0, :6].tolist(), TRIAL.x[0, 6:].tolist(), SENSOR_STD)
    assert ekf.run(DT, TRIAL.inputs, Z, VARIANCE).steps == len(Z)


def test_the_rest_is_every_other_coefficient_that_is_known_to_be_something() -> None:
    ekf = CoefficientEkf(VEHICLE, CoefficientParams(names=("M_q", "Y_dot"), considered=("C_dz", "rest")))
    names = ekf.model.names
    assert names[:3] == ("M_q", "Y_dot", "C_dz")
    assert len(set(names)) == len(names)
    assert {"Y_vdot", "Y_rdot", "Y_pdot", "K_prop", "N_prop"}.isdisjoint(names)
    assert {"Z_w", "X_udot", "C_d0", "C_dy"} <= set(names)
    assert (ekf.tuning.learns[ekf.model.first : ekf.model.size] == [1.0, 1.0] + [0.0] * (len(names) - 2)).all()
    shares = ekf.prior[ekf.model.first :] / np.abs(ekf.model.believed)
    np.testing.assert_allclose(shares, [0.7, 0.2] + [0.05] * (len(names) - 2))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return Path(shutil.copytree(CONFIGS, tmp_path / "config"))


def refused(folder: Path) -> str:
    with pytest.raises(ParamError) as caught:
        app.build({**config_files.read_configuration(folder), "mission": config_files.read_mission(folder), "kept": {}})
    assert "\n" not in str(caught.value)
    return str(caught.value)


def with_lines(text: str, table: str, lines: str) -> str:
    """A file's text with lines in a table, in the place of what its keys were before."""
    before, inside, after = re.split(rf"^(\[{re.escape(table)}\].*?)(?=^\[|\Z)", text, maxsplit=1, flags=re.M | re.S)
    for line in lines.splitlines():
        inside = re.sub(rf"^{line.partition(' ')[0]} = .*\n", "", inside, flags=re.M)
    head, _, rest = inside.partition("\n")
    return f"{before}{head}\n{lines}\n{rest}{after}"


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ('names = ["M_q", "M_sd"]', "no coefficient is called 'M_sd'; did you mean M_"),
        ('considered = ["Q_uux"]', "no coefficient is called 'Q_uux'; "),
        ('names = ["M_q", "N_r", "M_q"]', "'M_q' twice; name every coefficient once"),
        ('names = ["Y_dot", "M_q"]\nconsidered = ["Y_vdot"]', "'Y_dot' and 'Y_vdot' both hold Y_vdot"),
        ('names = ["M_q", "Y_dot", "Y_dot"]', "'Y_dot' twice"),
        ('names = ["rest"]', "no coefficient is called 'rest'"),
        (
            'names = ["M_q", "K_prop"]',
            "by; write its size there, or leave K_prop out of names here",
        ),
        ('considered = ["N_prop"]', "N_prop is 0 in the vehicle file, which gives no scale"),
        ("names = []", "names is empty; name the coefficients to learn"),
        ("current = false", "turbulence needs current = true"),
    ],
)
def test_a_list_that_cannot_be_learned_is_one_line_with_file_and_table(folder: Path, lines: str, words: str) -> None:
    path = folder / "autopilot.toml"
    path.write_text(with_lines(path.read_text(), "estimation.coefficients", lines))
    said = refused(folder)
    assert said.startswith(f"{path}: estimation")
    assert "coefficients: " in said
    assert words in said


def test_a_vehicle_without_inertia_in_some_direction_is_one_line_that_names_it(folder: Path) -> None:
    path = folder / "vehicle.toml"
    path.write_text(with_lines(path.read_text(), "coefficients", "K_pdot = 1.0"))
    assert "body, coefficients: the mass matrix is not positive definite, first in p_dot" in refused(folder)
