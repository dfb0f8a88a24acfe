"""Mutated configurations: every one is loaded or refused in one short line; the rule can be broken."""

from __future__ import annotations

import random
from itertools import islice
from pathlib import Path

import pytest
from rich.console import Console
from sternplane.fuzz import configurations
from sternplane.fuzz.configurations import Mutant, mutants, run, verdict

from firmware_py import app

SHIPPED = configurations.CONFIG


def test_three_hundred_mutants_are_loaded_or_refused_in_one_line_and_some_of_them_fly() -> None:
    tally = run(seed=7, count=300, flights=2, console=Console(stderr=True))
    assert tally.broken == ()
    assert tally.refused + tally.loaded == 300
    assert tally.flown == 2
    assert tally.refused > 100
    assert tally.loaded > 20  # they are changed enough to matter, and not only to be refused


def test_mutants_are_the_same_for_a_seed_and_touch_every_file() -> None:
    one, again, other = (list(islice(mutants(seed), 100)) for seed in (3, 3, 4))
    assert one == again
    assert one != other
    assert configurations._changed(random.Random(1), []) == ([], "nothing is left")
    assert {mutant.file for mutant in one} == set(configurations._FILES)


def test_what_is_raised_that_is_no_error_of_the_user_breaks_the_rule(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unchanged = Mutant("vehicle.toml", "demo", (SHIPPED / "vehicle.toml").read_text(), "nothing")
    assert verdict(unchanged, tmp_path / "config").flight is not None

    def fail(_: object) -> None:
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr(app, "build", fail)
    found = verdict(unchanged, tmp_path / "config")
    assert found.flight is None
    assert "ZeroDivisionError: by zero" in found.broken


def test_an_error_that_repeats_a_megabyte_breaks_the_rule(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    long = Mutant("vehicle.toml", "demo", 'name = "' + "x" * 1_000_000, "cut off")
    assert verdict(long, tmp_path / "config").broken == ""
    monkeypatch.setattr("firmware_py.adapters.storage.toml_files._WHY_MAX", 10_000_000)
    monkeypatch.setattr(configurations, "LONGEST", 20)
    assert verdict(long, tmp_path / "config").broken.startswith("an error of ")
