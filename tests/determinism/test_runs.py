"""One scenario and one seed give the same bytes, run after run, and a replay gives them again."""

from __future__ import annotations

from pathlib import Path

import pytest
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.app import build
from tests.dive import dive

SEA = """
[environment]
current_ned_m_s = [0.1, -0.1, 0.0]
turbulence_m_s = 0.05
bottom_depth_m = 40.0
[autopilot.safety]
late_max = 1000  # on a machine that tests share with others
"""


def flown(folder: Path, seed: int = 1, pace: str = "max", duration: float = 40.0) -> Log:
    scenario = folder.with_suffix(".toml")
    scenario.write_text(dive(duration) + SEA)
    folder.mkdir()
    outcome = fly(prepare(FlightRequest(scenario=str(scenario), seed=seed, pace=pace), {}), folder / "log.mcap")
    assert outcome.completed, outcome
    return read(folder / "log.mcap")


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return flown(tmp_path_factory.mktemp("first") / "run")


def test_two_runs_of_one_seed_are_equal_byte_for_byte(first: Log, tmp_path: Path) -> None:
    second = flown(tmp_path / "run")
    assert len(first.cycle_bytes) == 4000
    assert second.cycle_bytes == first.cycle_bytes
    assert second.topics["/truth"].messages == first.topics["/truth"].messages


def test_another_seed_is_another_run(first: Log, tmp_path: Path) -> None:
    other = flown(tmp_path / "run", seed=2, duration=10.0)
    differing = sum(a != b for a, b in zip(other.cycle_bytes, first.cycle_bytes[:1000], strict=True))
    assert differing > 975


def test_a_replay_gives_every_output_again(first: Log) -> None:
    result = replay(first, build)
    assert result.cycles == 4000
    assert result.equal, str(result)


def test_a_replay_of_a_run_in_real_time_gives_every_output_again(tmp_path: Path) -> None:
    log = flown(tmp_path / "run", pace="realtime", duration=3.0)
    assert any(cycle.tick.late_ns > 0 for cycle in log.cycles)  # the clock was there, and is an input
    result = replay(log, build)
    assert result.cycles == 300
    assert result.equal, str(result)


def test_an_autopilot_thawed_in_the_middle_goes_on_as_the_one_that_was_not(first: Log) -> None:
    cycles = list(first.cycles)
    one = build(first.header["configuration"])
    for cycle in cycles[:2000]:
        one.step(cycle.tick, cycle.frame, cycle.order)
    other = build(first.header["configuration"])
    other.thaw(one.freeze())
    for cycle in cycles[2000:2500]:
        again = other.step(cycle.tick, cycle.frame, cycle.order)
        assert first.codec.encode(again) == first.codec.encode(cycle)
