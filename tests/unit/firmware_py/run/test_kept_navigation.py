"""What a vehicle keeps between runs: whole or not at all, and nothing that is not what was kept."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.estimation.navigation.navigation import KeptNavigation
from firmware_py.run import kept_navigation
from firmware_py.run.usage_error import UsageError

KEPT = KeptNavigation(12.5, -3.25, 4.0, 101_300.0)
places = st.floats(-1e6, 1e6)


def test_a_folder_that_is_new_or_empty_holds_nothing(tmp_path):
    assert kept_navigation.load_navigation(tmp_path) == {}
    assert kept_navigation.load_navigation(tmp_path / "new") == {}


@given(st.builds(KeptNavigation, places, places, st.floats(1e-3, 1e5), st.floats(4e4, 1.2e5)))
def test_what_was_kept_comes_back_to_the_bit(tmp_path_factory, kept):
    folder = tmp_path_factory.getbasetemp() / "state" / "deep"
    kept_navigation.save(folder, kept)
    assert KeptNavigation(**kept_navigation.load_navigation(folder)) == kept
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
    assert KeptNavigation(**kept_navigation.load_navigation(tmp_path)) == KEPT
    kept_navigation.save(tmp_path, KEPT._replace(x=99.0))
    assert kept_navigation.load_navigation(tmp_path)["x"] == 99.0


def test_what_no_run_could_start_from_does_not_replace_what_one_can(tmp_path):
    kept_navigation.save(tmp_path, KEPT)
    with pytest.raises(ValueError, match="not JSON compliant"):
        kept_navigation.save(tmp_path, KEPT._replace(x=float("nan")))
    assert KeptNavigation(**kept_navigation.load_navigation(tmp_path)) == KEPT


GOOD = KEPT._asdict()


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
    with pytest.raises(
        UsageError, match=r"surface_pressure = 200000\.0: must be a number in \[30000, 130000\]; remove"
    ):
        kept_navigation.load_navigation(tmp_path)


def test_whole_numbers_are_numbers(tmp_path):
    (tmp_path / kept_navigation.FILE).write_text('{"x": 1, "y": 0, "position_std": 2, "surface_pressure": 101325}')
    assert KeptNavigation(**kept_navigation.load_navigation(tmp_path)) == KeptNavigation(1.0, 0.0, 2.0, 101_325.0)


def test_a_file_in_the_folders_place_is_refused_both_ways(tmp_path):
    path = tmp_path / "state"
    path.write_text("precious")
    with pytest.raises(UsageError, match=r"^--state .*: cannot be read \(Not a directory\); choose another folder$"):
        kept_navigation.load_navigation(path)
    with pytest.raises(UsageError, match="cannot be written"):
        kept_navigation.save(path, KEPT)
    assert path.read_text() == "precious"
