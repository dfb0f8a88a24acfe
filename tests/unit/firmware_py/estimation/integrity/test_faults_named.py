"""Each fault is named in time, with its cause, at the right sensor; a sound voyage names none."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from firmware_py.records.command import Applied
from firmware_py.records.health import ALL_GOOD, GOOD, SourceFault, SourceState
from firmware_py.records.sensing import Dvl, SensorFrame, never, node_bit

from .voyage import DEG, RESTS, SPEED, Fault, after, frozen, named, voyage

G = 9806.65
SUSPECT, LOST = SourceState.SUSPECT, SourceState.LOST
F = SourceFault


def drifting(rate: float) -> Fault:
    return after(20.0, lambda age, p: p + rate * age * G)


def off(name: str, by: float) -> Fault:
    return after(20.0, lambda _, value: value._replace(**{name: getattr(value, name) + by}))


def of_unknown_altitude(fault: Fault) -> Fault:
    """Return a fault of a DVL that tells no altitude: each time another NaN, as a replayed log has them."""
    return lambda t, value: fault(t, value)._replace(altitude=float("nan"))


CASES: dict[str, tuple[str, Fault, str, set[SourceFault], float]] = {
    "pressure frozen": ("pressure", frozen(20.0), "pressure", {F.FROZEN}, 0.5),
    "AHRS frozen": ("ahrs", frozen(20.0), "ahrs", {F.FROZEN}, 0.5),
    "DVL frozen": ("dvl", frozen(20.0), "dvl", {F.FROZEN}, 0.6),
    "DVL frozen, without bottom": ("dvl", of_unknown_altitude(frozen(20.0)), "dvl", {F.FROZEN}, 0.6),
    "altimeter frozen, diving": ("altitude", frozen(20.0), "altitude", {F.CONTRADICTED, F.FROZEN}, 4.0),
    "pressure drifts by -0.5 m/s": ("pressure", drifting(-0.5), "pressure", {F.DRIFT}, 1.0),
    "pressure drifts by +0.5 m/s": ("pressure", drifting(0.5), "pressure", {F.DRIFT}, 1.0),
    "pressure drifts by -0.1 m/s": ("pressure", drifting(-0.1), "pressure", {F.DRIFT}, 3.5),
    "pressure steps by -3 m": ("pressure", after(20.0, lambda _, p: p - 3.0 * G), "pressure", {F.STEP}, 0.3),
    "pressure under the air's": ("pressure", after(20.0, lambda _, p: 65504.0), "pressure", {F.IMPOSSIBLE}, 0.3),
    "pitch off by 5 deg": ("ahrs", off("theta", 5 * DEG), "ahrs", {F.STEP}, 0.2),
    "heading off by 5 deg": ("ahrs", off("psi", 5 * DEG), "ahrs", {F.HEADING}, 0.2),
    "gyro off by 5 deg/s": ("ahrs", off("r", 5 * DEG), "ahrs", {F.DRIFT, F.STEP}, 1.0),
    "DVL u off by 1 m/s": ("dvl", off("u", 1.0), "dvl", {F.STEP}, 0.9),
    "DVL w off by 0.3 m/s": ("dvl", off("w", 0.3), "dvl", {F.DRIFT}, 1.5),
    "DVL faster than the vehicle": ("dvl", after(20.0, lambda _, v: v._replace(u=9.9)), "dvl", {F.IMPOSSIBLE}, 0.7),
    "altimeter shows 1 m": ("altitude", after(20.0, lambda _, a: 1.0), "altitude", {F.STEP}, 0.5),
    "DVL altitude off by 2 m": ("dvl", off("altitude", 2.0), "dvl", {F.CONTRADICTED, F.STEP}, 1.0),
}


@pytest.mark.parametrize(("field", "fault", "sensor", "faults", "within"), CASES.values(), ids=CASES)
def test_a_fault_is_named_in_time_at_the_sensor_that_has_it(
    field: str, fault: Fault, sensor: str, faults: set[SourceFault], within: float
) -> None:
    changes = named(voyage(25.0, {field: fault}))
    t, name, health = changes[0]
    assert (name, health.state) == (sensor, SUSPECT)
    assert health.fault in faults
    assert 0.0 <= t - 20.0 <= within
    assert {other for _, other, _ in changes} == {sensor}


@pytest.mark.parametrize("noise", [1.0, 2.0])
def test_a_sound_voyage_names_nothing_and_passes_every_frame_on_as_it_was_heard(noise: float) -> None:
    for seen in voyage(45.0, noise=noise, seed=7):
        assert seen.health == ALL_GOOD
        assert seen.believed is seen.heard


def test_a_vehicle_that_rests_is_sound_whether_its_sensors_have_noise_or_none() -> None:
    for noise in (0.0, 1.0):
        assert not named(voyage(20.0, noise=noise, speed=0.0, start=0.0, applied=RESTS))


def test_a_vehicle_that_rests_though_its_propeller_turns_is_sound() -> None:
    """It is tied up, or has lost its blades."""
    assert not named(voyage(20.0, speed=0.0, start=0.0))


@pytest.mark.parametrize("late", [38.0, 85.0])
def test_a_pressure_that_freezes_late_in_a_steep_dive_is_named_in_half_a_second(late: float) -> None:
    """Its noise, by which a frozen sensor is told from one without any, does not reverse its changes in a dive."""
    (t, sensor, health), *_ = named(voyage(late + 1.0, {"pressure": frozen(late)}, noise=0.3, dive=(10.0, 95.0)))
    assert (sensor, health) == ("pressure", (SUSPECT, F.FROZEN))
    assert t - late <= 0.5


@pytest.mark.parametrize(("step", "noise"), [(98.07, 0.4), (20.0, 0.1), (10.0, 0.04)])
def test_a_pressure_whose_steps_are_wider_than_its_noise_is_not_frozen(step: float, noise: float) -> None:
    """Toggling between two steps looks like noise; a centimetre of water is 98 Pa. `noise` is of 50 Pa."""
    for speed in (0.0, SPEED):
        rounded = {"pressure": lambda _, value: round(value / step) * step}
        changes = named(voyage(120.0, rounded, noise=noise, speed=speed))
        assert all(health.fault is not F.FROZEN for _, _, health in changes)


def test_a_sensor_without_noise_may_repeat_its_value_after_it_has_heaved() -> None:
    """A noiseless pressure in a swell of 6 s, which reverses its changes as noise does, but seldom, and then rests."""

    def swell(t: float, value: float) -> float:
        return value + 9806.65 * 0.3 * math.sin(math.tau * min(t, 60.0) / 6.0)

    changes = named(voyage(70.0, {"pressure": swell}, noise=0.0, speed=0.0, applied=RESTS))
    assert all(health.fault is not F.FROZEN for _, _, health in changes)


def test_a_battery_that_no_longer_knows_its_charge_is_lost_at_the_timeout() -> None:
    unknown = after(5.0, lambda _, battery: battery._replace(remaining=math.nan))
    changes = named(voyage(10.0, {"battery": unknown}))
    assert [(name, health) for _, name, health in changes] == [("battery", (LOST, F.UNHEALTHY))]
    assert changes[0][0] <= 4.0 + 3.1


def test_without_dvl_a_drift_of_half_a_metre_a_second_is_named_within_6_s() -> None:
    def without(t: float, frame: SensorFrame) -> SensorFrame:
        return frame if t < 5.0 else replace(frame, dvl=never(frame.dvl.value))

    fault = after(20.0, lambda age, p: p - 0.5 * age * G)
    changes = named(voyage(27.0, {"pressure": fault}, change=without))
    (t, health), *_ = [(t, health) for t, name, health in changes if name == "pressure"]
    assert health == (SUSPECT, F.DRIFT)
    assert t - 20.0 <= 6.0


@pytest.mark.parametrize("drop", [True, False])
@pytest.mark.parametrize("dvl", [True, False])
def test_a_stopped_vehicle_that_its_buoyancy_drives_is_believed(dvl: bool, drop: bool) -> None:
    """It rises by 0.4 m/s and glides ahead by up to 1 m/s, level: neither thrust and drag nor its pitch tell of it."""

    def gliding(age: float, ping: Dvl) -> Dvl:
        return Dvl(min(0.1 * age, 1.0), 0.0, -0.4, ping.fom, ping.altitude + 0.4 * age)

    faults = {
        "pressure": after(5.0, lambda age, p: p - 0.4 * age * G),
        "altitude": after(5.0, lambda age, a: a + 0.4 * age),
        "dvl": after(5.0, gliding),
    }
    applied = Applied((0.0,) * 4, 0.0, True, False, drop=drop)
    silent = () if dvl else ("dvl",)
    changes = named(voyage(40.0, faults, speed=0.0, start=25.0, applied=applied, silent=silent))
    assert [(name, health) for _, name, health in changes] == ([] if dvl else [("dvl", (LOST, F.SILENT))])


def test_a_stopped_vehicle_still_names_a_pressure_that_freezes_or_steps() -> None:
    applied = Applied((0.0,) * 4, 0.0, True, False, drop=True)
    for fault, kind in ((frozen(20.0), F.FROZEN), (after(20.0, lambda _, p: p + 3.0 * G), F.STEP)):
        changes = named(voyage(25.0, {"pressure": fault}, speed=0.0, start=20.0, applied=applied, silent=("dvl",)))
        assert [health for _, name, health in changes if name == "pressure"] == [(SUSPECT, kind)]


@pytest.mark.parametrize(
    ("field", "sensor", "timeout"),
    [("ahrs", "ahrs", 0.5), ("pressure", "pressure", 1.0), ("dvl", "dvl", 2.0), ("altitude", "altitude", 2.0)],
)
def test_silence_is_named_at_the_timeout_and_forgotten_when_it_was_heard_again_for_5_s(
    field: str, sensor: str, timeout: float
) -> None:
    def cut(t: float, frame: SensorFrame) -> SensorFrame:
        return mute(frame, field) if 5.005 <= t < 9.0 else frame

    held: dict[str, Any] = {}

    def mute(frame: SensorFrame, name: str) -> SensorFrame:
        before = held.setdefault(name, replace(getattr(frame, name), fresh=False))
        return replace(frame, **{name: before})

    changes = [(t, health) for t, name, health in named(voyage(15.0, change=cut)) if name == sensor]
    (lost, first), (back, last), *_ = changes
    assert first == (LOST, F.SILENT)
    assert timeout <= lost - held[field].t_valid <= timeout + 0.12
    assert last.state is SourceState.GOOD
    assert 14.0 <= back <= 14.6


@pytest.mark.parametrize(("field", "sensor", "gap"), [("dvl", "dvl", 2.4), ("altitude", "altitude", 2.4)])
def test_a_sensor_that_comes_and_goes_is_lost_once_and_not_at_every_gap(field: str, sensor: str, gap: float) -> None:
    def now_and_then(t: float, frame: SensorFrame) -> SensorFrame:
        heard = getattr(frame, field)
        through = t < 5.0 or (t % gap < 0.25 and heard.fresh)
        held[field] = heard if through else replace(held[field], fresh=False)
        return replace(frame, **{field: held[field]})

    held: dict[str, Any] = {}
    changes = [health for _, name, health in named(voyage(25.0, change=now_and_then)) if name == sensor]
    assert changes == [(LOST, F.SILENT)]


def spinning(t: float, frame: SensorFrame) -> SensorFrame:
    """Turn the vehicle to port at 40 deg/s from 10 s to 11 s, while its way is kept; the DVL is 1 m astern."""
    if t < 10.0:
        return frame
    turned, r = -40.0 * DEG * min(t - 10.0, 1.0), -40.0 * DEG if t < 11.0 else 0.0
    u, v = SPEED * math.cos(turned), -SPEED * math.sin(turned) - r * 1.0
    if frame.ahrs.fresh:
        said = frame.ahrs.value
        frame = replace(frame, ahrs=replace(frame.ahrs, value=said._replace(psi=said.psi + turned, r=said.r + r)))
    if frame.dvl.fresh:
        frame = replace(frame, dvl=replace(frame.dvl, value=frame.dvl.value._replace(u=u, v=v)))
    return frame


def test_a_dvl_of_a_vehicle_that_spins_has_made_no_step() -> None:
    assert not [health for t, name, health in named(voyage(13.0, change=spinning)) if name == "dvl" and t < 11.5]


def test_the_same_velocities_without_rotation_are_a_step() -> None:
    def without(t: float, frame: SensorFrame) -> SensorFrame:
        return replace(spinning(t, frame), ahrs=frame.ahrs)

    assert (SUSPECT, F.STEP) in [health for t, _, health in named(voyage(13.0, change=without)) if t < 11.5]


def test_a_sensor_that_was_never_heard_is_lost_5_s_after_the_start() -> None:
    (t, name, health), *_ = named(voyage(6.0, silent=("leak",)))
    assert (name, health) == ("leak", (LOST, F.SILENT))
    assert t == pytest.approx(5.0, abs=0.2)


def test_what_is_not_a_number_is_a_sensor_that_reports_itself_but_no_bottom_in_reach_is_none() -> None:
    def no_number(t: float, frame: SensorFrame) -> SensorFrame:
        if t < 5.0:
            return frame
        return replace(
            frame,
            pressure=replace(frame.pressure, value=float("nan"), ok=False),
            altitude=replace(frame.altitude, value=float("inf"), ok=False),
        )

    changes = named(voyage(8.0, change=no_number))
    assert [(name, health) for _, name, health in changes] == [("pressure", (LOST, F.UNHEALTHY))]


def test_two_senders_under_a_nodes_id_are_named_at_once() -> None:
    def doubled(t: float, frame: SensorFrame) -> SensorFrame:
        return frame if t < 5.0 else replace(frame, two_senders=node_bit("pressure"))

    (t, name, health), *_ = named(voyage(6.0, change=doubled))
    assert (t, name, health) == (5.0, "pressure", (LOST, F.TWO_SENDERS))


@pytest.mark.parametrize("node", ["two_senders", "replaced"])
@pytest.mark.parametrize("until", [8.0, 8.02, 8.05, 8.09])
def test_what_was_withheld_is_named_by_its_reason_until_it_is_good_again(node: str, until: float) -> None:
    def withheld(t: float, frame: SensorFrame) -> SensorFrame:
        if not 5.0 <= t < until:
            lost = until <= t < until + 0.15
            ahrs = replace(frame.ahrs, fresh=not lost, ok=not lost and t < 20.0)
            return replace(frame, ahrs=ahrs, **{node: 0})
        return replace(frame, ahrs=replace(frame.ahrs, ok=False), **{node: node_bit("ahrs")})

    fault = {"two_senders": F.TWO_SENDERS, "replaced": F.OTHER_DEVICE}[node]
    changes = [(name, health) for _, name, health in named(voyage(23.0, change=withheld)) if name == "ahrs"]
    assert changes == [("ahrs", (LOST, fault)), ("ahrs", GOOD), ("ahrs", (LOST, F.UNHEALTHY))]


def test_a_sensor_that_says_itself_that_it_does_not_work_once_its_double_is_gone_is_named_so() -> None:
    def failing(t: float, frame: SensorFrame) -> SensorFrame:
        if t < 5.0:
            return frame
        bits = node_bit("ahrs") if t < 8.0 else 0
        return replace(frame, ahrs=replace(frame.ahrs, ok=False), two_senders=bits)

    changes = [(name, health.fault) for _, name, health in named(voyage(12.0, change=failing)) if name == "ahrs"]
    assert changes == [("ahrs", F.TWO_SENDERS), ("ahrs", F.UNHEALTHY)]


def test_without_attitude_the_altitudes_still_agree_while_the_depth_changes() -> None:
    def climb(t: float, frame: SensorFrame) -> SensorFrame:
        if t < 5.0:
            return frame
        up = 1.2 * (t - 5.0)
        pressure, altitude, dvl = frame.pressure, frame.altitude, frame.dvl
        if pressure.fresh:
            pressure = replace(pressure, value=pressure.value - up * G)
        if altitude.fresh:
            altitude = replace(altitude, value=altitude.value + up)
        if dvl.fresh:
            dvl = replace(dvl, value=dvl.value._replace(altitude=dvl.value.altitude + up))
        return replace(frame, ahrs=never(frame.ahrs.value), pressure=pressure, altitude=altitude, dvl=dvl)

    changes = named(voyage(25.0, change=climb, start=30.0, dive=(90.0, 95.0)))
    assert [(name, health) for _, name, health in changes] == [("ahrs", (LOST, F.SILENT))]


def test_a_fix_that_is_silent_under_water_is_no_fault_but_is_near_the_surface() -> None:
    def cut(t: float, frame: SensorFrame) -> SensorFrame:
        return frame if t < 6.0 else replace(frame, fix=never(frame.fix.value))

    assert not named(voyage(15.0, change=cut))
    changes = named(voyage(15.0, change=cut, start=2.0, dive=(90.0, 95.0)))
    assert [(name, health) for _, name, health in changes] == [("fix", (LOST, F.SILENT))]


@pytest.mark.parametrize("off", [-1.5, -1.4])
def test_a_dvl_whose_speed_is_wrong_from_the_start_does_not_convict_the_pitch(off: float) -> None:
    """It looks like a current until the first dive, and carries no depth then; propeller and pitch explain it."""
    seen = named(voyage(90.0, {"dvl": lambda _, said: said._replace(u=said.u + off)}, dive=(50.0, 85.0)))
    assert ("dvl", F.DRIFT) in {(sensor, health.fault) for _, sensor, health in seen}
    assert ("ahrs", F.CONTRADICTED) not in {(sensor, health.fault) for _, sensor, health in seen}
