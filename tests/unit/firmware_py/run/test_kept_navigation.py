"""What a vehicle keeps between runs: whole or not at all, and nothing that is not what was kept."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.io_params import StateParams
from firmware_py.estimation.navigation.navigation import KeptNavigation
from firmware_py.marine import Nu
from firmware_py.records.event import Cause
from firmware_py.records.health import WeightState
from firmware_py.records.order import Mode
from firmware_py.run import kept_navigation
from firmware_py.run.kept_navigation import Moment, NavigationKeeper
from firmware_py.run.usage_error import UsageError
from firmware_py.safety.start import KeptMode
from firmware_py.tick import Tick

NOW = Moment(1.8e9, "this start", 1e4)
KEPT = KeptNavigation(12.5, -3.25, 4.0, 101_300.0)
STILL = StateParams(drift_std=0.0, coast_time=0.0)


def loaded(folder: Path) -> KeptNavigation:
    """What was saved, as a vehicle resumes that did not move."""
    found = kept_navigation.load_navigation(folder)
    return KeptNavigation(**kept_navigation.resume(found, STILL, kept_navigation.moment()).kept)


places = st.floats(-1e6, 1e6)


def test_a_folder_that_is_new_or_empty_holds_nothing(tmp_path):
    assert kept_navigation.load_navigation(tmp_path) == {}
    assert kept_navigation.load_navigation(tmp_path / "new") == {}


@given(st.builds(KeptNavigation, places, places, st.floats(1e-3, 1e5), st.floats(4e4, 1.2e5)))
def test_what_was_kept_comes_back_to_the_bit(tmp_path_factory, kept):
    folder = tmp_path_factory.getbasetemp() / "state" / "deep"
    kept_navigation.save(folder, kept)
    assert loaded(folder) == kept
    assert [path.name for path in folder.iterdir()] == [kept_navigation.FILE]


@pytest.mark.parametrize("step", ["write", "fsync", "replace"])
def test_a_save_that_fails_half_way_leaves_what_was_there(tmp_path, monkeypatch, step):
    kept_navigation.save(tmp_path, KEPT)

    def full(*arguments, **keys):
        raise OSError(28, "No space left on device")

    where, name = {"write": (json, "dumps"), "fsync": (os, "fsync"), "replace": (Path, "replace")}[step]
    with monkeypatch.context() as patch:
        patch.setattr(where, name, full)
        with pytest.raises(UsageError, match=r"cannot be written \(No space left on device\)"):
            kept_navigation.save(tmp_path, KEPT._replace(x=99.0))
    assert loaded(tmp_path) == KEPT
    kept_navigation.save(tmp_path, KEPT._replace(x=99.0))
    assert kept_navigation.load_navigation(tmp_path)["x"] == 99.0


def test_what_no_run_could_start_from_does_not_replace_what_one_can(tmp_path):
    kept_navigation.save(tmp_path, KEPT)
    with pytest.raises(ValueError, match="not JSON compliant"):
        kept_navigation.save(tmp_path, KEPT._replace(x=float("nan")))
    assert loaded(tmp_path) == KEPT


GOOD = KEPT._asdict()
TIMED = json.loads(kept_navigation.encode(KEPT, 1.5, 5.0, NOW))


BAD = {
    "empty": b"",
    "cut": b"{",
    "not UTF-8": b"\xff\xfe",
    "bottomless": b"[" * 100_000,
    "null": b"null",
    "list": b"[1, 2, 3, 4]",
    "no entry": b"{}",
    "one more": json.dumps(GOOD | {"more": 1.0}).encode(),
    "one fewer": json.dumps({key: value for key, value in GOOD.items() if key != "x"}).encode(),
    "no value": json.dumps(GOOD | {"x": None}).encode(),
    "text": json.dumps(GOOD | {"x": "1.0"}).encode(),
    "truth": json.dumps(GOOD | {"x": True}).encode(),
    "nan": json.dumps(GOOD | {"x": float("nan")}).encode(),
    "infinite": json.dumps(GOOD | {"x": float("inf")}).encode(),
    "no sigma": json.dumps(GOOD | {"position_std": 0.0}).encode(),
    "minus sigma": json.dumps(GOOD | {"position_std": -1.0}).encode(),
    "no air": json.dumps(GOOD | {"surface_pressure": 0.0}).encode(),
    "under water": json.dumps(GOOD | {"surface_pressure": 2e5}).encode(),
    "off the earth": json.dumps(GOOD | {"x": 1e300}).encode(),
    "huge": json.dumps(GOOD | {"x": 10**400}).encode(),
    "half a time": json.dumps(GOOD | {"utc_s": 1.8e9}).encode(),
    "no time": json.dumps(TIMED | {"utc_s": None}).encode(),
    "backward": json.dumps(TIMED | {"speed": -1.0}).encode(),
    "numbered boot": json.dumps(TIMED | {"boot": 7}).encode(),
}


@pytest.mark.parametrize("content", BAD.values(), ids=BAD)
def test_a_file_that_is_not_what_was_saved_is_refused_and_named(tmp_path, content):
    path = tmp_path / kept_navigation.FILE
    path.write_bytes(content)
    with pytest.raises(UsageError) as failure:
        kept_navigation.load_navigation(tmp_path)
    text = str(failure.value)
    assert "\n" not in text
    assert text.startswith("--state: ")
    assert str(path) in text
    assert path.read_bytes() == content


def test_the_number_that_is_wrong_is_named_with_its_bounds(tmp_path):
    (tmp_path / kept_navigation.FILE).write_text(json.dumps(GOOD | {"surface_pressure": 2e5}))
    with pytest.raises(UsageError, match=r"surface_pressure = 200000\.0: must be a number in \[40000, 120000\]$"):
        kept_navigation.load_navigation(tmp_path)


def test_whole_numbers_are_numbers(tmp_path):
    (tmp_path / kept_navigation.FILE).write_text('{"x": 1, "y": 0, "position_std": 2, "surface_pressure": 101325}')
    assert kept_navigation.load_navigation(tmp_path) == KeptNavigation(1.0, 0.0, 2.0, 101_325.0)._asdict()


def test_a_file_in_the_folders_place_is_refused_both_ways(tmp_path):
    path = tmp_path / "state"
    path.write_text("precious")
    with pytest.raises(UsageError, match=r"^--state .*: cannot be read \(Not a directory\); choose another folder$"):
        kept_navigation.load_navigation(path)
    with pytest.raises(UsageError, match="cannot be written"):
        kept_navigation.save(path, KEPT)
    assert path.read_text() == "precious"


def sigma(saved: Moment = NOW, now: Moment = NOW, speed: float = 0.0, age: float = 0.0, **params) -> float:
    found = json.loads(kept_navigation.encode(KEPT, speed, age, saved))
    return kept_navigation.resume(found, StateParams(**params), now).kept["position_std"]


def later(seconds: float, boot: str = NOW.boot) -> Moment:
    return Moment(NOW.utc_s + seconds, boot, NOW.uptime_s + seconds if boot == NOW.boot else 20.0)


def test_sigma_grows_with_the_time_between_the_runs():
    assert sigma() == KEPT.position_std
    assert sigma(now=later(60.0), drift_std=0.5) == pytest.approx(4.0 + 30.0)
    assert sigma(now=later(60.0, "the next start"), drift_std=0.5) == pytest.approx(4.0 + 30.0)
    assert sigma(now=later(1e6), unknown_std=2000.0) == 2000.0


def test_a_vehicle_under_way_went_on_until_its_program_ended_and_for_a_while_after():
    moving = {"speed": 1.5, "age": 5.0, "drift_std": 0.0, "coast_time": 10.0}
    assert sigma(**moving) == pytest.approx(4.0 + 1.5 * 5.0)
    assert sigma(now=later(4.0), **moving) == pytest.approx(4.0 + 1.5 * 9.0)
    assert sigma(now=later(400.0), **moving) == pytest.approx(4.0 + 1.5 * 15.0)


@pytest.mark.parametrize(
    ("saved", "now", "clock_kept"),
    [
        (NOW, Moment(NOW.utc_s + 60.0, NOW.boot, NOW.uptime_s - 60.0), True),
        (NOW, Moment(NOW.utc_s - 3600.0, "the next start", 20.0), True),
        (Moment(1000.0, "an earlier start", 1000.0), Moment(1060.0, "the next start", 60.0), True),
        (NOW, later(60.0, "the next start"), False),
    ],
    ids=[
        "a time since the start that cannot be",
        "set back over a restart",
        "never set",
        "without a battery of its own",
    ],
)
def test_a_clock_that_cannot_tell_how_long_it_was_gives_a_generous_sigma(saved, now, clock_kept):
    assert sigma(saved, now, clock_kept=clock_kept) == StateParams().unknown_std


@pytest.mark.parametrize("jump", [-1000.0, -599.0, 0.0, 1.7e9], ids=["back", "less than passed", "none", "from 1970"])
def test_a_clock_that_is_set_in_one_start_of_the_computer_changes_nothing(jump):
    now = Moment(NOW.utc_s + 600.0 + jump, NOW.boot, NOW.uptime_s + 600.0)
    assert sigma(now=now, drift_std=0.5) == pytest.approx(4.0 + 300.0)


def test_a_vehicle_whose_clock_was_set_in_flight_still_knows_that_it_was_armed_a_moment_ago():
    was = kept_navigation.encode(KEPT, 1.5, 5.0, Moment(12.0, "this start", 700.0), KeptMode(Mode.MISSION, 0.0))
    now = Moment(1.8e9, "this start", 703.0)
    resumed = kept_navigation.resume(json.loads(was), StateParams(), now)
    assert (resumed.kept["mode"], resumed.kept["mode_ago"]) == (float(Mode.MISSION), pytest.approx(3.0))


def test_a_file_without_a_time_gives_a_generous_sigma():
    assert kept_navigation.resume(GOOD, StateParams(), NOW).kept["position_std"] == StateParams().unknown_std


def test_no_time_makes_sigma_less():
    found = json.loads(kept_navigation.encode(KEPT._replace(position_std=5e4), 0.0, 0.0, NOW))
    for now in (NOW, later(60.0), later(-60.0)):
        assert kept_navigation.resume(found, StateParams(unknown_std=100.0), now).kept["position_std"] == 5e4


def test_the_keeper_saves_at_its_interval_with_the_age_that_this_may_reach():
    saved: list[tuple[int, dict]] = []
    k = 0
    keeper = NavigationKeeper(
        lambda _, content: saved.append((k, json.loads(content))), lambda: KEPT, 5.0, lambda _: KeptMode()
    )
    for k in range(1201):
        keeper.update(cycle(k))
    assert [k for k, _ in saved] == [0, 500, 1000]
    assert saved[-1][1]["age_s"] == 5.0
    assert saved[-1][1]["speed"] == pytest.approx(1.5 + 0.2)
    assert keeper.speed == pytest.approx(1.7)


def test_that_the_weight_is_released_is_saved_at_once_and_once():
    saved: list[tuple[int, str, bytes]] = []
    k = 0
    keeper = NavigationKeeper(
        lambda name, content: saved.append((k, name, content)), lambda: KEPT, 5.0, lambda _: KeptMode()
    )
    for k in range(400):
        keeper.update(cycle(k, drop=k >= 120))
    assert saved[1:] == [(120, kept_navigation.WEIGHT_FILE, b"PROPELLER_FAULT, at 1.20 s\n")]


@pytest.mark.parametrize(
    ("state", "commanded", "kept"),
    [
        (WeightState.HELD, False, False),
        (WeightState.COMMANDED, True, False),
        (WeightState.STUCK, True, False),
        (WeightState.NOT_CONFIRMED, True, True),
        (WeightState.RELEASED, True, True),
        (WeightState.GONE, False, True),
    ],
)
def test_a_weight_is_kept_as_released_when_its_hardpoint_says_so_or_nothing(state, commanded, kept) -> None:
    saved: dict[str, bytes] = {}
    keeper = NavigationKeeper(saved.__setitem__, lambda: KEPT, 10.0, lambda _: KeptMode())
    for k in range(10):
        keeper.update(cycle(k, commanded, state))
    assert (kept_navigation.WEIGHT_FILE in saved) is kept


def cycle(k: int, drop: bool = False, weight: WeightState = WeightState.UNREPORTED) -> SimpleNamespace:
    """As much of a cycle as the keeper looks at."""
    state = SimpleNamespace(nu=Nu(1.5, 0, 0, 0, 0, 0), velocity_std=0.2)
    decided = {"applied": SimpleNamespace(drop=drop), "mode": SimpleNamespace(cause=Cause.PROPELLER_FAULT)}
    decided["actuators"] = SimpleNamespace(drop_weight=weight)
    return SimpleNamespace(tick=Tick(k, 10_000_000), state=state, **decided)


ARMED = KeptMode(Mode.MISSION)


def test_a_mode_comes_back_with_the_time_since():
    kept = kept_navigation.encode(KEPT, 1.5, 5.0, NOW, KeptMode(Mode.HOLD, 40.0))
    found = kept_navigation.resume(json.loads(kept), StateParams(), later(60.0))
    assert (found.kept["mode"], found.kept["mode_ago"]) == (float(Mode.HOLD), 100.0)
    assert found.sentence.endswith("; it was armed then, in hold")


@pytest.mark.parametrize("mode", [KeptMode(), KeptMode(Mode.DISARMED, 40.0)])
def test_a_vehicle_that_was_not_armed_leaves_no_mode(mode):
    found = kept_navigation.resume(json.loads(kept_navigation.encode(KEPT, 1.5, 5.0, NOW, mode)), StateParams(), NOW)
    assert "mode" not in found.kept
    assert "armed" not in found.sentence


@pytest.mark.parametrize(("seconds", "params"), [(3601.0, {}), (11.0, {"armed_time": 10.0}), (-60.0, {})])
def test_a_mode_of_long_ago_or_of_an_unknown_time_ago_is_told_and_brings_nothing_up(seconds, params):
    kept = json.loads(kept_navigation.encode(KEPT, 1.5, 5.0, NOW, ARMED))
    found = kept_navigation.resume(kept, StateParams(**params), later(seconds))
    assert "mode" not in found.kept
    assert found.sentence.endswith("; it was armed then, in mission; too long ago for it to come up by itself")


@pytest.mark.parametrize("wrong", [{"mode": "swim"}, {"mode": 3.0}, {"mode": ["hold"]}, {"mode_ago_s": -1.0}])
def test_a_mode_that_is_none_is_refused(tmp_path, wrong):
    (tmp_path / kept_navigation.FILE).write_text(json.dumps(TIMED | wrong))
    with pytest.raises(UsageError, match="mode"):
        kept_navigation.load_navigation(tmp_path)


def test_a_file_of_an_earlier_version_has_no_mode_and_is_taken(tmp_path):
    old = {name: value for name, value in TIMED.items() if not name.startswith("mode")}
    (tmp_path / kept_navigation.FILE).write_text(json.dumps(old))
    assert kept_navigation.load_navigation(tmp_path) == old


def test_the_keeper_saves_a_mode_at_once_when_it_changes():
    saved: list[tuple[int, str]] = []
    k = 0
    keeper = NavigationKeeper(
        lambda _, content: saved.append((k, json.loads(content)["mode"])),
        lambda: KEPT,
        5.0,
        lambda t: KeptMode(Mode.DISARMED if t < 1.0 else Mode.HOLD if t < 2.0 else Mode.MISSION),
    )
    for k in range(800):
        keeper.update(cycle(k))
    assert saved == [(0, "disarmed"), (100, "hold"), (200, "mission"), (700, "mission")]
