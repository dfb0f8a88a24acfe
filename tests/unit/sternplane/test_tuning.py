"""The tuning study: the optimiser finds what is there to find, and the flight flown again is the whole flight."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from sternplane.study.tuning import search
from sternplane.study.tuning.closed_loop import ClosedLoop
from sternplane.study.tuning.differential_evolution import DifferentialEvolution

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.control.control import ControlParams, LawKind
from firmware_py.params import load

LOW, HIGH = np.array([0.1, 0.1, 0.1]), np.array([10.0, 10.0, 10.0])


def valley(point: np.ndarray) -> float:
    """Return a cost that is least, 0, at (2, 0.5, 3), along a bent valley."""
    x, y, z = np.log(point / (2.0, 0.5, 3.0))
    return float(x**2 + 30.0 * (y - x**2) ** 2 + z**2)


def found(seed: int) -> DifferentialEvolution:
    one = DifferentialEvolution(LOW, HIGH, 16, seed)
    for _ in range(60):
        for i in range(16):
            one.tell(i, valley(one.ask(i)))
        one.breed()
    return one


def test_the_optimiser_finds_the_bottom_of_a_bent_valley_and_the_same_every_time() -> None:
    first, again = found(3), found(3)
    assert first.best == pytest.approx([2.0, 0.5, 3.0], rel=0.02)
    assert np.array_equal(first.best, again.best)
    assert not np.array_equal(first.best, found(4).best)


def test_the_optimiser_stays_in_its_box_and_begins_where_it_is_told() -> None:
    one = DifferentialEvolution(LOW, HIGH, 8, 1, np.array([2.0, 0.5, 3.0]))
    assert one.ask(0) == pytest.approx([2.0, 0.5, 3.0])
    for _ in range(20):
        for i in range(8):
            point = one.ask(i)
            assert np.all((point >= 0.999 * LOW) & (point <= 1.001 * HIGH))
            one.tell(i, -float(point.sum()))  # the best lies in a corner
        one.breed()
    assert one.cost < -20.0


def test_a_best_point_that_costs_more_after_all_gives_way() -> None:
    one = DifferentialEvolution(LOW, HIGH, 4, 1)
    for i in range(4):
        one.tell(i, float(i))
    lucky = one.best
    one.correct(1.5)
    assert one.cost == 1.0
    assert not np.array_equal(one.best, lucky)


@pytest.mark.parametrize("kind", search.SEARCHES, ids=lambda kind: kind.name)
def test_gains_survive_the_way_through_a_file(kind: search.Search, tmp_path: Path) -> None:
    for params in search.drawn(kind, ControlParams(), 2):
        path = tmp_path / "gains.toml"
        path.write_text(search.as_toml(kind, params, ("said of it",)))
        read = load(ControlParams, read_toml(path)["autopilot"]["control"], "gains")
        assert read.law is kind.law
        for space in kind.spaces:
            assert space.point(read) == pytest.approx(space.point(params), rel=1e-3)
    assert not np.allclose(space.point(params), space.point(ControlParams()))


def test_a_flight_flown_again_is_the_whole_flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twelve seconds, the start among them: recorded under sliding mode, flown again and whole under a PID."""
    monkeypatch.setattr(search, "DURATION", 12.0)
    pid = dataclasses.replace(ControlParams(), law=LawKind.PID)
    kind = search.SEARCHES[0]
    loop = ClosedLoop(*search.recorded(tmp_path, 1), 2.0)
    shipped = loop.fly(loop.shipped)
    assert np.array(shipped) == pytest.approx(np.array(loop.recorded()), rel=0.03)
    whole = ClosedLoop(*search.recorded(tmp_path, 1, f"\n{search.as_toml(kind, pid)}"), 2.0).recorded()
    again = loop.fly(pid)
    assert np.array(again) == pytest.approx(np.array(whole), rel=0.03)
    assert abs(again[1].rms / shipped[1].rms - 1.0) > 0.05  # another law is another flight
    assert all(math.isfinite(x) for axis in again for x in axis)


@pytest.mark.parametrize(("folder", "speed", "rpm"), [("npsauv2", 1.8, 492.0), ("torpedo_x", 1.5, 1461.0)])
def test_every_vehicle_flies_the_track_at_its_own_speed(folder: str, speed: float, rpm: float) -> None:
    assert search.cruise(configs() / folder) == (speed, rpm)


def test_a_flight_of_another_vehicle_flown_again_is_the_whole_flight(tmp_path: Path) -> None:
    config = configs() / "torpedo_x"
    flight, recording = search.recorded(tmp_path, 1, config=config)
    assert len(flight.autopilot.applied.fins) == 4
    assert recording.truths[-1].nu.u == pytest.approx(1.5, abs=0.15)
    loop = ClosedLoop(flight, recording, search.BEGIN)
    again, whole = np.array(loop.fly(loop.shipped)), np.array(loop.recorded())
    assert again == pytest.approx(whole, rel=0.02)
    assert whole[0, 0] < 0.1  # depth RMS, m: it is steered
