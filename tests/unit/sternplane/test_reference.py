from __future__ import annotations

import re
import tomllib

import numpy as np
import pytest
import sternplane
from sternplane.codegen import configuration_reference

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.config_files import merge
from firmware_py.params import ParamError, load
from firmware_py.reconfiguration import AutopilotParams
from sim_bridge.faults.catalogue import KINDS


def test_the_reference_of_every_key_is_up_to_date() -> None:
    assert configuration_reference.PATH.read_text() == configuration_reference.page(), (
        "run: .venv/bin/python -m sternplane.codegen.configuration_reference"
    )


def test_the_small_scenario_flies_and_a_later_order_keeps_what_it_does_not_name() -> None:
    scenario = {**tomllib.loads(configuration_reference.SCENARIO), "duration_s": 89.0}
    flight = sternplane.fly(scenario, set={"autopilot.estimation.learning.enabled": False})
    c = flight.recording.columns
    depth, heading = c["reference.z_d"][-1], np.degrees(c["reference.psi_d"][-1])
    assert flight.completed
    assert (depth, heading) == pytest.approx((8.0, 90.0), abs=1.0)
    assert flight.recording.truth["z"][-1] == pytest.approx(8.0, abs=0.4)


def test_the_reference_names_every_fault_and_every_file() -> None:
    page = configuration_reference.page()
    for kind in KINDS:
        assert f"{kind.name}:{kind.group}" in page
    files = {
        path.name
        for path in (configuration_reference.PATH.parent / "npsauv2").glob("*.toml")
        if not path.name.startswith("io_")
    }
    for name in files | {"io_*.toml", "mission.toml", "scenarios/*.toml"}:
        assert f"## {name}\n" in page


def test_the_actions_of_a_key_are_those_that_it_takes() -> None:
    """A rule such as that of the lost depth leaves neither depth nor way to hold or to return with."""
    rows = re.findall(r"`safety\.(\w+_action)` .*One of ([^|]*)\. \|", configuration_reference.page())
    listed = {key: set(re.findall(r'"(\w+)"', words)) for key, words in rows}
    assert listed["depth_action"] == {"none", "warn", "surface", "surface_and_drop"}
    assert listed["leak_action"] == {"none", "warn", "return", "surface", "surface_and_drop"}
    assert listed["dvl_action"] == {"none", "warn", "hold", "return", "surface", "surface_and_drop"}
    shipped = read_toml(configs() / "npsauv2" / "autopilot.toml")
    for key, taken in listed.items():
        for action in listed["dvl_action"] - taken:
            with pytest.raises(ParamError, match=f'{key} = "{action}"'):
                load(AutopilotParams, merge(shipped, {"safety": {key: action}}), "")
        for action in taken:
            load(AutopilotParams, merge(shipped, {"safety": {key: action}}), "")
