from __future__ import annotations

from types import SimpleNamespace

from firmware_py.run.sensor_watch import SensorWatch
from firmware_py.tick import Tick


def cycle(t: float, attitude: bool = True, depth: bool = True, velocity: bool = True) -> SimpleNamespace:
    state = SimpleNamespace(attitude_ok=attitude, depth_ok=depth, velocity_ok=velocity, candidates=())
    return SimpleNamespace(tick=Tick(round(t * 100), 10_000_000), state=state)


def test_what_was_never_heard_is_told_once_after_five_seconds_and_when_it_comes() -> None:
    hearing = SensorWatch()
    said = {t: hearing.changes(cycle(t, attitude=t > 8.0, depth=False)) for t in range(12)}
    assert said.pop(5) == ["not known for 5 s: attitude, depth"]
    assert said.pop(9) == ["attitude is known again"]
    assert not any(said.values())


def test_what_falls_silent_is_told_when_it_does_and_when_it_comes_back() -> None:
    hearing = SensorWatch()
    said = [hearing.changes(cycle(0.1 * k, velocity=not 200 <= k < 300)) for k in range(400)]
    assert said[200] == ["velocity is no longer known"]
    assert said[300] == ["velocity is known again"]
    assert sum(map(len, said)) == 2


def test_all_heard_from_the_start_is_nothing_to_tell() -> None:
    hearing = SensorWatch()
    assert not any(hearing.changes(cycle(0.1 * k)) for k in range(200))
