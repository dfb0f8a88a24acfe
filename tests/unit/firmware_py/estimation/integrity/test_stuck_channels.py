"""One channel that stays at exactly one value, while the sensor lives; and sensors that repeat a channel by nature."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from firmware_py.estimation.integrity.channel_watch import ChannelWatch
from firmware_py.records.health import SourceFault, SourceState
from firmware_py.records.sensing import Ahrs, Dvl

from .voyage import DEG, Fault, after, named, new, voyage

F = SourceFault
Rows = list[tuple[float, ...]]


def stuck(channels: dict[str, float], t_fault: float = 20.0) -> Fault:
    """Return the fault of some channels that stay at one value each."""
    return after(t_fault, lambda _, value: value._replace(**channels))


def held(names: tuple[str, ...]) -> Fault:
    """Return the fault of channels that stay at what they were at 20 s."""
    first: dict[str, float] = {}

    def hold(_: float, value: Any) -> Any:
        for name in names:
            first.setdefault(name, getattr(value, name))
        return value._replace(**first)

    return after(20.0, hold)


CASES: dict[str, tuple[str, Fault, float]] = {
    **{f"AHRS {name} stays": ("ahrs", held((name,)), 0.5) for name in Ahrs._fields},
    **{f"DVL {name} stays": ("dvl", held((name,)), 3.3) for name in ("u", "v", "w")},
    "a dead axis": ("ahrs", stuck({"r": 0.0}), 0.5),
    "two dead axes": ("ahrs", stuck({"q": 0.0, "p": 0.0}), 0.5),
    "three dead axes": ("ahrs", stuck({"p": 0.0, "q": 0.0, "r": 0.0}), 0.5),
    "no heave, diving": ("dvl", stuck({"w": 0.0}), 3.3),
}


@pytest.mark.parametrize(("sensor", "fault", "within"), CASES.values(), ids=CASES)
def test_a_channel_that_stays_at_one_value_freezes_its_sensor(sensor: str, fault: Fault, within: float) -> None:
    """A dead axis of the gyro had sound rudders called lost, a w that stayed a sound pressure undecided."""
    changes = named(voyage(25.0, {sensor: fault}))
    assert {name for _, name, _ in changes} == {sensor}
    t, _, health = next(change for change in changes if change[2].fault is F.FROZEN)
    assert health.state is SourceState.SUSPECT
    assert 0.0 <= t - 20.0 <= within


def test_a_sensor_whose_channel_lives_again_is_good_again_and_named_again() -> None:
    def twice(t: float, value: Ahrs) -> Ahrs:
        return value._replace(q=0.0) if 10.0 <= t < 12.0 or t >= 22.0 else value

    changes = [(t, health.fault) for t, _, health in named(voyage(24.0, {"ahrs": twice}))]
    assert [fault for _, fault in changes] == [F.FROZEN, F.NONE, F.FROZEN]
    times = [t for t, _ in changes]
    assert times == pytest.approx([10.4, 17.0, 22.4], abs=0.15)


def rounded(step: float) -> Callable[[float, Dvl], Dvl]:
    def coarse(_: float, value: Dvl) -> Dvl:
        u, v, w = (round(x / step) * step for x in value[:3])
        return value._replace(u=u, v=v, w=w)

    return coarse


def float16(_: float, value: Ahrs) -> Ahrs:
    return Ahrs(*struct.unpack("<6e", struct.pack("<6e", *value)))


def gyros(step: float) -> Callable[[float, Ahrs], Ahrs]:
    def coarse(_: float, value: Ahrs) -> Ahrs:
        p, q, r = (round(x / step) * step for x in value[3:])
        return value._replace(p=p, q=q, r=r)

    return coarse


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3, 1.0])
@pytest.mark.parametrize(
    "faults",
    [
        {"dvl": rounded(0.001), "ahrs": float16},
        {"dvl": rounded(0.01), "ahrs": gyros(0.06 * DEG)},
        {"dvl": rounded(0.03), "ahrs": gyros(0.01 * DEG)},
        {"dvl": lambda _, value: value._replace(w=0.0), "ahrs": lambda _, value: value._replace(phi=0.0, p=0.0)},
    ],
    ids=["1 mm/s, float16", "1 cm/s, 0.06 deg/s", "3 cm/s, 0.01 deg/s", "channels that were never measured"],
)
def test_a_sound_sensor_of_any_resolution_is_not_frozen(noise: float, faults: dict[str, Fault]) -> None:
    changes = named(voyage(45.0, faults, noise=noise))
    assert all(health.fault is not F.FROZEN for _, _, health in changes)


def stays(rows: Rows, channels: int = 6, rate: float = 100.0) -> bool:
    """Return whether a channel of these values is ever called stuck."""
    watch = ChannelWatch(channels, 0.4)
    return any(watch.hear(now, then, k / rate) for k, (then, now) in enumerate(pairwise(rows)))


def noise(rows: int, sigma: float, seed: int = 1, channels: int = 6) -> np.ndarray[Any, Any]:
    return np.random.default_rng(seed).standard_normal((rows, channels)) * sigma


@pytest.mark.parametrize("running_down", [0.0, 0.3], ids=["all at once", "gyros alone"])
def test_gyros_with_coarse_steps_that_become_quiet_as_the_propeller_stops_are_sound(running_down: float) -> None:
    """Steps of 0.06 deg/s: while it shakes they have noise, then each axis stays at one step."""
    shaken, quiet = noise(1000, 0.3), noise(1000, 0.001, seed=2)
    if running_down:
        quiet[:, :3] = shaken[:, :3]
        quiet[:, 3:] *= 1.0 + 300.0 * np.exp(-np.arange(1000)[:, None] * 0.01 / running_down)
    rows = np.concatenate([shaken, quiet])
    rows[:, 3:] = np.round(rows[:, 3:] / 0.06) * 0.06
    if not running_down:
        rows[:, :3] = np.round(rows[:, :3] / 0.06) * 0.06
    assert not stays([tuple(row) for row in rows.tolist()])


def test_a_channel_that_stays_is_told_while_another_has_noise() -> None:
    rows = noise(1000, 1.0)
    rows[500:, 5] = 0.0
    assert stays([tuple(row) for row in rows.tolist()])


def test_waves_are_no_noise_of_those_that_show_that_a_sensor_lives() -> None:
    rows = noise(2000, 1.0)
    swell = np.sin(np.arange(1000) * math.tau / 300.0)
    rows[1000:] = 0.0
    rows[1000:, 3] = swell
    assert not stays([tuple(row) for row in rows.tolist()])


@pytest.mark.parametrize("sigma", [0.002, 0.005, 0.01, 0.02, 0.03])
def test_a_dvl_of_one_centimetre_is_sound_in_waves_and_at_rest_after_them(sigma: float) -> None:
    """An hour at 5 Hz: waves of 0.3 m/s that die away, and the noise of its heave, which is a third of the others'."""
    t = np.arange(18000) / 5.0
    waves = 0.3 * np.exp(-np.mod(t, 120.0) / 20.0) * np.sin(math.tau * t / 4.3)
    rows = noise(len(t), sigma, channels=3) * (1.0, 1.0, 0.3) + np.stack([1.5 + 0.2 * waves, 0.3 * waves, waves], 1)
    assert not stays([tuple(row) for row in (np.round(rows / 0.01) * 0.01).tolist()], 3, 5.0)


@pytest.mark.parametrize("sigma", [0.0015, 0.003, 0.005, 0.01])
def test_a_dvl_whose_noise_falls_with_the_speed_is_sound_at_rest(sigma: float) -> None:
    """Steps of 1 mm/s: at rest its heave stays at 0 for minutes, while u and v still change from step to step."""
    speed = 1.8 * np.clip(np.sin(np.arange(9000) / 1500.0) * 3.0, 0.0, 1.0)
    moving = noise(9000, 0.02, seed=2, channels=3) * (speed[:, None] > 0.0)
    rows = noise(9000, sigma, channels=3) * (0.15 + speed[:, None] / 1.8) * (1.0, 1.0, 0.3) + moving
    rows[:, 0] += speed
    assert not stays([tuple(row) for row in (np.round(rows / 0.001) * 0.001).tolist()], 3, 5.0)


def test_rounding_of_arithmetic_is_no_noise() -> None:
    """A simulation without noise: a roll of 1e-17 rad that becomes 0, while others have noise."""
    rows = noise(1000, 1.0)
    rows[:, 0] *= 1e-17
    rows[500:, 0] = 0.0
    assert not stays([tuple(row) for row in rows.tolist()])


def test_what_is_restored_names_the_same_at_the_same_time() -> None:
    fault = {"ahrs": stuck({"r": 0.0}, 5.0), "dvl": stuck({"w": 0.0}, 5.0)}
    whole = new()
    seen = list(voyage(10.0, fault, integrity=whole))
    parted, times = new(), []
    for one in voyage(10.0, fault, integrity=parted):
        memory = parted.freeze()
        other = new()
        other.thaw(memory)
        assert other.freeze() == memory
        parted.thaw(memory)
        times.append(one.health)
    assert times == [one.health for one in seen]
    assert parted.freeze().sources == whole.freeze().sources
