"""A truth that derives from a vehicle file: the same vehicle, but for what it says itself."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import pytest

from firmware_py.adapters.installation import configs
from firmware_py.params import ParamError
from sim_bridge.truth_file import read_truth

REST = """
[propeller]
x_m = -2.6
z_m = 0.0
diameter_m = 0.3

[servo]
tau_s = 0.1
rate_deg_s = 40.0
backlash_deg = 0.1
limit_deg = 23.0

[shaft]
tau_s = 0.3
rate_rpm_s = 400.0
limit_rpm = 1000.0

[drop_weight]
r_m = [1.75, 0.0, 0.15]
"""
FINS = """
[[fins]]
name = "rudder_lower"
centre_m = [-2.3, 0.0, 0.42]
span_m = 0.31

[[fins]]
name = "rudder_upper"
centre_m = [-2.3, 0.0, -0.42]
span_m = 0.31

[[fins]]
name = "stern_starboard"
centre_m = [-2.3, 0.42, 0.0]
span_m = 0.05

[[fins]]
name = "stern_port"
centre_m = [-2.3, -0.42, 0.0]
span_m = 0.05
"""
SHIPPED = read_truth(configs() / "npsauv2" / "truth.toml")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return Path(shutil.copytree(configs() / "npsauv2", tmp_path / "boat"))


def derived(folder: Path, text: str, of: str = "vehicle.toml") -> Path:
    path = folder / "truth.toml"
    path.write_text(f'derives = "{of}"\n{text}')
    return path


def test_the_shipped_vehicle_file_makes_the_shipped_truth_whatever_the_order_of_fins(folder: Path) -> None:
    found = read_truth(derived(folder, REST + FINS))
    bow = {"X_dbdb": SHIPPED.coefficients.X_dbdb}  # the one coefficient that a vehicle file does not know
    assert found.coefficients == dataclasses.replace(SHIPPED.coefficients, X_dbdb=0.0)
    assert dataclasses.replace(found.coefficients, **bow) == SHIPPED.coefficients
    for part in ("body", "hull", "servo", "shaft", "fins", "drop_weight"):
        assert getattr(found, part) == getattr(SHIPPED, part)
    assert found.propeller.eta_n == pytest.approx(SHIPPED.propeller.eta_n, rel=1e-12)


def test_what_is_said_here_differs_and_the_rest_does_not(folder: Path) -> None:
    text = f"{REST}{FINS}effectiveness = 0.5\n\n[coefficients]\nM_q = -0.05\n\n[body]\nB_n = 53500.0\n"
    found = read_truth(derived(folder, text))
    assert (found.coefficients.M_q, found.coefficients.Z_w) == (-0.05, SHIPPED.coefficients.Z_w)
    assert (found.body.B, found.body.W) == (53500.0, SHIPPED.body.W)
    assert [fin.effectiveness for fin in found.fins] == [0.5, 1.0, 1.0, 1.0]


def test_a_coefficient_that_neither_file_has_is_zero(folder: Path) -> None:
    vehicle = folder / "vehicle.toml"
    vehicle.write_text(vehicle.read_text().replace("N_vw = -2.7e-2\n", ""))
    assert read_truth(derived(folder, REST + FINS)).coefficients.N_vw == 0.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (REST, ("truth.toml (with what it derives from vehicle.toml): fins[0]: centre_m is missing",)),
        (REST + FINS.replace("rudder_lower", "rudder"), ("fins: 'rudder' is not in", "stern_port", "rudder_lower")),
        (f"{REST}{FINS}\n[coefficients]\nM_qq = 1.0\n", ("coefficients: M_qq is unknown",)),
        (FINS, ("propeller: x_m is missing",)),
        (f"fins = 3\n{REST}", ("fins must be a list of tables",)),
    ],
)
def test_what_is_missing_or_foreign_is_one_line(folder: Path, text: str, words: tuple[str, ...]) -> None:
    with pytest.raises(ParamError) as caught:
        read_truth(derived(folder, text))
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("change", ["", "fins = 1", "hull = 1", "propeller = {}", "[coefficients]"])
def test_a_vehicle_file_that_is_none_is_one_line(folder: Path, change: str) -> None:
    (folder / "boat.toml").write_text(change)
    with pytest.raises(ParamError, match="boat"):
        read_truth(derived(folder, REST + FINS, "boat.toml"))
    with pytest.raises(ParamError, match="cannot be read"):
        read_truth(derived(folder, REST + FINS, "no.toml"))
