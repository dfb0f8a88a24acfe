"""What an earlier run left and cannot be used is set aside with a sentence; what the user gives is an error still."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from firmware_py import app, config_files
from firmware_py.adapters.installation import configs
from firmware_py.adapters.io_params import StateParams
from firmware_py.estimation.navigation.navigation import KeptNavigation
from firmware_py.params import ParamError
from firmware_py.run import kept_navigation, kept_plans
from firmware_py.run.kept_plans import with_kept_plans
from firmware_py.run.resumed_state import changed_by_stations, resume_state, set_aside_unusable
from firmware_py.run.usage_error import UsageError

CONFIG = configs() / "npsauv2"
BAD = {
    "navigation.json": ["", "{", '{"x": 1}', "[" * 100_000, "\0" * 100],
    "parameters.toml": ["rate_hz = ", "[safety]\ndepth_max_m = -3.0\n", "[nothing]\nx = 1\n", "\0" * 100],
    "mission.json": ["", "{", "[]", '{"items": [{}]}', '{"items": 7}', "[" * 100_000],
    "fence.json": ["", '{"items": [[1, 2]]}'],
    "rally.json": ["null"],
}
INSTEAD = {
    "navigation.json": "position, depth of the surface and mode begin as in a first run",
    "parameters.toml": "the values of autopilot.toml hold now",
    "mission.json": "no mission that a station sent is in force",
    "fence.json": "no fence that a station sent is in force",
    "rally.json": "no rally point that a station sent is in force",
}


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize(("name", "content"), [(name, content) for name, all_ in BAD.items() for content in all_])
def test_a_file_that_cannot_be_used_is_renamed_and_told_and_the_rest_can_be_read(
    tmp_path: Path, name: str, content: str
) -> None:
    (tmp_path / name).write_text(content)
    [sentence] = set_aside_unusable(CONFIG, None, tmp_path)
    assert "\n" not in sentence
    assert sentence.startswith(f"{tmp_path / name}: cannot be used, and is set aside as {name}.corrupt-1: ")
    assert sentence.count(str(tmp_path)) == 1
    assert sentence.endswith(f"; {INSTEAD[name]}")
    assert len(sentence) < 500
    assert names(tmp_path) == {f"{name}.corrupt-1"}
    assert (tmp_path / f"{name}.corrupt-1").read_text() == content
    configuration = {**config_files.read_configuration(CONFIG, None, tmp_path), "mission": {"waypoints": []}}
    with_kept_plans(configuration, tmp_path)
    assert kept_navigation.load_navigation(tmp_path) == {}


def test_whatever_a_plan_raises_where_it_is_flown_from_sets_it_aside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_: object) -> None:
        raise TypeError("a defect of ours")

    (tmp_path / "mission.json").write_text('{"items": []}')
    monkeypatch.setattr(kept_plans, "mission_to_plain", broken)
    [sentence] = set_aside_unusable(CONFIG, None, tmp_path)
    assert "is set aside as mission.json.corrupt-1: a defect of ours; no mission that a station sent" in sentence


def test_none_displaces_another_and_none_is_told_twice(tmp_path: Path) -> None:
    for n in range(1, 4):
        (tmp_path / "navigation.json").write_text(f"{{ {n}")
        (tmp_path / "mission.json").write_text("{")
        assert len(set_aside_unusable(CONFIG, None, tmp_path)) == 2
        assert set_aside_unusable(CONFIG, None, tmp_path) == []
        assert (tmp_path / f"navigation.json.corrupt-{n}").read_text() == f"{{ {n}"


def test_a_weight_that_was_released_is_remembered_until_the_file_is_removed(tmp_path: Path) -> None:
    (tmp_path / kept_navigation.WEIGHT_FILE).write_text("LEAK, at 30.00 s\n")
    kept, (note,) = resume_state(CONFIG, None, tmp_path, StateParams())
    assert kept == {"weight_gone": 1.0}
    assert note.endswith(f"fit another one, and remove {tmp_path / kept_navigation.WEIGHT_FILE}")
    configuration = {**config_files.read_configuration(CONFIG), "mission": {"waypoints": []}, "kept": kept}
    assert app.build(configuration).parts.supervisor.freeze().weight_gone
    (tmp_path / kept_navigation.WEIGHT_FILE).unlink()
    assert resume_state(CONFIG, None, tmp_path, StateParams()) == ({}, [])


@pytest.mark.parametrize(
    ("air", "taken"),
    [(101_325.0, True), (103_325.0, True), (99_325.0, True), (103_500.0, False), (99_000.0, False), (115_000.0, False)],
)
def test_an_air_pressure_is_taken_over_within_the_window_in_which_it_is_zeroed(
    tmp_path: Path, air: float, taken: bool
) -> None:
    kept_navigation.save(tmp_path, KeptNavigation(1.0, 2.0, 3.0, air))
    kept, (place, *doubts) = resume_state(CONFIG, None, tmp_path, StateParams())
    assert place.startswith("position kept")
    assert (kept["x"], kept["y"]) == (1.0, 2.0)
    assert kept["surface_pressure"] == (air if taken else 101_325.0)
    assert len(doubts) == (not taken)
    if air == 115_000.0:
        assert doubts == [
            "air pressure kept, 115000 Pa, is 13675 Pa off surface_pressure_pa, more than zero_window_pa, and set "
            "aside: depths would be 1.4 m too small; 101325 Pa holds, to 0.2 m of depth"
        ]


def test_on_a_mountain_lake_the_air_is_that_of_the_configuration(tmp_path: Path) -> None:
    lake = {"estimation": {"depth": {"surface_pressure_pa": 82_000.0}}}
    kept_navigation.save(tmp_path, KeptNavigation(1.0, 2.0, 3.0, 81_500.0))
    assert resume_state(CONFIG, lake, tmp_path, StateParams())[0]["surface_pressure"] == 81_500.0
    kept_navigation.save(tmp_path, KeptNavigation(1.0, 2.0, 3.0, 101_325.0))
    assert resume_state(CONFIG, lake, tmp_path, StateParams())[0]["surface_pressure"] == 82_000.0


def test_what_can_be_used_stays(tmp_path: Path) -> None:
    kept_navigation.save(tmp_path, KeptNavigation(1.0, 2.0, 3.0, 101_325.0))
    (tmp_path / "parameters.toml").write_text("[safety]\ndepth_max_m = 25.0\n")
    (tmp_path / "signing").write_text("?")
    before = names(tmp_path)
    assert set_aside_unusable(CONFIG, None, tmp_path) == []
    assert names(tmp_path) == before
    assert set_aside_unusable(CONFIG, None, tmp_path / "new") == []


def test_what_is_no_file_is_set_aside_without_being_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "navigation.json")
    (tmp_path / "mission.json").mkdir()
    assert len(set_aside_unusable(CONFIG, None, tmp_path)) == 2
    assert names(tmp_path) == {"navigation.json.corrupt-1", "mission.json.corrupt-1"}


def test_a_configuration_of_the_users_is_an_error_and_the_state_stays(tmp_path: Path) -> None:
    config, state = tmp_path / "config", tmp_path / "state"
    shutil.copytree(CONFIG, config)
    state.mkdir()
    (state / "parameters.toml").write_text("[safety]\ndepth_max_m = 25.0\n")
    path = config / "autopilot.toml"
    path.write_text(path.read_text().replace("depth_max_m = 30.0", "depth_max_m = -3.0"))
    with pytest.raises(ParamError, match=r"autopilot\.toml"):
        set_aside_unusable(config, None, state)
    assert names(state) == {"parameters.toml"}


def test_a_file_in_the_folders_place_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("precious")
    with pytest.raises(UsageError, match="is not a folder; choose another"):
        set_aside_unusable(CONFIG, None, tmp_path / "state")
    assert (tmp_path / "state").read_text() == "precious"


def test_what_stations_changed_for_good_is_told_at_the_next_start(tmp_path: Path) -> None:
    (tmp_path / "parameters.toml").write_text("[control.adoption]\nenabled = false\n[safety]\ndepth_max_m = 25.5\n")
    _, notes = resume_state(CONFIG, None, tmp_path, StateParams())
    shipped = config_files.read_configuration(CONFIG)["autopilot"]["safety"]["depth_max_m"]
    assert notes == [
        f"changed by stations in an earlier run, and kept in {tmp_path / 'parameters.toml'}: "
        f"control.adoption.enabled = false (true without); safety.depth_max_m = 25.5 ({shipped:g} without)"
    ]


def test_of_many_changed_parameters_ten_are_named_and_the_rest_is_counted() -> None:
    keys = {f"safety.k{i}": 1.0 for i in range(12)}
    table = {"safety": {f"k{i}": 2.0 for i in range(12)}}
    said = changed_by_stations({"autopilot": table, "changed": keys}, Path("parameters.toml"))
    assert said.count(" = 2 (1 without)") == 10
    assert said.endswith("; and 2 more")
    assert changed_by_stations({"autopilot": table, "changed": {}}, Path("parameters.toml")) == ""
