"""Scenario files: what is in them, what is refused and with which words, and the pilot who plays them."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import pytest

from firmware_py.params import ParamError
from firmware_py.records.order import Arming, Mode
from sim_bridge.scenarios import Completes, known, load_scenario, parse, scenario_path

FOLDER = Path(__file__).resolve().parents[3] / "configs" / "scenarios"
LEAST = {"description": "Nothing happens.", "duration_s": 10.0, "completes": "time"}


def test_every_shipped_scenario_can_be_read_and_describes_itself_in_a_sentence():
    names = known(FOLDER)
    assert {"learn-doublets", "learn-prbs", "learn-zigzag"} <= set(names)
    assert {"demo", "paper-depth", "paper-heading", "turning-circle", "zigzag"} <= set(names)
    for name in names:
        scenario = load_scenario(name, FOLDER)
        assert scenario.description.endswith(".")
        assert name == "station" or scenario.orders[0].arming is Arming.ARM
        assert all(cue.t < scenario.duration for cue in scenario.orders)
        deepest = max([scenario.start.depth, *(p.z for p in scenario.mission.waypoints)])
        assert scenario.environment.bottom_depth > deepest + 10


@pytest.mark.parametrize(
    "named", ["configs/scenarios/zigzag.toml", "scenarios/zigzag.toml", "./configs/scenarios/zigzag.toml"]
)
def test_a_shipped_scenario_is_found_by_its_file_from_any_folder_and_one_that_exists_is_that_file(
    named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert scenario_path(named, FOLDER) == FOLDER / "zigzag.toml"
    assert load_scenario(named, FOLDER) == load_scenario("zigzag", FOLDER)
    Path(named).parent.mkdir(parents=True)
    Path(named).touch()
    assert scenario_path(named, FOLDER) == Path(named)


@pytest.mark.parametrize("named", ["zigzag.toml", "configs/scenarios/zigzug.toml", "mine/scenarios/zigzag.toml"])
def test_another_file_that_there_is_not_stays_as_it_is(named: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert scenario_path(named, FOLDER) == Path(named)
    with pytest.raises(ParamError, match=f"^{named}: "):
        load_scenario(named, FOLDER)


def test_the_demo_is_the_flight_that_was_promised():
    demo = load_scenario("demo", FOLDER)
    assert demo.completes is Completes.SURFACED
    assert demo.start.depth == 0.0
    assert math.hypot(*demo.environment.current_ned) == pytest.approx(0.1)
    depths = [p.z for p in demo.mission.waypoints]
    assert sum(a != b for a, b in itertools.pairwise(depths)) == 2
    assert demo.orders[-1].mode is Mode.MISSION


def test_everything_a_scenario_may_say_arrives_in_si():
    scenario = parse(
        LEAST
        | {
            "environment": {"current_ned_m_s": [0.1, 0.0, 0.0], "bottom_depth_m": 30.0},
            "start": {"x_m": 1.0, "depth_m": 2.0, "psi_deg": 90.0, "u_m_s": 1.5, "n_rpm": 600.0},
            "orders": [
                {"t_s": 0.5, "arming": "arm"},
                {"t_s": 1.0, "mode": "hold", "depth_m": 3.0, "heading_deg": 180.0, "speed_m_s": 1.2},
                {"t_s": 2.0, "delta_r_deg": -10.0, "n_rpm": 60.0},
            ],
            "waypoints": [{"x_m": 1.0, "y_m": 2.0, "depth_m": 3.0, "speed_m_s": 1.0}],
            "faults": ["jam:rudder_upper@5"],
            "autopilot": {"control": {"depth": {"anything": "paper"}}},
            "vehicle_factors": {"coefficients": {"M_ds": 0.6}},
        },
        "here",
    )
    assert scenario.start.eta == (1.0, 0.0, 2.0, 0.0, 0.0, math.pi / 2)
    assert scenario.start.nu == (1.5, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert scenario.start.n == pytest.approx(10.0)
    assert scenario.orders[1].heading == pytest.approx(math.pi)
    assert math.isnan(scenario.orders[0].depth)
    assert scenario.orders[2].delta_r == pytest.approx(math.radians(-10))
    assert scenario.mission.waypoints == ((1.0, 2.0, 3.0, 1.0, False),)
    assert scenario.autopilot["control"] == {"depth": {"anything": "paper"}}
    assert scenario.vehicle_factors == {"coefficients": {"M_ds": 0.6}}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"duration_s": None}, "here: duration_s is missing"),
        ({"duration_s": "long"}, "here: duration_s = 'long': must be a number in s"),
        ({"durations_s": 3.0}, "here: durations_s is unknown; did you mean duration_s?"),
        ({"duration": 3.0}, "here: duration has the wrong unit; write duration_s"),
        ({"completes": "done"}, 'here: completes = \'done\': must be one of "surfaced", "time"'),
        ({"orders": [{"t_s": 0.0, "mode": "fly"}]}, "here: orders[0]: mode = 'fly': must be one of"),
        ({"orders": [{"t_s": -1.0}]}, "here: orders[0]: t_s = -1.0: out of bounds"),
        ({"orders": [{"t_s": 2.0}, {"t_s": 1.0}]}, "here: orders are not in order of t_s"),
        ({"orders": [{"t_s": 2.0, "mode": "mission"}]}, "there are no [[waypoints]]"),
        ({"items": [{"manoeuvre": {"kind": "spin"}}]}, "here: items[0]: manoeuvre: kind = 'spin': must be one of"),
        (
            {
                "items": [{"manoeuvre": {"kind": "prbs"}}],
                "waypoints": [{"x_m": 0.0, "y_m": 0.0, "depth_m": 1.0, "speed_m_s": 1.0}],
            },
            "here: there are [[waypoints]] and [[items]]",
        ),
        ({"waypoints": [{"x_m": 0.0, "y_m": 0.0, "depth_m": 1.0}]}, "here: waypoints[0]: speed_m_s is missing"),
        ({"faults": ["sink:ship@1"]}, "fault 'sink:ship@1': sink is not known; known: off"),
        ({"faults": ["jam:rudder_upper"]}, "fault 'jam:rudder_upper': write KIND:TARGET[=VALUE]@T"),
        (
            {"faults": ["off:dvl@11"]},
            "fault off:dvl@11: the scenario lasts 10 s; choose T below 10, or a longer scenario.duration_s",
        ),
        ({"environment": {"bottom": [{"north_m": 5.0, "depth_m": 9.0}] * 2}}, "bottom is not in order of north_m"),
        ({"environment": {"current": 3}}, "here: environment: current is unknown"),
        ({"start": 3}, "here: start must be a table"),
        (
            {"start": {"x_m": 2e5}},
            "here: start: x_m = 200000.0: out of bounds, must be a number in m in [-1",
        ),
        (
            {"start": {"depth_m": 50.0}, "environment": {"bottom_depth_m": 40.0}},
            "here: start: depth_m = 50 is below the bottom, which is 40 m deep there",
        ),
        (
            {"waypoints": [{"x_m": 0.0, "y_m": 1e300, "depth_m": 1.0, "speed_m_s": 1.0}]},
            "here: waypoints[0]: y_m = 1e+300: out of bounds",
        ),
        ({"autopilot": 3}, "here: autopilot must be a table"),
    ],
)
def test_what_is_wrong_is_named_in_one_line(change, words):
    table = {key: value for key, value in (LEAST | change).items() if value is not None}
    with pytest.raises(ParamError) as caught:
        parse(table, "here")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_unknown_scenario_names_the_known_ones():
    with pytest.raises(
        ParamError,
        match=r"unknown scenario 'dmo'; known: demo, learn-doublets, .*, paper-depth, .*zigzag; did you mean demo[?]$",
    ):
        load_scenario("dmo", FOLDER)


def test_a_folder_in_a_scenarios_place_is_said_to_be_one(tmp_path):
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(ParamError, match=r"folder\.toml: cannot be read \(Is a directory\)"):
        load_scenario(str(tmp_path / "folder.toml"), FOLDER)
    with pytest.raises(ParamError, match=r"unknown scenario '.*'; known: demo"):
        load_scenario(str(tmp_path), FOLDER)


def test_a_file_of_ones_own_can_be_named(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('description = "x."\nduration_s = 1\ncompletes = "time"\n')
    assert load_scenario(str(path), FOLDER).duration == 1.0


@pytest.mark.parametrize("content", [b"duration_s = = 1", b"\xff\xfe", b'description = "a\nb"'])
def test_a_file_that_is_not_toml_is_named(tmp_path, content):
    (tmp_path / "broken.toml").write_bytes(content)
    with pytest.raises(ParamError, match=r"broken\.toml") as caught:
        load_scenario("broken", tmp_path)
    assert "\n" not in str(caught.value)
