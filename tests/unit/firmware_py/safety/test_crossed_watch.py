"""One fin of an X tail that makes no force: which it is, and that sound ones are never named."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import pytest

from firmware_py.allocation import Allocator
from firmware_py.control.adoption import Adoption
from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.marine import Eta, Nu
from firmware_py.records.adoption import Adopted
from firmware_py.records.command import Applied, Demand
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import NO_DOUBTS, SOUND_FIN, ActuatorFault, AxisDoubt, FinEvidence, FinHealth
from firmware_py.records.sensing import Ahrs, Dvl, Heard, silence
from firmware_py.safety.actuator_watch import ActuatorWatch
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.crossed_watch import CrossedWatch
from firmware_py.safety.actuators.hull_watch import HullWatch
from firmware_py.safety.actuators.water_speed import WaterSpeed
from firmware_py.tick import Tick
from firmware_py.vehicle.turning import heaved_axis, pitch_axis, yaw_axis
from tests.unit.firmware_py.safety.actuator_bench import DT_NS, VEHICLE
from tests.unit.firmware_py.safety.test_hull_watch import load_vehicle

X = load_vehicle("torpedo_x")
SPEED, GYRO_STD, DT = X.propeller.u_trim, 8.7e-4, DT_NS * 1e-9
STILL = WaterSpeed(SPEED, 0.0, 0.0, 1e-4, 0.0, 0.0, 2.5e-3, 0.0, 2.5e-3)
NONE, WEAK, LOST = ActuatorFault.NONE, ActuatorFault.WEAK, ActuatorFault.LOST
SILENT, PING = silence(4), 20
RESTS = FinHealth(1.0, 0.0, FinEvidence.MOTION)
FILE = Adoption(AdoptionParams(), ((0.1, 0.2), (0.3, 0.4)), (), X).last


class Diving:
    """A hull that pitches and yaws under planes and rudders that a pilot moves by `swing`, rad, by its four fins.

    `effect` is the share of its effect that each fin has, `scale` that of what vehicle.toml says of them all. Fins at
    `stuck`, rad, stay there, and say so. The fins in `mute` report nothing. `named` is when which fault of a fin was
    found.
    """

    def __init__(self, seed: int = 1000, eddies: float = 0.0, adopted: Adopted | None = None) -> None:
        self.watch, self.adopted = CrossedWatch(ActuatorParams(), X), adopted
        self.allocator, self.random, self.eddies = Allocator(X), np.random.default_rng(seed), eddies
        self.effect, self.scale, self.swing = [1.0] * 4, 1.0, math.radians(3.0)
        self.mute: Sequence[int] = ()
        self.w = self.v = self.q = self.r = self.theta = 0.0
        self.eddy = [0.0, 0.0]
        self.fins = [0.0] * 4
        self.k, self.named = 0, list[tuple[float, int, ActuatorFault]]()

    def run(self, seconds: float) -> list[ActuatorFault]:
        u, s, r = SPEED, X.effectiveness.s, X.effectiveness.r
        pitch, yaw, (heave, _) = pitch_axis(X), yaw_axis(X), heaved_axis(X)
        for _ in range(round(seconds / DT)):
            t = self.k * DT
            planes = self.swing * math.copysign(1.0, math.sin(math.tau * t / 7.0)) + 0.3 * self.theta
            rudder = self.swing * math.copysign(1.0, math.sin(math.tau * t / 9.0))
            rests = [
                FinHealth(1.0, 0.0, FinEvidence.MOTION) if i in self.watch.resting else SOUND_FIN for i in range(4)
            ]
            told = self.allocator.allocate(Demand(planes, rudder, X.propeller.n_trim, 0.0, 0.0), tuple(rests)).fins
            self.fins = [fin + (angle - fin) * DT / 0.1 for fin, angle in zip(self.fins, told, strict=True)]
            acts = [self.scale * share * fin for share, fin in zip(self.effect, self.fins, strict=True)]
            delta_s, delta_r = np.dot(s, acts), np.dot(r, acts)
            kick = self.eddies * math.sqrt(2.0 * DT / 10.0)
            self.eddy = [e - e * DT / 10.0 + kick * self.random.standard_normal() for e in self.eddy]
            self.w += DT * u * (heave[0] * self.w + heave[1] * self.q + u * heave[2] * delta_s)
            a, b, c = yaw.sway
            self.v += DT * u * (a * self.v + b * self.r + u * c * delta_r)
            self.q += DT * (
                u * (pitch.damping * self.q + pitch.crosswise * (self.w + self.eddy[0]) + u * pitch.control * delta_s)
                + pitch.restoring * math.sin(self.theta)
            )
            self.r += (
                DT * u * (yaw.damping * self.r + yaw.crosswise * (self.v + self.eddy[1]) + u * yaw.control * delta_r)
            )
            self.theta += DT * self.q
            self._tell(t, told)
            self.k += 1
        return [self.watch.fault(i) for i in range(4)]

    def _tell(self, t: float, told: tuple[float, ...]) -> None:
        noise = self.random.standard_normal(4)
        gyro = Ahrs(0.0, self.theta, 0.0, 0.0, self.q + GYRO_STD * noise[0], self.r + GYRO_STD * noise[1])
        fins = tuple([Heard(fin, t, i not in self.mute, i not in self.mute) for i, fin in enumerate(self.fins)])
        if self.mute:
            fins = tuple([Heard(0.0, -math.inf, False, False) if i in self.mute else one for i, one in enumerate(fins)])
        ping = Heard(
            Dvl(SPEED, self.v + 0.01 * noise[2], self.w + 0.01 * noise[3], 0.02, 30.0), t, self.k % PING == 0, True
        )
        frame = dataclasses.replace(SILENT, fins=fins, ahrs=Heard(gyro, t, True, True), dvl=ping)
        nu, eta = Nu(SPEED, self.v, self.w, 0.0, self.q, self.r), Eta(0.0, 0.0, 10.0, 0.0, self.theta, 0.0)
        state = StateEstimate(eta, nu, 0.0, 0.0, 0.0, 30.0, True, True, True, False)
        applied = Applied(told, X.propeller.n_trim, True, False)
        before = [self.watch.fault(i) for i in range(4)]
        self.watch.update(Tick(self.k, DT_NS), frame, applied, state, (STILL,), self.adopted)
        now = [self.watch.fault(i) for i in range(4)]
        self.named += [(t, i, one) for i, (one, was) in enumerate(zip(now, before, strict=True)) if one is not was]


def only(fin: int, fault: ActuatorFault) -> list[ActuatorFault]:
    return [fault if i == fin else NONE for i in range(4)]


@pytest.mark.parametrize(("fin", "eddies", "within"), [(0, 0.0, 15.0), (2, 0.0, 15.0), (1, 0.05, 40.0), (3, 0.1, 60.0)])
def test_the_fin_that_is_lost_is_named_and_no_other_one_and_it_rests(fin: int, eddies: float, within: float) -> None:
    hull = Diving(eddies=eddies)
    assert hull.run(20.0) == [NONE] * 4
    assert hull.watch.doubts == NO_DOUBTS
    hull.effect[fin] = 0.0
    assert hull.run(within) == only(fin, LOST)
    assert [one for _, one, _ in hull.named] == [fin]
    assert hull.watch.resting == (fin,)
    assert hull.watch.left(fin) == 0.0
    assert hull.run(20.0) == only(fin, LOST)  # three sound ones are seen to be so
    assert hull.watch.doubts == (AxisDoubt(idle=(fin,)),) * 2


@pytest.mark.parametrize("fin", [0, 3])
def test_half_of_a_fin_is_weak(fin: int) -> None:
    hull = Diving()
    hull.run(20.0)
    hull.effect[fin] = 0.5
    assert hull.run(40.0) == only(fin, WEAK)
    assert hull.watch.left(fin) == 0.5


def test_a_second_fin_is_named_too() -> None:
    hull = Diving()
    hull.run(20.0)
    hull.effect[1] = 0.0
    hull.run(20.0)
    hull.effect[2] = 0.0
    assert hull.run(30.0) == [NONE, LOST, LOST, NONE]


@pytest.mark.parametrize(("seed", "eddies"), [(1000, 0.0), (1001, 0.05), (1002, 0.1)])
def test_sound_fins_are_not_named_nor_put_to_rest(seed: int, eddies: float) -> None:
    hull = Diving(seed, eddies)
    top = 0.0
    for _ in range(20):
        assert hull.run(3.0) == [NONE] * 4
        top = max(top, hull.watch.freeze().crossed.top)  # type: ignore[union-attr]
    assert hull.watch.resting == ()
    assert top < 12.0  # 16 put one to rest


@pytest.mark.parametrize("scale", [0.7, 1.4])
def test_a_vehicle_file_that_is_wrong_about_all_fins_alike_makes_none_of_them_lost(scale: float) -> None:
    hull = Diving()
    hull.scale = scale
    assert hull.run(40.0) == [NONE] * 4
    hull.effect[2] = 0.0
    assert hull.run(20.0) == only(2, LOST)


def test_by_a_file_that_is_refuted_a_single_fin_is_told_and_no_axis_is() -> None:
    """A lost fin refutes the file itself: all four were named by what was learned from it."""
    learned = dataclasses.replace(FILE, refuted=(True, True), steering=tuple([0.2 * one for one in FILE.steering]))
    hull = Diving(adopted=learned)
    assert hull.run(30.0) == [NONE] * 4
    hull.effect[0] = 0.0
    assert hull.run(15.0) == only(0, LOST)


def test_what_is_learned_of_one_axis_alone_makes_no_crossed_fin_weak() -> None:
    hull = Diving(adopted=dataclasses.replace(FILE, halved=(False, True)))
    assert hull.run(20.0) == [NONE] * 4
    hull = Diving(adopted=dataclasses.replace(FILE, halved=(True, True)))
    assert hull.run(20.0) != [NONE] * 4


def test_all_four_are_named_where_none_of_them_makes_a_force() -> None:
    hull = Diving()
    hull.run(20.0)
    hull.effect = [0.0] * 4
    assert hull.run(30.0) == [LOST] * 4


def test_where_a_fin_reports_nothing_single_ones_are_not_judged() -> None:
    hull = Diving()
    hull.mute = (1,)
    hull.run(20.0)
    hull.effect[0] = 0.0
    hull.run(30.0)
    assert hull.watch.resting == ()


def test_a_flight_that_is_entered_in_its_middle_goes_on_as_it_was() -> None:
    hull = Diving()
    hull.run(20.0)
    hull.effect[3] = 0.0
    hull.run(2.0)
    other = CrossedWatch(ActuatorParams(), X)
    memory = hull.watch.freeze()
    other.thaw(memory)
    assert other.freeze() == memory
    hull.watch = other
    assert hull.run(15.0) == only(3, LOST)
    again = CrossedWatch(ActuatorParams(), X)
    again.thaw(other.freeze())
    assert again.resting == (3,)


def test_only_a_vehicle_whose_fins_are_crossed_pays_for_it() -> None:
    assert type(ActuatorWatch(ActuatorParams(), X, 10.0)._hull) is CrossedWatch
    assert type(ActuatorWatch(ActuatorParams(), VEHICLE, 10.0)._hull) is HullWatch
