"""A vehicle file that a tool writes is read as it was meant, or not written at all."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sternplane.identification import vehicle_file

from firmware_py.adapters.storage.recorder import LogError
from firmware_py.params import ParamError, load
from firmware_py.vehicle.vehicle import Vehicle

SOURCE = Path(__file__).resolve().parents[3] / "configs" / "npsauv2" / "vehicle.toml"


@pytest.fixture
def table() -> dict[str, Any]:
    return tomllib.loads(SOURCE.read_text())


@given(st.floats(-10.0, -1e-300), st.floats(-10.0, 10.0), st.text(min_size=1).filter(lambda text: text.strip()))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30)
def test_every_number_and_name_comes_back_to_the_last_bit(
    tmp_path: Path, table: dict[str, Any], damping: float, lift: float, name: str
) -> None:
    table = copy.deepcopy(table)
    table["name"], table["fins"][0]["name"] = name, f"port {name}"
    table["coefficients"] |= {"M_ds": damping, "Y_r": lift}
    vehicle_file.write(tmp_path / "vehicle.toml", table, "from somewhere\n\nin two parts")
    text = (tmp_path / "vehicle.toml").read_bytes().decode()
    assert text.startswith("# from somewhere\n#\n# in two parts\n")
    assert tomllib.loads(text) == table
    assert load(Vehicle, tomllib.loads(text), "it").coefficients.M_ds == damping


def test_what_is_no_vehicle_leaves_the_old_file(tmp_path: Path, table: dict[str, Any]) -> None:
    path = tmp_path / "vehicle.toml"
    vehicle_file.write(path, table, "good")
    before = path.read_bytes()
    table["coefficients"]["M_ds"] = 0.04
    with pytest.raises(ParamError, match=r"vehicle\.toml: .*M_ds must be negative"):
        vehicle_file.write(path, table, "bad")
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_is_not_there_is_named(tmp_path: Path, table: dict[str, Any]) -> None:
    with pytest.raises(LogError, match=r"nowhere/vehicle\.toml: cannot be written"):
        vehicle_file.write(tmp_path / "nowhere" / "vehicle.toml", table, "")
