"""What the actuator watch makes of reports: each fault by its name and in its time, and no other."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest

from firmware_py.records.health import ActuatorFault, sound
from firmware_py.safety.actuators.share_watch import SHARES
from tests.unit.firmware_py.safety.actuator_bench import FINS, Bench, Servo, still, sweep

NONE, SILENT, JAMMED = ActuatorFault.NONE, ActuatorFault.SILENT, ActuatorFault.JAMMED
PROPELLER = FINS


def deg(angle: float) -> float:
    return math.radians(angle)


@pytest.mark.parametrize("angle", [10.0, -10.0, 15.0, -20.0])
def test_a_jam_at_an_angle_is_named_within_a_second(angle: float) -> None:
    bench = Bench(told=still)
    bench.run(5.0)
    bench.servos[1].goes_to = deg(angle)
    bench.run(3.0)
    ((t, fault),) = bench.fin(1)
    assert fault is JAMMED
    assert t - 5.0 <= 1.0
    assert bench.health.fins == (NONE, JAMMED, NONE, NONE)


def test_a_jam_where_it_is_is_named_when_the_command_has_left_it_for_a_second() -> None:
    bench = Bench(told=lambda t: 0.0 if t < 20.0 else deg(4.0))
    bench.run(5.0)
    bench.servos[0].goes_to = 0.0
    assert bench.run(15.0).faultless
    bench.run(1.0)
    assert [fault for _, fault in bench.fin()] == [JAMMED]


@pytest.mark.parametrize("start", [0.0, -23.0])
def test_a_fin_at_the_end_of_its_travel_is_hard_over(start: float) -> None:
    bench = Bench(told=lambda _t: deg(start))
    bench.run(5.0)
    bench.servos[2].goes_to = 1.0
    bench.run(3.0)
    (t, _), *_ = bench.fin(2)
    assert t - 5.0 <= 1.0  # from the other end it is 1.15 s on its way: jammed at first
    assert bench.health.fins[2] is ActuatorFault.HARD_OVER


def test_a_servo_of_five_degrees_a_second_is_slow_and_recovers_when_it_is_quick_again() -> None:
    bench = Bench()
    bench.run(5.0)
    bench.servos[0].rate = deg(5.0)
    bench.run(8.0)
    assert [fault for _, fault in bench.fin()] == [ActuatorFault.SLOW]
    bench.servos[0].rate = deg(40.0)
    bench.told = lambda t: math.copysign(deg(15.0), math.sin(t))
    bench.run(10.0)
    assert [fault for _, fault in bench.fin()] == [ActuatorFault.SLOW, NONE]


def to_and_fro(t: float) -> float:
    """What a law asks that overshoots: far to one side and to the other."""
    return math.copysign(deg(15.0), math.sin(math.tau * t / 30.0))


@pytest.mark.parametrize("rate", [1.5, 2.0, 3.0])
def test_a_servo_too_slow_to_steer_with_is_named_in_a_second_and_recovers_when_it_is_quick_again(rate: float) -> None:
    bench = Bench(told=to_and_fro)
    bench.run(5.0)
    bench.servos[0].rate = deg(rate)
    bench.run(60.0)
    assert bench.health.fins[0] is ActuatorFault.LAGGING
    assert min(t for t, fault in bench.fin() if fault is ActuatorFault.LAGGING) - 15.0 <= 1.1  # when it is told to turn
    bench.servos[0].rate = deg(40.0)
    bench.run(20.0)
    assert bench.health.fins[0] is NONE


@pytest.mark.parametrize("period", [12.0, 20.0, 25.0])
def test_a_servo_too_slow_to_steer_with_is_so_too_where_it_keeps_pace_for_a_while(period: float) -> None:
    """A command that moves as slowly as the fin looks like play; one that it crosses leaves it within the band."""
    bench = Bench(told=lambda t: deg(15.0) * math.sin(math.tau * t / period))
    bench.run(5.0)
    bench.servos[0].rate = deg(2.0)
    bench.run(120.0)
    assert bench.health.fins[0] is ActuatorFault.LAGGING


@pytest.mark.parametrize("rate", [4.5, 8.0, 16.0])
def test_a_servo_that_is_slow_but_quick_enough_is_never_too_slow_to_steer_with(rate: float) -> None:
    bench = Bench(told=to_and_fro)
    bench.run(5.0)
    bench.servos[0].rate = deg(rate)
    bench.run(120.0)
    assert {fault for _, fault in bench.fin()} <= {ActuatorFault.SLOW, NONE}


def test_play_is_never_taken_for_a_servo_too_slow_to_steer_with() -> None:
    bench = Bench(told=to_and_fro)
    bench.run(5.0)
    bench.servos[0].play = deg(5.0)
    bench.run(120.0)
    assert ActuatorFault.LAGGING not in {fault for _, fault in bench.fin()}


@pytest.mark.parametrize("period", [0.6, 1.5, 4.0, 8.0])
def test_a_sound_servo_under_commands_from_stop_to_stop_is_sound(period: float) -> None:
    bench = Bench(told=lambda t: math.copysign(deg(23.0), math.sin(math.tau * t / period)))
    assert bench.run(60.0).faultless
    assert not bench.named


@pytest.mark.parametrize("rate", [0.2, 0.4, 0.6, 0.8, 1.0, 1.2])
def test_a_servo_that_creeps_is_not_named_again_and_again(rate: float) -> None:
    """Between standing and coming there is a rate at which reports say now the one and now the other."""
    bench = Bench(told=to_and_fro)
    bench.run(5.0)
    bench.servos[0].rate = deg(rate)
    bench.run(120.0)
    assert len(bench.fin()) <= 4


def test_play_before_the_sensor_is_named_loose() -> None:
    bench = Bench(told=lambda t: 1.5 * sweep(t))
    bench.run(4.0)
    bench.servos[3].play = deg(5.0)
    bench.run(40.0)
    assert bench.health.fins[3] is ActuatorFault.LOOSE
    assert bench.health.fins[:3] == (NONE,) * 3


@pytest.mark.parametrize("who", [0, PROPELLER])
def test_silence_is_named_in_its_time_and_ends_with_a_report(who: int) -> None:
    bench = Bench()
    bench.heard = lambda i, t: i != who or not 5.0 <= t < 9.0
    bench.run(12.0)
    (t, fault), (again, good) = bench.fin(who)
    assert (fault, good) == (SILENT, NONE)
    assert 1.0 < t - 4.98 <= 1.1
    assert again - 9.0 <= 0.1
    others = [i for i in range(FINS + 1) if i != who]
    assert not any(bench.fin(i) for i in others)


def test_actuators_that_never_report_are_not_silent() -> None:
    bench = Bench(heard=lambda _i, _t: False)
    assert bench.run(20.0).faultless


def test_a_servo_that_reports_no_numbers_any_more_is_silent() -> None:
    bench = Bench()
    bench.run(5.0)
    bench.servos[0].fin = bench.servos[0].angle = math.nan
    bench.run(2.0)
    assert bench.health.fins[0] is SILENT


def test_a_jammed_fin_that_falls_silent_is_still_jammed() -> None:
    bench = Bench(told=still)
    bench.run(2.0)
    bench.servos[0].goes_to = deg(10.0)
    bench.run(2.0)
    bench.heard = lambda i, _t: i != 0
    bench.run(5.0)
    assert [fault for _, fault in bench.fin()] == [JAMMED]


@pytest.mark.parametrize("left", [0.5, 0.0])
def test_what_an_axis_lacks_is_laid_to_the_fin_that_reports_nothing(left: float) -> None:
    """A plane jammed without a report; its sound fellow, which reported and obeyed, was called weak as well."""
    bench = Bench()
    bench.run(2.0)
    memory = bench.watch.freeze()
    share = memory.hull.left[0]._replace(left=SHARES.index(left))
    bench.watch.thaw(memory._replace(hull=memory.hull._replace(left=(share, *memory.hull.left[1:]))))
    bench.heard = lambda i, _t: i != 0
    fault, *others = bench.run(2.0).fins
    assert fault is (ActuatorFault.WEAK if left else JAMMED)
    assert others == [NONE] * 3
    assert [health.effect for health in bench.health.left] == [left, left, 1.0, 1.0]  # nobody knows of which of them


def test_a_fin_that_comes_free_is_good_again_and_one_whose_command_comes_by_is_not() -> None:
    bench = Bench()
    bench.run(2.0)
    bench.servos[0].goes_to = deg(10.0)
    bench.run(5.0)
    assert bench.health.fins[0] is JAMMED
    bench.told = lambda _t: deg(10.0)  # the command is where the fin is jammed
    assert bench.run(20.0).fins[0] is JAMMED
    bench.servos[0].goes_to = None
    bench.told = sweep
    assert bench.run(10.0).faultless


def test_a_propeller_that_stands_still_is_jammed() -> None:
    bench = Bench()
    bench.run(5.0)
    bench.shaft.goes_to = 0.0
    bench.run(3.0)
    ((t, fault),) = bench.fin(PROPELLER)
    assert fault is JAMMED
    assert t - 5.0 <= 1.0


def test_a_propeller_that_falls_short_of_its_command_is_weak() -> None:
    bench = Bench(n_told=lambda t: 5.0 if t < 10.0 else 14.0)
    bench.run(9.0)
    bench.shaft.goes_to = 8.0
    bench.run(10.0)
    assert bench.fin(PROPELLER)[-1][1] is ActuatorFault.WEAK


def dithering(seed: int):
    """Commands that change as fast as the gate permits, at random: 60 deg/s, and 500 rpm/s."""
    random = np.random.default_rng(seed)
    targets = random.uniform(-deg(23.0), deg(23.0), 4000)
    angle = [0.0]

    def told(t: float) -> float:
        target = targets[int(t * 2.0)]
        angle[0] += min(max(target - angle[0], -deg(0.6)), deg(0.6))
        return angle[0]

    return told


@pytest.mark.parametrize("seed", [1000, 1001, 1002])
def test_sound_actuators_are_never_named_under_the_fastest_commands(seed: int) -> None:
    bench = Bench(told=dithering(seed), n_told=lambda t: 15.0 if t % 20.0 < 10.0 else -15.0)
    bench.n_told = _limited(bench.n_told)
    assert bench.run(60.0) == sound(FINS)
    assert bench.named == []


def _limited(wanted):
    n = [0.0]

    def told(t: float) -> float:
        n[0] += min(max(wanted(t) - n[0], -500.0 / 60.0 * 0.01), 500.0 / 60.0 * 0.01)
        return n[0]

    return told


def test_lost_and_repeated_reports_are_no_fault() -> None:
    random = np.random.default_rng(1000)
    bench = Bench(told=dithering(7), heard=lambda _i, _t: random.random() > 0.3)
    bench.run(60.0)
    assert bench.named == []


def test_arming_while_a_fin_hangs_down_is_no_fault() -> None:
    """Servos without power until the vehicle is armed."""
    bench = Bench(armed=False, servos=[Servo(angle=deg(15.0), goes_to=deg(15.0)) for _ in range(FINS)])
    bench.run(10.0)
    bench.armed = True
    for servo in bench.servos:
        servo.goes_to = None
    bench.run(10.0)
    assert bench.named == []


def test_a_fin_jammed_before_arming_is_named_soon_after_it() -> None:
    bench = Bench(armed=False, told=still)
    bench.servos[0].goes_to = deg(10.0)
    assert bench.run(10.0).faultless
    bench.armed = True
    bench.run(2.0)
    assert [fault for _, fault in bench.fin()] == [JAMMED]


def test_a_watch_goes_on_from_the_memory_of_another() -> None:
    bench = Bench()
    bench.run(5.0)
    bench.servos[0].goes_to = deg(10.0)
    bench.run(0.3)
    twin = copy.deepcopy(bench)
    twin.watch = Bench().watch
    twin.watch.thaw(bench.watch.freeze())
    assert bench.run(3.0) == twin.run(3.0)
    assert bench.named == twin.named != []
    assert bench.watch.freeze() == twin.watch.freeze()


class Deaf(Servo):
    """A servo that hears one command of eight, by chance, once the bus loses half of all frames."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        self.random, self.lossy, self.last = np.random.default_rng(seed), False, 0.0

    def step(self, told: float, dt: float) -> float:
        if not self.lossy or self.random.random() < 0.125 * dt / 0.02:
            self.last = told
        return super().step(self.last, dt)


@pytest.mark.parametrize("seed", range(4))
def test_fins_that_hear_few_commands_on_a_bus_that_loses_half_of_all_reports_are_not_at_fault(seed: int) -> None:
    random = np.random.default_rng(seed)
    bench = Bench(told=lambda t: deg(8.0) * math.sin(1.5 * t), heard=lambda _i, t: round(t / 0.01) % 5 == 0)
    bench.servos = [Deaf(10 * seed + i) for i in range(FINS)]
    bench.run(5.0)
    for servo in bench.servos:
        servo.lossy = True
    bench.heard = lambda _i, t: bool(round(t / 0.01) % 5 == 0 and random.random() < 0.5)
    bench.run(60.0)
    assert {fault for i in range(FINS) for _, fault in bench.fin(i)} <= {SILENT, NONE}
    for servo in bench.servos:
        servo.lossy = False
    bench.heard = lambda _i, _t: True
    bench.run(10.0)
    bench.servos[0].goes_to = deg(-20.0)
    bench.run(3.0)
    assert bench.fin()[-1][1] is JAMMED
