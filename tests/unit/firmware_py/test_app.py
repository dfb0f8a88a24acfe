"""The composition root: what files say, and what is said of files that say it wrong."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

from firmware_py import app, config_files
from firmware_py.params import ParamError

SHIPPED = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
GOOD = """
[[waypoints]]
x_m = 100
y_m = -20.5
depth_m = 5.0
speed_m_s = 1.8
[[waypoints]]
x_m = 0.0
y_m = 0.0
depth_m = 0.0
speed_m_s = 0.0
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return Path(shutil.copytree(SHIPPED, tmp_path / "config"))


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def built(folder: Path) -> app.Autopilot:
    configuration, mission = config_files.read_configuration(folder), config_files.read_mission(folder)
    return app.build({**configuration, "mission": mission, "kept": {}})


def refused(folder: Path, over: dict | None = None) -> str:
    with pytest.raises(ParamError) as caught:
        config_files.read_configuration(folder, over)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_configuration_without_a_mission_has_none(folder: Path) -> None:
    assert not (folder / "mission.toml").exists()
    assert config_files.read_mission(folder) == {"waypoints": [], "manoeuvres": []}


def test_a_mission_is_read_as_the_autopilot_takes_it(folder: Path) -> None:
    (folder / "mission.toml").write_text(GOOD)
    assert config_files.read_mission(folder)["waypoints"] == [[100.0, -20.5, 5.0, 1.8], [0.0, 0.0, 0.0, 0.0]]
    assert not built(folder).parts.guidance.finished


ITEMS = """
[[items]]
waypoint = { x_m = 100, y_m = 0.0, depth_m = 20.0, speed_m_s = 0.0 }
[[items]]
manoeuvre = { kind = "prbs", duration_s = 60.0 }
"""


def test_a_mission_of_items_reaches_the_guidance(folder: Path) -> None:
    (folder / "mission.toml").write_text(ITEMS)
    mission = config_files.read_mission(folder)
    assert mission["waypoints"] == [[100.0, 0.0, 20.0, 0.0]]
    assert [(m["after"], m["kind"], m["duration_s"]) for m in mission["manoeuvres"]] == [(1, "prbs", 60.0)]
    only = {**mission, "waypoints": [], "manoeuvres": [{**mission["manoeuvres"][0], "after": 0}]}
    autopilot = app.build({**config_files.read_configuration(folder), "mission": only, "kept": {}})
    assert not autopilot.parts.guidance.finished


def test_waypoints_beside_items_are_refused_by_file(folder: Path) -> None:
    (folder / "mission.toml").write_text(GOOD + ITEMS)
    with pytest.raises(ParamError, match=r"mission\.toml: there are \[\[waypoints\]\] and \[\[items\]\]"):
        config_files.read_mission(folder)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("x_m = 100", "x_m = 1e6", "waypoints[0]: x_m = 1000000.0: out of bounds, must be a number in m in [-100000"),
        ("depth_m = 0.0", "", "waypoints[1]: depth_m is missing"),
        ("depth_m = 0.0", "z_m = 0.0", "waypoints[1]: z_m is unknown; did you mean y_m?"),
        ("speed_m_s = 0.0", 'speed_m_s = "fast"', "waypoints[1]: speed_m_s = 'fast': must be a number in m/s"),
        ("[[waypoints]]", "[waypoints]", "is not TOML"),
        ("depth_m = 5.0", "depth_m = 31.0", "waypoints[0]: depth 31.0 m is over safety.depth_max_m = 30"),
        ("speed_m_s = 1.8", "speed_m_s = 2.6", "waypoints[0]: speed_m_s = 2.6 is over guidance.speed_max_m_s = 2.5"),
    ],
)
def test_a_mission_that_cannot_be_flown_is_one_line_with_file_and_key(
    folder: Path, old: str, new: str, words: str
) -> None:
    path = folder / "mission.toml"
    path.write_text(GOOD.replace(old, new, 1))
    with pytest.raises(ParamError) as caught:
        config_files.read_mission(folder)
    assert str(caught.value).startswith(f"{path}: {words}")


def test_a_folder_in_a_missions_place_is_said_to_be_one(folder: Path) -> None:
    (folder / "mission.toml").mkdir()
    with pytest.raises(ParamError, match=r"mission\.toml: cannot be read \(Is a directory\)"):
        config_files.read_mission(folder)


def test_a_mistake_is_looked_for_in_the_file_first_and_then_in_what_is_laid_over_it(folder: Path) -> None:
    path = folder / "autopilot.toml"
    over = {"control": {"law": "pid"}}
    merged = config_files.read_configuration(folder, over)["autopilot"]
    assert merged == config_files.merge(tomllib.loads(path.read_text()), over)
    assert merged["control"]["u_min_m_s"] == 0.5
    said = refused(folder, {"control": {"gains": "fuzzy"}})
    assert said.startswith(f"{path} under the scenario's [autopilot]: control: gains = 'fuzzy': must be one of")
    edit(path, "depth_max_m = 30.0", "depth_max_m = -3.0")
    for laid in (over, {"control": {"gains": "fuzzy"}}, {"safety": {"depth_max_m": 20.0}}, {}):
        assert refused(folder, laid).startswith(f"{path}: safety: depth_max_m = -3.0: out of bounds")


def test_factors_multiply_numbers_of_the_vehicle_file(folder: Path) -> None:
    table = tomllib.loads((folder / "vehicle.toml").read_text())
    factors = {"coefficients": {"M_ds": 1.4}, "propeller": {"n_max_rpm": 0.5}}
    made = config_files.read_configuration(folder, factors=factors)["vehicle"]
    assert made["coefficients"]["M_ds"] == 1.4 * table["coefficients"]["M_ds"]
    assert made["propeller"]["n_max_rpm"] == 0.5 * table["propeller"]["n_max_rpm"]
    assert made["coefficients"]["M_q"] == table["coefficients"]["M_q"]


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ({"coefficients": {"M_dx": 1.4}}, "coefficients: 'M_dx' is no number of vehicle.toml"),
        ({"coefficients": 1.4}, "'coefficients' is no number of vehicle.toml"),
        ({"coefficients": {"M_ds": "much"}}, "coefficients: 'M_ds' is no number of vehicle.toml"),
        ({"name": 2.0}, "'name' is no number of vehicle.toml"),
        ({"propeller": {"n_max_rpm": -1.0}}, "propeller: n_max_rpm = -"),
        ({"coefficients": {"M_ds": True}}, "coefficients: 'M_ds' is no number of vehicle.toml"),
        ({"coefficients": {"M_ds": 10**400}}, "coefficients: 'M_ds': the factor 1e400"),
    ],
)
def test_a_factor_for_what_is_no_number_is_refused(folder: Path, factors: dict[str, Any], words: str) -> None:
    with pytest.raises(ParamError) as caught:
        config_files.read_configuration(folder, factors=factors)
    assert str(caught.value).startswith(f"{folder / 'vehicle.toml'} times the scenario's [vehicle_factors]: {words}")


@pytest.mark.parametrize("name", ["autopilot", "vehicle"])
def test_a_file_that_is_missing_is_named(folder: Path, name: str) -> None:
    (folder / f"{name}.toml").unlink()
    assert refused(folder) == f"{folder / name}.toml: cannot be read (No such file or directory)"


@pytest.mark.parametrize("name", ["nowhere", "n" * 300])
def test_a_folder_that_is_none_is_named_with_an_example(folder: Path, name: str) -> None:
    assert refused(folder / name).startswith(f"{folder / name}: there is no such configuration folder")


def test_of_a_file_that_is_given_for_its_folder_that_is_said() -> None:
    file = SHIPPED / "autopilot.toml"
    assert refused(file) == f"{file}: is a file; give its folder, {SHIPPED}"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("M_ds = -4.1e-2", "M_ds = -1e-300", "coefficients: the model (A, b) is not controllable"),
        ("M_qdot = -1.7e-2", "M_qdot = 1.0", "coefficients: M_qdot = 1 leaves no inertia in pitch"),
        ("Y_vdot = -5.5e-2", "Y_vdot = 1.0", "coefficients: Y_vdot, "),
    ],
)
def test_a_vehicle_that_no_law_can_be_made_for_is_named_by_its_file(
    folder: Path, old: str, new: str, words: str
) -> None:
    path = folder / "vehicle.toml"
    edit(path, old, new)
    with pytest.raises(ParamError) as caught:
        built(folder)
    assert str(caught.value).startswith(f"{path}: {words}")
