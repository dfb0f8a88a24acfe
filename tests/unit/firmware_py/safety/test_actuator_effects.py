"""What the actuator watch makes of the vehicle's motion: fins and propeller that work but do nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from firmware_py.records.health import ActuatorFault
from firmware_py.safety.actuators.hull_response import PERIOD, AxisWatch
from firmware_py.safety.actuators.thrust import Ping, ThrustWatch
from firmware_py.vehicle.turning import pitch_axis
from tests.unit.firmware_py.safety.actuator_bench import VEHICLE

NONE, LOST, WEAK = ActuatorFault.NONE, ActuatorFault.LOST, ActuatorFault.WEAK
DAMPING, CONTROL, TRAVEL, EDDIES = -1.0, -0.2, math.radians(23.0), 0.0122
EVIDENCE = 12.0


@dataclass
class Hull:
    """Pitch under fins that a pilot keeps moving, in eddies, with the noise of gyros: the truth behind an `AxisWatch`.

    `effect` is what the fins make of what they should, `pilot` how the fins move; `named` has times and faults. Where
    the model is `refuted` the watch is told no damping, and judges only whether fins hold in vain.
    """

    seed: int
    effect: float = 1.0
    eddies: float = 0.012
    noise: float = 4.4e-4
    swing: float = math.radians(6.0)
    jam: float = math.nan
    reports: bool = True
    refuted: bool = False
    watch: AxisWatch = field(default_factory=lambda: AxisWatch(EVIDENCE, 1.5 * EDDIES, PERIOD))
    t: float = 0.0
    q: float = 0.0
    theta: float = 0.0
    eddy: float = 0.0
    fin: float = 0.0
    named: list[tuple[float, ActuatorFault]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)

    def run(self, seconds: float) -> ActuatorFault:
        for _ in range(round(seconds / PERIOD)):
            wanted = self.swing * math.copysign(1.0, math.sin(0.8 * self.t)) * (self.swing > 0)
            told = wanted + 2.0 * self.theta + 2.0 * self.q  # positive angles turn the bow down
            self.fin += min(max(min(max(told, -TRAVEL), TRAVEL) - self.fin, -0.7 * PERIOD), 0.7 * PERIOD)
            acts = self.fin if math.isnan(self.jam) else self.jam
            self.eddy += -0.1 * self.eddy * PERIOD + self.eddies * math.sqrt(PERIOD) * self.random.standard_normal()
            before = self.q
            self.q += PERIOD * (DAMPING * self.q + self.effect * CONTROL * acts + self.eddy - 0.05 * self.theta)
            self.theta += PERIOD * self.q
            rate = 0.5 * (before + self.q) + self.noise * self.random.standard_normal()
            over = 0.0 if self.reports else abs(self.fin) / TRAVEL
            was = self.watch.fault
            hull = -0.05 * self.theta
            if self.refuted:
                self.watch.hold(rate, hull, CONTROL * self.fin, over)
            else:
                self.watch.update(rate, DAMPING, hull, CONTROL * self.fin, over)
            if self.watch.fault is not was:
                self.named.append((self.t, self.watch.fault))
            self.t += PERIOD
        return self.watch.fault


@pytest.mark.parametrize("seed", [1000, 1004])
def test_designed_for_the_eddies_that_there_are_it_finds_nothing_in_them(seed: int) -> None:
    before, after = Hull(seed, eddies=0.04), Hull(seed, eddies=0.04)
    after.watch.design(1.5 * after.eddies)
    before.run(300.0)
    after.run(300.0)
    assert before.named != []
    assert after.named == []


@pytest.mark.parametrize("seed", range(1000, 1004))
def test_fins_that_hold_in_vain_are_lost_even_where_the_model_is_refuted(seed: int) -> None:
    sound, jammed = Hull(seed, reports=False, refuted=True), Hull(seed, reports=False, refuted=True)
    assert sound.run(120.0) is NONE
    jammed.run(10.0)
    jammed.jam = math.radians(15.0)
    assert jammed.run(15.0) is LOST
    assert jammed.named[0][0] > 10.0


def test_a_pause_forgets_that_fins_were_held_over() -> None:
    watch = AxisWatch(EVIDENCE, EDDIES, PERIOD)
    for _ in range(20):
        for _ in range(round(3.5 / PERIOD)):  # 0.02 rad/s the wrong way: in vain after 5.6 s
            watch.hold(0.02, 0.0, CONTROL, 1.0)
        watch.pause()
    assert watch.fault is NONE
    for _ in range(round(6.0 / PERIOD)):
        watch.hold(0.02, 0.0, CONTROL, 1.0)
    assert watch.fault is LOST


@pytest.mark.parametrize("seed", range(1000, 1004))
def test_fins_without_force_are_lost(seed: int) -> None:
    hull = Hull(seed)
    assert hull.run(120.0) is NONE
    hull.effect = 0.0
    hull.run(30.0)
    assert [fault for _, fault in hull.named][-1] is LOST


@pytest.mark.parametrize("seed", range(1000, 1004))
def test_half_the_force_is_weak_once_the_whole_is_known_and_good_when_it_is_back(seed: int) -> None:
    hull = Hull(seed, eddies=0.004)
    assert hull.run(200.0) is NONE
    hull.effect = 0.5
    assert hull.run(90.0) is WEAK
    hull.effect = 1.0
    assert hull.run(60.0) is NONE


@pytest.mark.parametrize("effect", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("noise", [4.4e-4, 9e-4])
@pytest.mark.parametrize("eddies", [0.0, 0.012])
def test_sound_fins_are_never_named_with_a_model_that_is_wrong_by_half(
    effect: float, noise: float, eddies: float
) -> None:
    hull = Hull(1000, effect=effect, noise=noise, eddies=eddies)
    assert hull.run(600.0) is NONE
    assert hull.named == []


def test_fins_that_hardly_move_tell_nothing() -> None:
    hull = Hull(1000, swing=0.0, eddies=0.0)
    hull.run(60.0)
    hull.effect = 0.5
    assert hull.run(200.0) is NONE


@pytest.mark.parametrize("jam", [10.0, -10.0, 20.0])
def test_jammed_planes_that_report_nothing_are_known_by_their_consequence_within_15_s(jam: float) -> None:
    hull = Hull(1000, swing=0.0, reports=False)
    assert hull.run(60.0) is NONE
    hull.jam = math.radians(jam)
    assert hull.run(15.0) is LOST


def test_a_pause_keeps_what_was_learned_and_the_fault() -> None:
    hull = Hull(1000)
    hull.run(100.0)
    learned = hull.watch.freeze().learned
    hull.watch.pause()
    hull.watch.pause()
    assert hull.watch.freeze().learned == learned
    hull.effect = 0.0
    hull.run(60.0)
    hull.watch.pause()
    assert hull.watch.fault is LOST


K, ADVANCE = 0.00898, 1.8288 / 8.3333


def thrust_watch() -> ThrustWatch:
    return ThrustWatch(VEHICLE, EVIDENCE, current=1.0, eddies=0.15)


def ping(t: float, u: float, n: float, reported: bool = True, v: float = 0.0, psi: float = 0.0) -> Ping:
    return Ping(t, u, v, psi, 0.0, 0.0, 0.0, 0.0, 0.0, n, reported, True)


def thrust_flight(watch: ThrustWatch, thrust, current=lambda _t: 0.0, seconds=120.0, seed=1000, ordered=1.8):
    """Return the times of changes: `thrust` is the share that the propeller makes, by time.

    The propeller's speed follows the error of the speed over the bottom, as the speed law has it.
    """
    random = np.random.default_rng(seed)
    u, n, named = ordered, ordered / ADVANCE, []
    for i in range(round(seconds * 5)):
        t = 0.2 * i
        water = u - current(t)
        told = min(max(ordered + 4.0 * (ordered - u), 0.0), 3.66) / ADVANCE
        n += min(max(told - n, -1.6), 1.6)
        u += 0.2 * K * (thrust(t) * (ADVANCE * n) ** 2 - water * abs(water))
        was = watch.fault
        if watch.update(ping(t, u + 0.02 * random.standard_normal(), n)) is not was:
            named.append((t, watch.fault))
    return named


@pytest.mark.parametrize("seed", [1000, 1001, 1002])
@pytest.mark.parametrize("current", [-0.5, 0.0])
def test_a_propeller_without_thrust_is_lost_within_half_a_minute_and_good_when_it_pulls_again(
    current: float, seed: int
) -> None:
    thrust = thrust_flight(thrust_watch(), lambda t: 0.0 if 40.0 < t < 80.0 else 1.0, lambda _t: current, seed=seed)
    (lost, fault), (back, good) = thrust
    assert (fault, good) == (LOST, NONE)
    assert 40.0 < lost < 60.0
    assert 80.0 < back < 90.0


@pytest.mark.parametrize("seed", [1000, 1001, 1002])
def test_in_a_following_current_it_is_lost_within_half_a_minute(seed: int) -> None:
    ((lost, fault),) = thrust_flight(thrust_watch(), lambda t: float(t < 40.0), lambda _t: 0.5, seed=seed)
    assert fault is LOST
    assert 40.0 < lost < 70.0


@pytest.mark.parametrize("current", [-1.0, -0.5, 0.5, 1.0])
def test_a_current_is_no_loss_of_thrust(current: float) -> None:
    assert thrust_flight(thrust_watch(), lambda _t: 1.0, lambda _t: current, seconds=600.0) == []


@pytest.mark.parametrize("jump", [-1.0, -0.75, 0.75, 1.0])
@pytest.mark.parametrize("seed", range(1000, 1004))
def test_nor_is_a_current_that_jumps(jump: float, seed: int) -> None:
    named = thrust_flight(thrust_watch(), lambda _t: 1.0, lambda t: jump if t > 60.0 else 0.0, 300.0, seed)
    assert named == []


@pytest.mark.parametrize("spike", [-8.0, -1.0, 1.0, 8.0])
def test_a_false_ping_moves_neither_speed_nor_current(spike: float) -> None:
    watches = thrust_watch(), thrust_watch()
    for watch in watches:
        thrust_flight(watch, lambda _t: 1.0, seconds=20.0)
    lied_to, sound = watches
    for i in range(5):
        for watch in watches:
            off = spike if watch is lied_to and i == 0 else 0.0
            watch.update(ping(20.0 + 0.2 * i, 1.8 + off, 1.8 / ADVANCE))
    (told,), (true,) = (watch.water(20.8) for watch in (lied_to, sound))
    assert told.u == pytest.approx(true.u, abs=0.02)
    assert told.north == pytest.approx(true.north, abs=0.02)


def test_pings_that_stay_elsewhere_are_taken_up_again_after_a_second() -> None:
    watch = thrust_watch()
    thrust_flight(watch, lambda _t: 1.0, seconds=20.0)
    for i in range(60):
        watch.update(ping(20.0 + 0.2 * i, 2.6, 1.8 / ADVANCE))
    (water,) = watch.water(31.8)
    assert water.u + water.north == pytest.approx(2.6, abs=0.1)


@pytest.mark.parametrize("current", [-1.0, 1.0])
def test_speed_through_the_water_and_current_are_told_apart_within_half_a_minute(current: float) -> None:
    watch = thrust_watch()
    thrust_flight(watch, lambda _t: 1.0, lambda _t: current, seconds=30.0)
    (water,) = watch.water(29.9)
    assert water.north == pytest.approx(current, abs=0.3)
    assert abs(water.east) < 0.1
    assert watch.water(32.0) == ()


@pytest.mark.parametrize(("q", "fault"), [(0.0, LOST), (math.radians(4.0), NONE)])
def test_what_slows_a_hull_that_pitches_hard_is_no_loss_of_thrust(q: float, fault: ActuatorFault) -> None:
    watch = thrust_watch()
    for i in range(165):
        t = 0.2 * i
        slowed = max(0.0, t - 16.0)
        n = (1.8 + 0.15 * slowed) / ADVANCE
        watch.update(ping(t, 1.8 - 0.03 * slowed, n)._replace(q=q if slowed else 0.0, planes=5.0 * q))
    assert watch.fault is fault


def test_after_a_turn_the_current_is_known_along_the_new_heading() -> None:
    watch = thrust_watch()
    for i in range(300):
        psi = 0.0 if i < 200 else math.pi / 2.0
        u, v = (1.8, 0.6) if i < 200 else (2.4, 0.0)
        watch.update(ping(0.2 * i, u, 1.8 / ADVANCE, v=v, psi=psi))
    (water,) = watch.water(59.8)
    assert water.along(math.pi / 2.0) == pytest.approx(0.6, abs=0.1)
    assert water.u == pytest.approx(1.8, abs=0.1)


def runaway_flight(
    watch: ThrustWatch, n: float, true: float, current: float = 0.0, reported: bool = False
) -> list[Any]:
    """Return what is named, and when, of a propeller that turns at `true` from 60 s on, rev/s; `n` is commanded."""
    random = np.random.default_rng(1000)
    named = []
    u = ADVANCE * n + current
    for i in range(1000):
        t, water = 0.2 * i, u - current
        u += 0.2 * K * ((ADVANCE * (true if t > 60.0 else n)) ** 2 - water * abs(water))
        was = watch.fault
        if watch.update(ping(t, u + 0.02 * random.standard_normal(), n, reported)) is not was:
            named.append((t, watch.fault))
    return named


@pytest.mark.parametrize(("n", "true", "within"), [(8.333, 16.667, 40.0), (4.0, 16.667, 40.0), (0.0, 10.0, 60.0)])
def test_a_propeller_that_runs_away_is_named_by_the_speed_it_makes(n: float, true: float, within: float) -> None:
    ((t, fault),) = runaway_flight(thrust_watch(), n, true)
    assert fault is ActuatorFault.RUNAWAY
    assert 60.0 < t < 60.0 + within


def test_a_propeller_that_reports_its_speed_does_not_run_away_unseen() -> None:
    assert runaway_flight(thrust_watch(), 8.333, 16.667, reported=True) == []


@pytest.mark.parametrize("n", [2.0, 4.0, 8.333, 14.0])
@pytest.mark.parametrize("current", [-0.5, 0.5, 1.0])
def test_a_following_current_is_no_propeller_that_runs_away(n: float, current: float) -> None:
    assert runaway_flight(thrust_watch(), n, n, current) == []


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_gyros_without_noise_make_no_fault_of_a_step(noise: float) -> None:
    """A minute of quiet, then a step of the planes: the vehicle answers a step of the filter after their report."""
    axis = pitch_axis(VEHICLE)
    watch, random = AxisWatch(EVIDENCE, axis.eddies(1.8, 0.15), PERIOD), np.random.default_rng(1)
    u, rate, most = 1.8, 0.0, 0.0
    for k in range(round(70.0 / PERIOD)):
        angle = math.radians(10.0) * min(max(0.0, k * PERIOD - 60.0) / 0.25, 1.0)  # 40 deg/s
        fins = u * u * axis.control * angle
        assert watch.update(rate + noise * random.standard_normal(), u * axis.damping, 0.0, fins, 0.0) is NONE
        rate += PERIOD * (u * axis.damping * rate + fins)
        most = max(most, watch.freeze().lost)
    assert most < 0.5 * EVIDENCE
