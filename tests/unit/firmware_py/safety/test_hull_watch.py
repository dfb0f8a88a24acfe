"""The fins are judged by what held in flight, where vehicle.toml is wrong."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from firmware_py.control.adoption import Adoption
from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.marine import Eta, Nu
from firmware_py.records.adoption import Adopted
from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import ActuatorFault
from firmware_py.records.sensing import Ahrs, Dvl, Heard, silence
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.hull_watch import HullWatch
from firmware_py.safety.actuators.water_speed import WaterSpeed
from firmware_py.tick import Tick
from firmware_py.vehicle.linear_models import diving_coefficients, steering_coefficients
from firmware_py.vehicle.turning import yaw_axis
from tests.unit.firmware_py.safety.actuator_bench import DT_NS, VEHICLE

SPEED = 1.8288
U = 0.7 * SPEED
"""To which fins are held where no DVL is heard, m/s."""
STILL = WaterSpeed(SPEED, 0.0, 0.0, 1e-4, 0.0, 0.0, 2.5e-3, 0.0, 2.5e-3)
PING = 20
"""Ticks from one ping to the next."""
NONE, WEAK, LOST = ActuatorFault.NONE, ActuatorFault.WEAK, ActuatorFault.LOST
UPPER = 2
FILE = Adoption(AdoptionParams(), ((0.1, 0.2), (0.3, 0.4)), (), VEHICLE).last


def knowing(share: float) -> Adopted:
    """What adoption says where rudders that do this share of what vehicle.toml says have held."""
    file = steering_coefficients(VEHICLE)
    held = tuple(file._replace(Y_dr=share * file.Y_dr, N_dr=share * file.N_dr))
    return dataclasses.replace(FILE, held_diving=tuple(diving_coefficients(VEHICLE)), held_steering=held)


class Yawing:
    """A hull that yaws under rudders that a pilot moves; `effect` is the share of what vehicle.toml says of them.

    It makes the speed `u`, and hears a DVL if that is `SPEED` and not `deaf`; the pilot moves the rudder to and fro in
    `period`, s; the propeller makes `n`, rev/s; `step` is what is added to the current across the hull, m/s.
    """

    deaf, period, n = False, 9.0, 500.0 / 60.0

    def __init__(self, effect: float, adopted: Adopted | None, u: float = U) -> None:
        self.u, self.current = u, 0.0
        self.watch, self.effect, self.adopted = HullWatch(ActuatorParams(), VEHICLE), effect, adopted
        self.axis, self.random = yaw_axis(VEHICLE), np.random.default_rng(1000)
        self.v = self.r = self.psi = 0.0
        self.k = 0

    def run(self, seconds: float) -> ActuatorFault:
        damping, cross, dt = self.axis.damping, self.axis.crosswise, DT_NS * 1e-9
        for _ in range(round(seconds / dt)):
            t = self.k * dt
            rudder = 0.15 * math.copysign(1.0, math.sin(2.0 * math.pi * t / self.period))
            acts = self.effect * rudder
            a, b, c = self.axis.sway
            u, water = self.u, ()
            self.v += dt * u * (a * self.v + b * self.r + u * c * acts)
            self.r += dt * (u * damping * self.r + u * cross * self.v + u * u * self.axis.control * acts)
            gyro = Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, self.r + 8.7e-4 * self.random.standard_normal())
            angles = tuple(Heard(angle, t, True, True) for angle in (0.0, 0.0, rudder, rudder))
            frame = dataclasses.replace(silence(4), ahrs=Heard(gyro, t, True, True), fins=angles)
            over_ground = self.v + self.current
            if u == SPEED and not self.deaf:
                noise = 0.01 * self.random.standard_normal()
                ping = Heard(Dvl(u, over_ground + noise, 0.0, 0.02, 30.0), t, self.k % PING == 0, True)
                frame, water = dataclasses.replace(frame, dvl=ping), (STILL,)
            nu, eta = Nu(SPEED, over_ground, 0.0, 0.0, 0.0, self.r), Eta(0.0, 0.0, 10.0, 0.0, 0.0, 0.0)
            state = StateEstimate(eta, nu, 0.0, 0.0, 0.0, 30.0, True, True, True, False)
            applied = Applied((0.0, 0.0, rudder, rudder), self.n, True, False)
            self.watch.update(Tick(self.k, DT_NS), frame, applied, state, water, self.adopted)
            self.k += 1
        return self.watch.fault(UPPER)

    def step(self, current: float) -> None:
        """Let the current across the hull be so much more, m/s; the hull goes on over the ground."""
        self.current += current
        self.v -= current


def test_rudders_that_do_what_held_are_sound_however_wrong_the_file_is() -> None:
    assert Yawing(0.2, None).run(120.0) is not NONE  # by vehicle.toml
    assert Yawing(0.2, knowing(0.2)).run(300.0) is NONE


def test_nothing_is_named_while_the_motion_refutes_the_file_and_nothing_has_held() -> None:
    refuted = dataclasses.replace(FILE, refuted=(False, True))
    assert Yawing(0.2, refuted).run(120.0) is NONE


def test_but_rudders_that_do_nothing_by_what_is_learned_are_lost() -> None:
    *rest, moment = FILE.steering
    nothing = dataclasses.replace(FILE, refuted=(False, True), steering=(*rest, 0.2 * moment))
    assert Yawing(0.0, nothing).run(1.0) is LOST
    half = dataclasses.replace(nothing, steering=(*rest, 0.24 * moment))  # of what a file makes 1.5 times too much of
    assert Yawing(0.33, half).run(60.0) is NONE


@pytest.mark.parametrize("share", [0.4, 1.0, 1.6])
def test_half_of_what_held_is_found_in_seconds_and_what_held_stays_the_measure(share: float) -> None:
    hull = Yawing(share, knowing(share))
    assert hull.run(60.0) is NONE
    hull.effect = 0.5 * share
    assert hull.run(5.0) is WEAK
    assert hull.watch.left(UPPER) == 0.5
    hull.adopted = knowing(0.5 * share)  # what is lost becomes what holds
    assert hull.run(60.0) is WEAK
    hull.effect = 0.0
    assert hull.run(10.0) is LOST


def test_an_axis_is_judged_by_what_held_as_soon_as_that_is_proven_whatever_is_known_of_the_other_one() -> None:
    """A rudder lost 10 s after its law was adopted was never named, for planes were not known yet."""
    cautious = dataclasses.replace(knowing(0.6), caution=1.0)
    proven = dataclasses.replace(cautious, proven=(False, True))
    for adopted, named in ((cautious, NONE), (proven, WEAK)):
        hull = Yawing(0.6, adopted)
        assert hull.run(30.0) is NONE
        hull.effect = 0.3
        assert hull.run(5.0) is named


def test_rudders_are_not_judged_in_the_race_of_a_propeller_that_goes_astern() -> None:
    """Reverse takes the way off sooner than a modelled speed may follow: sound rudders were called lost."""
    hull = Yawing(1.0, knowing(1.0), SPEED)
    assert hull.run(60.0) is NONE
    hull.effect, hull.n = 0.0, -700.0 / 60.0
    assert hull.run(8.0) is NONE


def test_memory_holds_what_fins_are_judged_by() -> None:
    hull = Yawing(0.5, knowing(0.5))
    hull.run(30.0)
    other = Yawing(0.5, knowing(0.5))
    other.watch.thaw(hull.watch.freeze())
    assert other.watch.freeze() == hull.watch.freeze()
    other.v, other.r, other.k, other.random = hull.v, hull.r, hull.k, np.random.default_rng(5)
    hull.random = np.random.default_rng(5)
    hull.run(5.0)
    other.run(5.0)
    assert other.watch.freeze() == hull.watch.freeze()


@pytest.mark.parametrize("begun", [0.3, 1.5, 3.0])
@pytest.mark.parametrize("step", [0.5, -0.5, 0.3])
def test_a_current_that_steps_across_the_hull_is_no_damage(step: float, begun: float) -> None:
    hull = Yawing(1.0, knowing(1.0), SPEED)
    hull.period = 20.0
    assert hull.run(60.0 + begun) is NONE
    hull.step(step)
    for _ in range(20):
        assert hull.run(1.0) is NONE
    hull.effect = 0.5
    assert hull.run(13.0) is WEAK


def test_fins_do_not_heal_while_nothing_tells_how_fast_they_are_but_do_when_they_are_whole_again() -> None:
    hull = Yawing(1.0, knowing(1.0), SPEED)
    assert hull.run(60.0) is NONE
    hull.effect = 0.5
    assert hull.run(6.0) is WEAK
    hull.deaf = True  # they seem to do twice as much, being held to the least speed that the vehicle may have
    for _ in range(30):
        assert hull.run(1.0) is WEAK
        assert hull.watch.left(UPPER) == 0.5
    hull.deaf = False
    assert hull.run(20.0) is WEAK
    hull.effect = 1.0
    assert hull.run(9.0) is WEAK
    assert hull.run(51.0) is NONE
