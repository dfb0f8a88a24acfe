"""Parameters that are right by themselves and contradict each other: refused in a file, and from a station."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from firmware_py import app, config_files
from firmware_py.params import ParamError

SHIPPED = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"

CASES = [
    ({"safety.surface_depth_m": 0.0}, "surface_depth_m = 0.0: out of bounds"),
    (
        {"safety.surface_depth_m": 1.4, "safety.depth_max_m": 1.2},
        "surface_depth_m = 1.4 is not above depth_max_m = 1.2",
    ),
    ({"safety.surface_depth_m": 1.6}, "surface_depth_m = 1.6: out of bounds"),
    ({"safety.submerged_depth_m": 10.0}, "submerged_depth_m = 10.0: out of bounds"),
    (
        {"safety.surface_depth_m": 0.9, "safety.ascent.level_depth_m": 0.8},
        "level_depth_m = 0.8 is less than surface_depth_m = 0.9",
    ),
    ({"safety.ascent.level_depth_m": 20.0}, "level_depth_m = 20.0: out of bounds"),
    ({"safety.ascent.level_pitch_deg": 0.0}, "level_pitch_deg = 0.0: out of bounds"),
    ({"safety.ascent.climb_time_s": 600.0}, "climb_time_s = 600.0: out of bounds"),
    ({"safety.ascent.wait_time_s": 3600.0}, "wait_time_s = 3600.0: out of bounds"),
    ({"safety.ascent.tell_period_s": 3600.0}, "tell_period_s = 3600.0: out of bounds"),
    ({"safety.ascent.pitch_deg": 3.0}, "at safety.ascent.pitch_deg = 3 comes up by 0.08 m/s"),
    ({"safety.surface_depth_m": 1.2}, "surface_depth_m = 1.2 is over submerged_depth_m = 1"),
    ({"safety.altitude_min_m": 100.0}, "altitude_min_m = 100.0: out of bounds"),
    ({"safety.battery_min_pct": 50.0}, "battery_min_pct = 50 is not below battery_arm_pct = 20"),
    ({"safety.battery_warn_pct": 5.0}, "battery_warn_pct = 5 is not above battery_min_pct = 10"),
    ({"safety.battery_warn_pct": 10.0}, "battery_min_pct = 10: the warning would come too late"),
    ({"safety.station.hold_action": "hold"}, 'hold_action = "hold": it holds already, and would never come up'),
    ({"safety.leak_action": "hold"}, 'leak_action = "hold": it would stay under water, or beyond the fence'),
    ({"safety.sunk_action": "return"}, 'must be one of "none", "warn", "surface", "surface_and_drop"'),
    ({"safety.attitude_timeout_s": 5.0}, "attitude_timeout_s = 5 is over gate.ahrs_timeout_s = 0.5"),
    (
        {"safety.ascent.pitch_deg": 5.0, "safety.ascent.level_pitch_deg": 6.0},
        "level_pitch_deg = 6 is over pitch_deg = 5",
    ),
    ({"guidance.surface_speed_m_s": 0.4}, "surface_speed_m_s = 0.4 is under control.u_min_m_s = 0.5"),
    (
        {"guidance.acceleration_m_s2": 0.001},
        "acceleration_m_s2 = 0.001 takes 500 s from rest to control.u_min_m_s = 0.5",
    ),
    ({"control.u_min_m_s": 2.6}, "surface_speed_m_s = 1.5 is under control.u_min_m_s = 2.6"),
]


def tables(values: dict[str, Any]) -> dict:
    made: dict = {}
    for key, value in values.items():
        *path, last = key.split(".")
        table = made
        for part in path:
            table = table.setdefault(part, {})
        table[last] = value
    return made


@pytest.mark.parametrize(("values", "words"), CASES)
def test_a_contradiction_in_a_file_is_one_line_with_file_and_keys(values: dict[str, Any], words: str) -> None:
    with pytest.raises(ParamError) as caught:
        config_files.read_configuration(SHIPPED, tables(values))
    assert str(caught.value).startswith(f"{SHIPPED}/autopilot.toml")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("values", "words"), CASES)
def test_a_station_cannot_make_a_contradiction(values: dict[str, Any], words: str) -> None:
    mission = config_files.read_mission(SHIPPED)
    factory = app.parts_factory({**config_files.read_configuration(SHIPPED), "mission": mission, "kept": {}})
    before = factory.params
    with pytest.raises(ParamError) as caught:
        factory.with_changes(values)
    assert words in str(caught.value)
    assert factory.params is before


def test_without_a_charge_for_arming_any_charge_may_end_the_mission() -> None:
    values = {"safety.battery_arm_pct": 0.0, "safety.battery_min_pct": 50.0, "safety.battery_warn_pct": 60.0}
    config_files.read_configuration(SHIPPED, tables(values))


@pytest.mark.parametrize("key", ["battery_warn_action", "battery_action"])
def test_a_level_to_warn_at_may_be_anywhere_where_nothing_warns_or_nothing_comes_after(key: str) -> None:
    config_files.read_configuration(SHIPPED, tables({"safety.battery_warn_pct": 5.0, f"safety.{key}": "none"}))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass_kg = 5454.54", "mass_kg = 1.0", "body: weight_n = 53400 does not fit mass_kg = 1, which weighs 9.81 N"),
        ("weight_n = 53400.0", "weight_n = 534000.0", "body: weight_n = 534000 does not fit mass_kg = 5454.54"),
        ("buoyancy_n = 53400.0", "buoyancy_n = 5340.0", "body: buoyancy_n = 5340 differs from weight_n = 53400"),
        ("hinge_deg = 0.0", "hinge_deg = 0.0\ndelta_max_deg = 90.0", "fins[0]: delta_max_deg = 90.0: out of bounds"),
        ("hinge_deg = 0.0", "hinge_deg = 0.0\nrate_max_deg_s = 1e3", "fins[0]: rate_max_deg_s = 1000.0: out of bounds"),
    ],
)
def test_a_vehicle_that_cannot_be_is_one_line_with_file_and_keys(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    folder = Path(shutil.copytree(SHIPPED, tmp_path / "config"))
    path = folder / "vehicle.toml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ParamError) as caught:
        config_files.vehicle(config_files.read_configuration(folder))
    assert str(caught.value).startswith(f"{path}: {words}")


def test_a_vehicle_that_trims_a_little_buoyant_is_taken(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(SHIPPED, tmp_path / "config"))
    path = folder / "vehicle.toml"
    path.write_text(path.read_text().replace("buoyancy_n = 53400.0", "buoyancy_n = 53934.0"))
    assert config_files.vehicle(config_files.read_configuration(folder)).body.buoyancy == 53934.0
