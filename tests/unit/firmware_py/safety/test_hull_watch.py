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
from firmware_py.records.sensing import Ahrs, Heard, silence
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.hull_watch import HullWatch
from firmware_py.tick import Tick
from firmware_py.vehicle.linear_models import diving_coefficients, steering_coefficients
from firmware_py.vehicle.turning import yaw_axis
from tests.unit.firmware_py.safety.actuator_bench import DT_NS, VEHICLE

U = 0.7 * 1.8288
"""To which fins are held where no DVL is heard, m/s."""
NONE, WEAK, LOST = ActuatorFault.NONE, ActuatorFault.WEAK, ActuatorFault.LOST
UPPER = 2
FILE = Adoption(AdoptionParams(), ((0.1, 0.2), (0.3, 0.4)), (), VEHICLE).last


def knowing(share: float) -> Adopted:
    """What adoption says where rudders that do this share of what vehicle.toml says have held."""
    file = steering_coefficients(VEHICLE)
    held = tuple(file._replace(Y_dr=share * file.Y_dr, N_dr=share * file.N_dr))
    return dataclasses.replace(FILE, held_diving=tuple(diving_coefficients(VEHICLE)), held_steering=held)


class Yawing:
    """A hull that yaws under rudders that a pilot moves; `effect` is the share of what vehicle.toml says of them."""

    def __init__(self, effect: float, adopted: Adopted | None) -> None:
        self.watch, self.effect, self.adopted = HullWatch(ActuatorParams(), VEHICLE), effect, adopted
        self.axis, self.random = yaw_axis(VEHICLE), np.random.default_rng(1000)
        self.v = self.r = self.psi = 0.0
        self.k = 0

    def run(self, seconds: float) -> ActuatorFault:
        damping, cross, dt = self.axis.damping, self.axis.crosswise, DT_NS * 1e-9
        for _ in range(round(seconds / dt)):
            t = self.k * dt
            rudder = 0.15 * math.copysign(1.0, math.sin(0.7 * t))
            acts = self.effect * rudder
            a, b, c = self.axis.sway
            self.v += dt * U * (a * self.v + b * self.r + U * c * acts)
            self.r += dt * (U * damping * self.r + U * cross * self.v + U * U * self.axis.control * acts)
            gyro = Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, self.r + 8.7e-4 * self.random.standard_normal())
            angles = tuple(Heard(angle, t, True, True) for angle in (0.0, 0.0, rudder, rudder))
            frame = dataclasses.replace(silence(4), ahrs=Heard(gyro, t, True, True), fins=angles)
            nu, eta = Nu(1.8288, self.v, 0.0, 0.0, 0.0, self.r), Eta(0.0, 0.0, 10.0, 0.0, 0.0, 0.0)
            state = StateEstimate(eta, nu, 0.0, 0.0, 0.0, 30.0, True, True, True, False)
            applied = Applied((0.0, 0.0, rudder, rudder), 500.0 / 60.0, True, False)
            self.watch.update(Tick(self.k, DT_NS), frame, applied, state, (), self.adopted)
            self.k += 1
        return self.watch.fault(UPPER)


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
