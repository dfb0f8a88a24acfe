"""Replay: equal to the last bit, or the first field that is not; refused where it cannot say."""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from sternplane.logs.reading import read
from sternplane.logs.replay import command, difference, replay

from firmware_py.adapters.storage.recorder import LogError
from firmware_py.run import provenance


def test_two_runs_are_byte_identical_and_another_seed_is_not(flown: Path, tmp_path: Path, toy: SimpleNamespace) -> None:
    again, other = toy.fly(tmp_path / "again.mcap"), toy.fly(tmp_path / "other.mcap", seed=2)
    assert read(again).cycle_bytes == read(flown).cycle_bytes
    assert read(other).cycle_bytes != read(flown).cycle_bytes


def test_a_replay_is_equal_whatever_the_lateness(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap", late_ns=lambda k: 7919 * k % 12_000_000))
    result = replay(log, toy.build)
    assert (result.equal, result.cycles, result.differing, result.first) == (True, 300, 0, None)
    assert str(result) == "300 cycles replayed: every byte equal"
    assert [cycle.tick.late_ns for cycle in log.cycles][:3] == [0, 7919, 15838]


def test_the_first_field_that_differs_is_named(flown: Path, toy: SimpleNamespace) -> None:
    class Changed(toy.build):  # type: ignore[misc, name-defined]
        def step(self, tick: Any, frame: Any, order: Any) -> Any:
            cycle = super().step(tick, frame, order)
            if tick.k < 123:
                return cycle
            fins = (*cycle.applied.fins[:2], math.nextafter(cycle.applied.fins[2], math.inf), cycle.applied.fins[3])
            return dataclasses.replace(cycle, applied=dataclasses.replace(cycle.applied, fins=fins))

    result = replay(read(flown), Changed)
    assert not result.equal
    assert result.first is not None
    assert (result.first.tick, result.first.field) == (123, "applied.fins[2]")
    assert result.first.replayed == math.nextafter(result.first.logged, math.inf)
    assert (result.cycles, result.differing) == (300, 177)
    assert "first at tick 123: applied.fins[2] was" in str(result)


@pytest.mark.parametrize(("there", "here"), [(0.0, -0.0), (math.nan, 0.0), (math.nan, -math.nan)])
def test_signs_and_nans_count(flown: Path, there: float, here: float) -> None:
    cycle = next(read(flown).cycles)
    first, second = (
        dataclasses.replace(cycle, demand=cycle.demand.__class__(0.0, x, 0.0, 0.0, 0.0)) for x in (there, here)
    )
    assert difference(first, second).field == "demand.delta_r"


def test_an_event_that_was_not_said_counts(flown: Path) -> None:
    cycle = next(read(flown).cycles)
    found = difference(cycle, dataclasses.replace(cycle, events=("new",)))
    assert (found.field, found.logged, found.replayed) == ("events", (), ("new",))


def test_the_log_of_another_processor_is_refused_unless_anyway(tmp_path: Path, toy: SimpleNamespace) -> None:
    elsewhere = {**provenance.fingerprint(), "cpu": "PDP-11"}
    log = read(toy.fly(tmp_path / "log.mcap", 0.2, machine=elsewhere))
    with pytest.raises(LogError, match=r"log\.mcap: log of another machine \(cpu: PDP-11 there, .* here\).*--anyway"):
        replay(log, toy.build)
    result = replay(log, toy.build, anyway=True)
    assert result.equal
    assert any("PDP-11" in caution for caution in result.cautions)


def test_the_log_of_other_records_is_refused(
    tmp_path: Path, toy: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = read(toy.fly(tmp_path / "log.mcap", 0.2, git="cafe"))
    cycles = log.topics["/cycle"]
    older = dataclasses.replace(cycles, schema=cycles.schema.replace("float64 u_d\n", ""))
    log.topics["/cycle"] = older
    with pytest.raises(LogError, match=r"log of another version \(.*Cycle.*\); use revision cafe"):
        replay(log, toy.build)


def test_another_revision_is_mentioned(tmp_path: Path, toy: SimpleNamespace) -> None:
    result = replay(read(toy.fly(tmp_path / "log.mcap", 0.2, git="cafe")), toy.build)
    assert any("revision cafe" in caution for caution in result.cautions)


def test_the_commands_status_says_whether_it_is_equal(
    flown: Path, toy: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    options = argparse.Namespace(log=flown.parent, anyway=False)
    monkeypatch.setitem(sys.modules, "firmware_py.app", SimpleNamespace(build=toy.build))  # type: ignore[arg-type]
    assert command(options) == 0
    assert "every byte equal" in capsys.readouterr().out
    changed = SimpleNamespace(build=lambda _: toy.build({"gain": 0.26}))
    monkeypatch.setitem(sys.modules, "firmware_py.app", changed)  # type: ignore[arg-type]
    assert command(options) == 1
    assert "first at tick 1: state.eta.x was" in capsys.readouterr().out
