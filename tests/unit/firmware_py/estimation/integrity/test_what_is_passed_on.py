"""What navigation gets instead of a value that is not believed, and when a sensor is believed again."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.marine import wrap
from firmware_py.records.health import ALL_GOOD, SensorHealth, SourceState
from firmware_py.records.sensing import Fix, SensorFrame, never

from .voyage import BOTTOM, DEG, ORIGIN, RESTS, Fault, after, named, new, once, pitch_at, voyage

G = 9806.65

SPIKES: dict[str, tuple[str, Any]] = {
    "pressure of a metre": ("pressure", lambda p: p + G),
    "pressure of 37 m": ("pressure", lambda p: 101325.0 + 37.65 * G),
    "pressure in the air": ("pressure", lambda p: 101325.0),
    "pressure of nothing": ("pressure", lambda p: 0.0),
    "heading": ("ahrs", lambda a: a._replace(psi=wrap(a.psi + 2.0))),
    "pitch": ("ahrs", lambda a: a._replace(theta=1.4)),
    "roll": ("ahrs", lambda a: a._replace(phi=-3.0)),
    "gyro": ("ahrs", lambda a: a._replace(r=3.0)),
    "DVL u": ("dvl", lambda v: v._replace(u=9.9)),
    "DVL w": ("dvl", lambda v: v._replace(w=1.0)),
    "altimeter": ("altitude", lambda a: 0.5),
    "DVL altitude": ("dvl", lambda v: v._replace(altitude=0.4)),
    "charge": ("battery", lambda b: b._replace(remaining=0.0)),
    "humidity": ("leak", lambda h: 1.0),
    "fix under water": ("fix", lambda f: f),
}


@pytest.mark.parametrize(("field", "spike"), SPIKES.values(), ids=SPIKES)
def test_one_false_value_is_never_passed_on_and_accuses_nobody_but_a_fix_that_cannot_be(field: str, spike: Any) -> None:
    struck: list[Any] = []

    def strike(value: Any) -> Any:
        struck.append(spike(value))
        return struck[0]

    fault = once(20.0, strike)
    quiet = field == "fix"
    faults = {field: fault if not quiet else lambda t, v: strike(v) if 20.0 <= t < 20.5 else None}
    integrity = new()
    for seen in voyage(24.0, faults, integrity=integrity):
        passed = getattr(seen.believed, field)
        if struck and passed.ok and passed.value == struck[0]:
            raise AssertionError(f"passed on at {seen.t}")
        if not quiet:
            assert seen.health == ALL_GOOD
    left_out = dict(zip(SensorHealth._fields, integrity.refused, strict=True))
    assert left_out == dict.fromkeys(SensorHealth._fields, 0) | {field: 0 if quiet else 1}


@pytest.mark.parametrize("rate", [-0.5, -0.1, 0.5])
def test_depth_is_put_back_to_where_it_was_before_the_drift_was_noticed(rate: float) -> None:
    fault = after(20.0, lambda age, p: p + rate * age * G)
    corrections = [(seen.t, seen.depth_corrected - seen.z) for seen in voyage(26.0, {"pressure": fault})]
    (error,) = [error for _, error in corrections if not math.isnan(error)]
    assert abs(error) < 0.1


def test_heading_is_carried_on_by_the_gyros_after_a_step_and_put_right() -> None:
    fault = after(20.0, lambda _, a: a._replace(psi=wrap(a.psi + 20 * DEG)))
    errors, corrected = [], []
    for seen in voyage(40.0, {"ahrs": fault}):
        if seen.t > 20.2:
            errors.append(abs(wrap(seen.believed.ahrs.value.psi - seen.psi)))
            assert seen.believed.ahrs.ok
        if not math.isnan(seen.heading_corrected):
            corrected.append(abs(wrap(seen.heading_corrected - seen.psi)))
    assert max(errors) < 1.0 * DEG
    assert len(corrected) == 1
    assert corrected[0] < 1.0 * DEG


LIES: dict[str, Any] = {
    "heading": lambda a: a._replace(psi=wrap(a.psi + 60 * DEG)),
    "pitch": lambda a: a._replace(theta=a.theta + 8 * DEG),
}
DIVE = (10.0, 30.0)


def silenced(begin: float, lasts: float) -> Any:
    def silent(t: float, frame: SensorFrame) -> SensorFrame:
        return replace(frame, ahrs=replace(frame.ahrs, fresh=False)) if begin <= t < begin + lasts else frame

    return silent


@pytest.mark.parametrize(("lie", "lasts"), [("heading", 0.6), ("heading", 8.0), ("pitch", 0.6)])
def test_an_ahrs_that_comes_back_from_a_silence_as_wrong_as_it_was_is_not_believed(lie: str, lasts: float) -> None:
    for seen in voyage(50.0, {"ahrs": after(20.0, lambda _, a: LIES[lie](a))}, change=silenced(25.0, lasts)):
        off = seen.believed.ahrs.value.psi - seen.psi, seen.believed.ahrs.value.theta - pitch_at(seen.t, DIVE)[0]
        if seen.t > 20.2 and seen.believed.ahrs.fresh:
            assert max(abs(wrap(off[0])), abs(off[1])) < 3.0 * DEG
    assert seen.health.ahrs.state is SourceState.SUSPECT


@pytest.mark.parametrize("lie", LIES)
@pytest.mark.parametrize("lasts", [0.6, 8.0])
def test_an_ahrs_that_was_restarted_and_is_right_again_is_believed(lie: str, lasts: float) -> None:
    fault = after(20.0, lambda _, a: LIES[lie](a), until=25.0)
    *_, seen = voyage(25.0 + lasts + 6.0, {"ahrs": fault}, change=silenced(25.0, lasts))
    assert seen.health == ALL_GOOD
    assert seen.believed.ahrs == seen.heard.ahrs


def test_on_deck_a_silence_ends_the_accusation() -> None:
    fault = after(20.0, lambda _, a: LIES["heading"](a))
    options: dict[str, Any] = {"speed": 0.0, "start": 0.0, "applied": RESTS, "change": silenced(25.0, 0.6)}
    *_, before = voyage(25.0, {"ahrs": fault}, **options)
    *_, seen = voyage(32.0, {"ahrs": fault}, **options)
    assert (before.health.ahrs.state, seen.health.ahrs.state) == (SourceState.SUSPECT, SourceState.GOOD)


def test_a_wrong_gyro_does_not_lead_the_heading_astray() -> None:
    fault = after(20.0, lambda _, a: a._replace(r=a.r + 5 * DEG))
    worst = max(abs(wrap(seen.believed.ahrs.value.psi - seen.psi)) for seen in voyage(45.0, {"ahrs": fault}))
    assert worst < 5.0 * DEG


def test_0_7_s_of_a_false_altitude_never_arrives_while_the_dvl_measures_another() -> None:
    fault = after(20.0, lambda _, a: 1.0, until=20.7)
    seen = list(voyage(30.0, {"altitude": fault}))
    passed = [s.believed.altitude.value for s in seen if s.believed.altitude.ok]
    assert min(passed) > 20.0
    assert seen[-1].health == ALL_GOOD


def test_a_bottom_that_both_sensors_see_rise_is_believed() -> None:
    faults: dict[str, Fault] = {
        "altitude": after(20.0, lambda _, a: a - 20.0),
        "dvl": after(20.0, lambda _, v: v._replace(altitude=v.altitude - 20.0)),
    }
    *_, last = voyage(22.0, faults)
    assert last.health.altitude.state is SourceState.GOOD
    assert last.believed.altitude.value == pytest.approx(40.0 - last.z - 20.0, abs=0.3)


def test_a_single_altimeter_that_jumps_is_believed_when_nobody_objects() -> None:
    fault = after(20.0, lambda _, a: 1.0)
    *_, last = voyage(21.0, {"altitude": fault}, silent=("dvl",))
    assert last.believed.altitude.ok
    assert last.believed.altitude.value == 1.0


def test_a_pressure_that_agrees_again_is_good_after_5_s() -> None:
    fault = after(20.0, lambda _, p: p + 3.0 * G, until=25.0)
    changes = named(voyage(36.0, {"pressure": fault}))
    (first, _, _), (back, _, health) = changes
    assert first < 20.5
    assert health.state is SourceState.GOOD
    assert 29.9 <= back <= 30.5


def test_charge_and_humidity_that_stay_are_believed_at_the_second_reading() -> None:
    faults: dict[str, Fault] = {
        "battery": after(20.0, lambda _, b: b._replace(remaining=0.05)),
        "leak": after(20.0, lambda _, h: 0.95),
    }
    first: dict[str, float] = {}
    for seen in voyage(24.0, faults):
        if seen.believed.battery.value.remaining == 0.05:
            first.setdefault("battery", seen.t)
        if seen.believed.leak.value == 0.95:
            first.setdefault("leak", seen.t)
    assert first == {"battery": 21.0, "leak": 21.0}


def test_a_leak_sensor_that_repeats_its_greatest_value_is_still_believed() -> None:
    *_, last = voyage(45.0, {"leak": after(20.0, lambda _, h: 1.0)})
    assert (last.believed.leak.ok, last.believed.leak.value) == (True, 1.0)
    assert last.health == ALL_GOOD


def test_at_the_surface_a_fix_is_used_when_a_second_confirms_it_and_one_that_jumps_is_not() -> None:
    def fix(t: float, value: Fix) -> Fix:
        return value._replace(latitude=value.latitude + (1e-3 if 9.5 < t < 10.5 else 0.0))

    used = set()
    for seen in voyage(15.0, {"fix": fix}, speed=0.0, start=0.0):
        if seen.believed.fix.fresh and seen.believed.fix.ok:
            used.add(round(seen.t))
            assert abs(seen.believed.fix.value.latitude - ORIGIN.latitude) < 1e-5
    assert used == set(range(1, 15)) - {10}


def test_where_nothing_is_judged_any_longer_nobody_stays_accused() -> None:
    judged, idle = new(), new(IntegrityParams(enabled=False))
    judged._velocity.way.memory.doubt = 5.0
    *_, last = voyage(22.0, {"pressure": after(20.0, lambda _, p: p + G)}, integrity=judged)
    assert last.health.pressure.state is SourceState.SUSPECT
    idle.thaw(judged.freeze())
    assert (idle.health, idle.doubt) == (ALL_GOOD, 0.0)


def test_memory_taken_over_goes_on_as_if_nothing_had_happened() -> None:
    fault = after(8.0, lambda age, p: p - 0.3 * age * G)
    whole, halves = new(), new()
    ticks = list(voyage(12.0, {"pressure": fault}, integrity=whole))
    for k, seen in enumerate(
        voyage(12.0, {"pressure": after(8.0, lambda age, p: p - 0.3 * age * G)}, integrity=halves)
    ):
        assert (seen.believed, seen.health) == (ticks[k].believed, ticks[k].health)
    again = new()
    again.thaw(halves.freeze())
    assert again.freeze() == whole.freeze()


@pytest.mark.parametrize(("interval", "false"), [(150, math.nan), (10, math.nan), (10, 2.0)])
def test_an_altitude_that_is_another_after_a_silence_waits_for_a_second_however_slow_its_sensor_is(
    interval: int, false: float
) -> None:
    """Nothing is heard for 7 s, then a reading every so many hundredths of a second, the first one `false`."""
    heard = [never(math.nan)]

    def spoken(t: float, frame: SensorFrame) -> SensorFrame:
        k = round(t * 100)
        if frame.altitude.fresh and (t < 20.0 or (t >= 27.0 and k % interval == 0)):
            first = k == 2700 and false == false
            heard[0] = replace(frame.altitude, value=false) if first else frame.altitude
            return replace(frame, altitude=heard[0])
        return replace(frame, altitude=replace(heard[0], fresh=False))

    seen = list(voyage(40.0, silent=("dvl",), change=spoken))
    assert not any(one.believed.altitude.ok and one.believed.altitude.value == false for one in seen)
    later = [one for one in seen if one.t > 36.0]
    assert all(one.believed.altitude.ok for one in later)
    assert max(abs(one.believed.altitude.value - (BOTTOM - one.z)) for one in later) < 1.0
