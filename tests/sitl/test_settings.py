"""What is set for a simulated flight: it is flown, it stands in log and summary, and the log replays."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from sternplane.logs.reading import read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import FlightRequest, prepare
from sternplane.sitl.request import parse_settings, read_scenario

from firmware_py.app import build
from firmware_py.params import ParamError
from tests.command import called
from tests.shared_flights import BRIEF

SET = {
    "vehicle.coefficients.M_q": -0.05,
    "truth.current_m_s": 0.25,
    "autopilot.control.law": "pid",
    "truth.fins.rudder_upper.effectiveness": 0.5,
    "sensors.dvl.rate_hz": 4,
    "io.can.node_id": 50,
    "scenario.duration_s": 2,
}


def asked(*settings: str) -> FlightRequest:
    return FlightRequest("demo", settings=settings)


def test_what_is_set_is_what_flies_whatever_the_scenario_says() -> None:
    flight = prepare(asked(*[f"{key}={value}" for key, value in SET.items()]), {})
    assert flight.configuration["vehicle"]["coefficients"]["M_q"] == -0.05
    assert flight.params.control.law.name == "PID"
    assert [fin.effectiveness for fin in flight.truth.fins] == [1.0, 1.0, 0.5, 1.0]
    assert (flight.devices.dvl.rate, flight.io.can.node_id, flight.scenario.duration) == (4, 50, 2.0)
    assert flight.header()["settings"] == SET


def test_the_current_keeps_its_direction_and_flows_north_where_there_was_none() -> None:
    north, east, _ = read_scenario(asked("truth.current=0.3")).environment.current_ned
    assert (math.hypot(north, east), math.atan2(east, north)) == pytest.approx((0.3, math.atan2(0.08, 0.06)))
    turned = read_scenario(asked("truth.current_towards=90", "truth.current=0.2")).environment.current_ned
    assert turned == pytest.approx((0.0, 0.2, 0.0))
    still = FlightRequest("zigzag", settings=("truth.current=0.3",))
    assert read_scenario(still).environment.current_ned == (0.3, 0.0, 0.0)
    both = read_scenario(asked("truth.current_ned_m_s=[0, 0.1, 0.02]", "truth.turbulence=0.1")).environment
    assert (both.current_ned, both.turbulence) == ((0.0, 0.1, 0.02), 0.1)


def test_of_one_key_the_last_value_holds() -> None:
    assert [setting.value for setting in parse_settings(["truth.current=1", "truth.current_m_s=0.5"])] == [0.5]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("control.adoption.enabled=false", r"did you mean autopilot\.control\.adoption\.enabled\?$"),
        ("M_q=-0.05", r"did you mean vehicle\.coefficients\.M_q or truth\.coefficients\.M_q\?$"),
        ("control.nosuch=1", "'control' is no file"),
        ("truth.curent=1", r"did you mean truth.current\?"),
        ("truth.current=-1", r"current_m_s = -1: out of bounds"),
        ("scenario.waypoints.9.depth_m=5", "no entry '9'; there: 0 to 4"),
        ("truth.M_q=99", r"truth.toml with truth.coefficients.M_q set: coefficients: M_q = 99"),
    ],
)
def test_what_cannot_be_set_is_told_in_one_line(text: str, said: str) -> None:
    with pytest.raises(ParamError, match=said):
        prepare(asked(text), {})


def test_a_flight_tells_what_was_set_and_its_log_replays(tmp_path: Path) -> None:
    (tmp_path / "brief.toml").write_text(BRIEF)
    words = [word for key, value in SET.items() if key != "scenario.duration_s" for word in ("--set", f"{key}={value}")]
    done = called("sitl", "--scenario", "brief.toml", "--out", "run", "--no-report", *words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "sternplane: autopilot.control.law = pid set" in done.stderr
    folder = tmp_path / "run"
    assert not (folder / "report.html").exists()
    assert json.loads((folder / "summary.json").read_text())["settings"].items() <= SET.items()
    log = read(folder / "log.mcap")
    assert log.header["settings"] == {key: value for key, value in SET.items() if key != "scenario.duration_s"}
    assert replay(log, build).equal


def test_a_plant_in_another_process_has_what_was_set_too(tmp_path: Path, bus_spec: str) -> None:
    (tmp_path / "brief.toml").write_text(BRIEF)
    words = (
        "sitl",
        "--scenario",
        "brief.toml",
        "--no-report",
        "--set",
        "truth.current=0.5",
        "--set",
        "scenario.start.x=7",
    )
    for name, bus in (("one", "virtual"), ("two", bus_spec)):
        done = called(*words, "--bus", bus, "--out", name, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    one, two = (read(tmp_path / name / "log.mcap") for name in ("one", "two"))
    assert one.cycle_bytes == two.cycle_bytes
    assert two.truth["eta.x"][0] == pytest.approx(7.0, abs=0.01)
    assert two.truth["current"][0] == pytest.approx([0.5, 0.0, 0.0])
