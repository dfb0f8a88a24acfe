"""The horizon: whatever comes late or out of turn is taken in at its time, and whatever is none leaves no trace."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py import params
from firmware_py.estimation.fixed_lag_buffer import FixedLagBuffer, FixedLagBufferParams
from firmware_py.params import ParamError
from firmware_py.records.command import Applied
from firmware_py.records.sensing import Ahrs, Dvl, Heard, SensorFrame, never, silence
from firmware_py.tick import Tick
from tests.estimation.cases import VEHICLE
from tests.estimation.flights import quiet

LAG, LONGEST = 0.2, 0.02
TICKS = 120
TOLD = Applied((0.1, 0.1, -0.2, -0.2), 5.0, True, False)
Row = tuple[float, float, bytes, bytes, bytes]


def horizon(**changes: float) -> FixedLagBuffer:
    return FixedLagBuffer(FixedLagBufferParams(**{"lag": LAG, "longest": LONGEST, **changes}), VEHICLE)


def ahrs(t: float, **changes: float) -> Heard[Ahrs]:
    return Heard(Ahrs(0.1 * t, 0.2, -0.3 * t, 0.01 * t, 0.02, 0.03)._replace(**changes), t, True, True)


def dvl(t: float, **changes: float) -> Heard[Dvl]:
    return Heard(Dvl(1.8 + 0.01 * t, 0.1, 0.2, 0.02, 50.0)._replace(**changes), t, True, True)


def fin(t: float, i: int) -> Heard[float]:
    return Heard(0.1 * math.sin(3.0 * t + i), t, True, True)


def time(k: int) -> float:
    return Tick(k, 10_000_000).t


def flight(late: dict[str, int] | None = None, fins_late: tuple[int, ...] = (0, 0, 0, 0)) -> list[SensorFrame]:
    """AHRS at 50 Hz, DVL at 5 Hz, each fin and the propeller at 50 Hz, so many ticks late."""
    late = late or {}
    frame, frames = silence(4), []
    for k in range(TICKS):
        frame, heard = quiet(frame), {}
        for name, every, make in (
            ("ahrs", 2, ahrs),
            ("dvl", 20, dvl),
            ("n", 2, lambda t: Heard(8.0 + t, t, True, True)),
        ):
            true = k - late.get(name, 0)
            if true >= 0 and true % every == 0:
                heard[name] = make(time(true))
        fins = list(frame.fins)
        for i, ticks in enumerate(fins_late):
            if k >= ticks and (k - ticks) % 2 == 0:
                fins[i] = fin(time(k - ticks), i)
        frame = dataclasses.replace(frame, fins=tuple(fins), **heard)
        frames.append(frame)
    return frames


def spans(
    at: FixedLagBuffer,
    frames: Iterable[SensorFrame],
    told: Applied = TOLD,
    first: int = 0,
    idle: tuple[int, ...] = (),
) -> list[Row]:
    rows = []
    for k, frame in enumerate(frames, first):
        at.hear(time(k), frame, told, idle)
        rows += [(t, h, u.tobytes(), z.tobytes(), var.tobytes()) for t, h, u, z, var in at.spans(time(k))]
    return rows


def settled(rows: list[Row], begin: float = 0.3) -> list[Row]:
    """Without the beginning, where what comes late has not come yet and fins do what they were told."""
    return [row for row in rows if row[0] > begin]


CLEAN = spans(horizon(), flight())


def measured(row: Row) -> np.ndarray:
    return np.frombuffer(row[3])


delays = st.integers(0, round(LAG / 0.01) - 1)


@given(delays, delays, delays, st.tuples(delays, delays, delays, delays))
def test_what_comes_late_within_the_lag_comes_to_the_same_to_the_last_bit(
    ahrs_late: int, dvl_late: int, n_late: int, fins_late: tuple[int, int, int, int]
) -> None:
    at = horizon()
    late = spans(at, flight({"ahrs": ahrs_late, "dvl": dvl_late, "n": n_late}, fins_late))
    assert settled(late) == settled(CLEAN)
    assert len(settled(late)) > 30
    assert at.dropped == 0


def test_every_measurement_is_taken_in_once_at_the_time_at_which_it_was_true() -> None:
    rows = {round(row[0], 9): measured(row) for row in CLEAN}
    for k in range(0, 90, 2):
        u, p, psi = rows[round(time(k), 9)][[0, 3, 8]]
        assert (p, psi) == (0.01 * time(k), -0.3 * time(k))
        assert (u == 1.8 + 0.01 * time(k)) if k % 20 == 0 else math.isnan(u)
    assert sum(not math.isnan(z[0]) for z in rows.values()) == 5
    variance = np.frombuffer(CLEAN[[round(row[0], 9) for row in CLEAN].index(0.2)][4])
    assert variance[:3] == pytest.approx(0.02**2)  # what the ping states of itself
    assert np.frombuffer(CLEAN[-1][4])[:3] == pytest.approx(0.01**2)


def test_steps_follow_each_other_without_a_gap_a_lag_behind() -> None:
    ends = np.array([row[0] for row in CLEAN])
    lengths = np.array([row[1] for row in CLEAN])
    np.testing.assert_allclose(np.diff(ends), lengths[1:], rtol=0, atol=1e-12)
    assert lengths.min() > 0.0
    assert lengths.max() <= LONGEST + 1e-9
    assert time(TICKS - 1) - LAG - LONGEST < ends[-1] <= time(TICKS - 1) - LAG + 1e-5


def test_inputs_are_the_means_of_what_each_fin_really_did() -> None:
    inputs = {round(row[0], 9): (np.frombuffer(row[2]), row[1]) for row in settled(CLEAN)}
    for t, ((delta_s, delta_r, delta_b, n), h) in inputs.items():
        a, b = t - h, t
        fine = np.linspace(a, b, 101)
        knots = np.arange(0.0, 1.2, 0.02)
        means = [np.interp(fine, knots, 0.1 * np.sin(3.0 * knots + i)).mean() for i in range(4)]
        assert delta_s == pytest.approx(0.5 * (means[0] + means[1]), abs=1e-5)
        assert delta_r == pytest.approx(0.5 * (means[2] + means[3]), abs=1e-5)
        assert delta_b == 0.0
        assert n == pytest.approx(8.0 + 0.5 * (a + b), abs=1e-9)


def test_a_fin_that_is_idle_counts_as_straight_wherever_it_is() -> None:
    upper, lower = 2, 3
    for row, whole in zip(settled(spans(horizon(), flight(), idle=(upper,))), settled(CLEAN), strict=True):
        fine, knots = np.linspace(row[0] - row[1], row[0], 101), np.arange(0.0, 1.2, 0.02)
        delta_s, delta_r, *_ = np.frombuffer(row[2])
        assert delta_s == np.frombuffer(whole[2])[0]
        assert delta_r == pytest.approx(
            0.5 * np.interp(fine, knots, 0.1 * np.sin(3.0 * knots + lower)).mean(), abs=1e-5
        )


ODD = {
    "late": lambda t: {"dvl": dvl(t - LAG - 0.05)},
    "from the future": lambda t: {"dvl": dvl(t + 0.01)},
    "from far in the future": lambda t: {"ahrs": ahrs(t + 1e9)},
    "backwards": lambda t: {"ahrs": ahrs(t - 0.03)},
    "twice": lambda t: {"ahrs": ahrs(t - 0.01)},
    "at no time": lambda t: {"ahrs": dataclasses.replace(ahrs(t), t_valid=math.nan)},
    "NaN": lambda t: {"ahrs": ahrs(t, q=math.nan)},
    "infinite": lambda t: {"dvl": dvl(t, v=-math.inf)},
    "wild": lambda t: {"ahrs": ahrs(t, r=1e200)},
    "too fast": lambda t: {"dvl": dvl(t, u=-60.0)},
    "endlessly uncertain": lambda t: {"dvl": dvl(t, fom=math.inf)},
}


@given(st.lists(st.tuples(st.integers(20, 58), st.sampled_from(sorted(ODD))), min_size=1, unique_by=lambda odd: odd[0]))
def test_a_measurement_that_is_none_is_counted_and_changes_nothing(course: list[tuple[int, str]]) -> None:
    frames = flight()
    for half, name in course:
        k = 2 * half + 1  # between the reports of the others
        frames[k] = dataclasses.replace(frames[k], **ODD[name](time(k)))
    at = horizon()
    assert spans(at, frames) == CLEAN
    assert at.dropped == len(course)


def test_the_first_measurement_of_a_sensor_is_not_used_behind_the_steps_that_were_made() -> None:
    """Nothing came from the DVL before, so that only the steps are later than it."""
    silent = [dataclasses.replace(frame, dvl=silence(4).dvl) for frame in flight()]
    frames = silent.copy()
    frames[61] = dataclasses.replace(frames[61], dvl=dvl(time(61) - LAG - 0.05))
    at = horizon()
    assert spans(at, frames) == spans(horizon(), silent)
    assert at.dropped == 1


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e300, 2.0])
def test_a_fin_that_reports_what_no_fin_can_do_is_taken_to_do_what_it_was_told(value: float) -> None:
    silent, odd = flight(), flight()
    for k in range(TICKS):
        fins = silent[k].fins
        silent[k] = dataclasses.replace(silent[k], fins=(never(math.nan), *fins[1:]))
        odd[k] = dataclasses.replace(odd[k], fins=(Heard(value, time(k), True, True), *fins[1:]))
    rows = spans(horizon(), odd)
    assert rows == spans(horizon(), silent)
    assert rows != CLEAN
    assert all(np.isfinite(np.frombuffer(row[2])).all() for row in rows)


def test_without_any_report_of_fins_and_propeller_it_is_as_they_were_told() -> None:
    frames = [dataclasses.replace(frame, fins=(never(math.nan),) * 4, n=never(math.nan)) for frame in flight()]
    for row in spans(horizon(), frames):
        assert np.frombuffer(row[2]).tolist() == pytest.approx([0.1, -0.2, 0.0, 5.0], abs=1e-12)


def test_a_report_that_has_become_stale_gives_way_to_the_command() -> None:
    """Its hub died at 0.1 s with the fins elsewhere."""
    frames = flight()
    for k in range(11, TICKS):
        frames[k] = dataclasses.replace(frames[k], fins=tuple(map(still, frames[10].fins)), n=still(frames[10].n))
    rows = spans(horizon(stale=0.3), frames)
    held, gone = np.frombuffer(rows[5][2]), np.frombuffer(rows[-1][2])
    assert gone.tolist() == pytest.approx([0.1, -0.2, 0.0, 5.0], abs=1e-9)
    assert held[3] > 7.9


def still(heard: Heard[float]) -> Heard[float]:
    return dataclasses.replace(heard, fresh=False)


def test_without_any_measurement_the_steps_go_on() -> None:
    frames = [dataclasses.replace(frame, ahrs=silence(4).ahrs, dvl=silence(4).dvl) for frame in flight()]
    rows = spans(horizon(), frames)
    assert all(np.isnan(measured(row)).all() for row in rows)
    assert {round(row[1], 9) for row in rows} == {LONGEST}
    assert rows[-1][0] > time(TICKS - 1) - LAG - LONGEST


@pytest.mark.parametrize("rate", [50, 100, 1000])
def test_no_backlog_builds_up_at_any_rate_with_the_shortest_steps(rate: int) -> None:
    at, dt_ns = horizon(longest=0.005), 10**9 // rate
    frame = silence(4)
    for k in range(3 * rate):
        t = Tick(k, dt_ns).t
        frame = dataclasses.replace(frame, ahrs=ahrs(t - 0.3 / rate), dvl=dvl(t - 0.6 / rate))
        at.hear(t, frame, TOLD)
        assert len(list(at.spans(t))) <= 8
        assert k < rate or t - at.t < LAG + 0.006
        assert len(at.freeze().waiting) <= 2 * (LAG * rate + 2)


@given(st.integers(1, TICKS - 1), st.integers(0, 15), st.integers(0, 15))
def test_it_goes_on_where_it_was_frozen(at: int, ahrs_late: int, dvl_late: int) -> None:
    frames = flight({"ahrs": ahrs_late, "dvl": dvl_late})
    one, other = horizon(), horizon()
    spans(one, frames[:at])
    spans(other, frames[:5])
    other.thaw(one.freeze())
    assert spans(other, frames[at:], first=at) == spans(one, frames[at:], first=at)
    assert other.freeze() == one.freeze()


def test_steps_too_short_to_keep_up_with_are_refused() -> None:
    with pytest.raises(ParamError, match=r"longest_s = 0\.001: out of bounds"):
        params.load(FixedLagBufferParams, {"longest_s": 0.001}, "autopilot.toml")
