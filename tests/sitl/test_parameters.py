"""Parameters over real UDP between real processes: pymavlink's mavutil and mavparm at the other end of a flight."""

from __future__ import annotations

import struct
import tomllib
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavparm, mavutil
from sternplane.logs.reading import read
from sternplane.logs.replay import replay

from firmware_py import app, config_files
from firmware_py.app import build
from firmware_py.records.order import ParameterChange
from tests.sitl.stations import flight

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "npsauv2"
REAL, INT = mavutil.mavlink.MAV_PARAM_TYPE_REAL32, mavutil.mavlink.MAV_PARAM_TYPE_INT32


def fetched(station: Any) -> dict[str, Any]:
    """Every parameter by its name, as the station's own list has it."""
    station.param_fetch_all()
    found: dict[str, Any] = {}
    while not found or len(found) < next(iter(found.values())).param_count:
        message = station.recv_match(type="PARAM_VALUE", blocking=True, timeout=30)
        assert message is not None, f"{len(found)} came"
        found[message.param_id] = message
    return found


def value(station: Any, name: str) -> float:
    station.param_fetch_one(name)
    message = station.recv_match(
        type="PARAM_VALUE", condition=f"PARAM_VALUE.param_id=='{name}'", blocking=True, timeout=30
    )
    assert message is not None
    return float(message.param_value)


@pytest.mark.timeout(300)
def test_a_person_changes_parameters_in_flight_and_finds_them_after_a_restart(tmp_path: Path) -> None:
    state, mavset = tmp_path / "state", mavparm.MAVParmDict().mavset
    configuration = {**config_files.read_configuration(CONFIG), "mission": {"waypoints": []}}
    expected = {s.name: s for s in app.parameter_store(configuration).settings}
    with flight(tmp_path / "first", state) as station:
        told = fetched(station)
        assert [*sorted(told, key=lambda name: told[name].param_index)] == [*expected]
        for name, message in told.items():
            assert message.param_value == pytest.approx(expected[name].value, rel=1e-6)
            assert message.param_type == (INT if expected[name].is_integer else REAL)
        assert mavset(station, "CTL_Z_DELTA_SW", 0.3)
        assert mavset(station, "SAF_LATE_MAX", 500, parm_type=None)
        texts: list[str] = []
        station.message_hooks.append(lambda _, m: texts.append(m.text) if m.get_type() == "STATUSTEXT" else None)
        assert mavset(station, "SAF_DEPTH_MAX", 1e9)
        assert "SAF_DEPTH_MAX stays 30: 1e+09 is not in [1, 6000] m"[:50] in texts
        assert value(station, "SAF_DEPTH_MAX") == 30.0
    assert tomllib.loads((state / "parameters.toml").read_text()) == {
        "control": {"depth": {"delta_sw_rad": 0.3}},
        "safety": {"late_max": 500},
    }
    log = read(tmp_path / "first" / "log.mcap")
    assert [change for changes in log.changes.values() for change in changes] == [
        ParameterChange((("control.depth.delta_sw_rad", 0.3),)),
        ParameterChange((("safety.late_max", 500),)),
    ]
    assert replay(log, build).equal

    with flight(tmp_path / "second", state, "generic") as station:
        assert value(station, "CTL_Z_DELTA_SW") == pytest.approx(0.3)
        assert struct.unpack("<i", struct.pack("<f", value(station, "SAF_LATE_MAX"))) == (500,)
        assert mavset(station, "SAF_LATE_MAX", 10, parm_type=INT)
    assert tomllib.loads((state / "parameters.toml").read_text()) == {"control": {"depth": {"delta_sw_rad": 0.3}}}
    header = read(tmp_path / "second" / "log.mcap").header["configuration"]
    assert header["autopilot"]["control"]["depth"]["delta_sw_rad"] == 0.3
