"""The fins are judged by what held in flight, where vehicle.toml is wrong."""

from __future__ import annotations

import copy
import dataclasses
import math
import tomllib

import numpy as np
import pytest

from firmware_py.control.adoption import Adoption
from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.marine import Eta, Nu
from firmware_py.params import load
from firmware_py.records.adoption import Adopted
from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import ALL_GOOD, ActuatorFault, SourceFault, SourceHealth, SourceState
from firmware_py.records.sensing import Ahrs, Dvl, Heard, silence
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.hull_reference import HullReference
from firmware_py.safety.actuators.hull_watch import HullWatch
from firmware_py.safety.actuators.water_speed import WaterSpeed
from firmware_py.tick import Tick
from firmware_py.vehicle.linear_models import diving_coefficients, steering_coefficients
from firmware_py.vehicle.turning import yaw_axis
from firmware_py.vehicle.vehicle import Vehicle
from tests.unit.firmware_py.safety.actuator_bench import CONFIG, DT_NS, VEHICLE

SPEED = 1.8288
U = 0.7 * SPEED
"""To which fins are held where no DVL is heard, m/s."""
STILL = WaterSpeed(SPEED, 0.0, 0.0, 1e-4, 0.0, 0.0, 2.5e-3, 0.0, 2.5e-3)
GYRO_STD = 8.7e-4
PING = 20
"""Ticks from one ping to the next."""
NONE, WEAK, LOST = ActuatorFault.NONE, ActuatorFault.WEAK, ActuatorFault.LOST
UPPER = 2
SILENT = silence(4)
GONE = SourceHealth(SourceState.LOST, SourceFault.SILENT)
DRIFTS = SourceHealth(SourceState.SUSPECT, SourceFault.DRIFT)


def load_vehicle(name: str) -> Vehicle:
    return load(Vehicle, tomllib.loads((CONFIG.parent / name / "vehicle.toml").read_text()), "vehicle.toml")


_REMUS = load_vehicle("remus100")
SMALL = dataclasses.replace(
    _REMUS, coefficients=dataclasses.replace(_REMUS.coefficients, N_r=2.5 * _REMUS.coefficients.N_r)
)
"""A hull of 1.3 m that stops turning as soon as one of 1.1 m does that was measured."""
FILE = Adoption(AdoptionParams(), ((0.1, 0.2), (0.3, 0.4)), (), VEHICLE).last


def knowing(share: float, vehicle: Vehicle = VEHICLE) -> Adopted:
    """What adoption says where rudders that do this share of what vehicle.toml says have held."""
    file = steering_coefficients(vehicle)
    held = tuple(file._replace(Y_dr=share * file.Y_dr, N_dr=share * file.N_dr))
    return dataclasses.replace(FILE, held_diving=tuple(diving_coefficients(vehicle)), held_steering=held)


class Yawing:
    """A hull that yaws under rudders that a pilot moves; `effect` is the share of what vehicle.toml says of them.

    It makes the speed `u`, and hears a DVL if that is `SPEED` and not `deaf`; gyros that are `late` tell of the tick
    before; while it is `lost` the AHRS is called so, while it is `doubted` the DVL; the pilot moves the rudder to and
    fro in `period`, s; the propeller makes `n`, rev/s, and is silent while it is `raceless`; `step` is what is added to
    the current across the hull, m/s. The upper rudder reports nothing if it is `mute`, and is at `stays`, rad, if that
    is a number; the lower one is at `against`, rad, and says so. Something else turns the hull by `push`, rad/s^2.
    `changed` is when the watch told of a change.
    """

    deaf, late, lost, doubted, mute, period, n = False, False, False, False, False, 9.0, 500.0 / 60.0
    stays, against, push, raceless = math.nan, math.nan, 0.0, False

    def __init__(self, effect: float, adopted: Adopted | None, u: float = U, vehicle: Vehicle = VEHICLE) -> None:
        self.u, self.current = u, 0.0
        self.watch, self.effect, self.adopted = HullWatch(ActuatorParams(), vehicle), effect, adopted
        self.axis, self.random = yaw_axis(vehicle), np.random.default_rng(1000)
        self.v = self.r = self.psi = 0.0
        self.k, self.changed = 0, list[float]()

    def run(self, seconds: float) -> ActuatorFault:
        damping, cross, dt = self.axis.damping, self.axis.crosswise, DT_NS * 1e-9
        for _ in range(round(seconds / dt)):
            t = self.k * dt
            rudder = self.rudder(t)
            lower = rudder if math.isnan(self.against) else self.against
            acts = self.effect * 0.5 * (lower + (rudder if math.isnan(self.stays) else self.stays))
            a, b, c = self.axis.sway
            u, water = self.u, ()
            before = self.r
            self.v += dt * u * (a * self.v + b * self.r + u * c * acts)
            self.r += dt * (u * damping * self.r + u * cross * self.v + u * u * self.axis.control * acts + self.push)
            rate = before if self.late else self.r
            gyro = Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, rate + GYRO_STD * self.random.standard_normal())
            upper = Heard(0.0, -math.inf, False, False) if self.mute else Heard(rudder, t, True, True)
            angles = (*[Heard(0.0, t, True, True)] * 2, upper, Heard(lower, t, True, True))
            heard: dict[str, Heard] = {"ahrs": Heard(gyro, t, True, True)}
            over_ground = self.v + self.current
            if u == SPEED and not self.deaf:
                noise = 0.01 * self.random.standard_normal()
                ping = Heard(Dvl(u, over_ground + noise, 0.0, 0.02, 30.0), t, self.k % PING == 0, True)
                heard["dvl"], water = ping, (STILL,)
            frame = dataclasses.replace(SILENT, fins=angles, **heard)
            nu, eta = Nu(SPEED, over_ground, 0.0, 0.0, 0.0, self.r), Eta(0.0, 0.0, 10.0, 0.0, 0.0, 0.0)
            state = StateEstimate(eta, nu, 0.0, 0.0, 0.0, 30.0, True, True, True, False)
            if self.lost:
                state = dataclasses.replace(state, sensors=ALL_GOOD._replace(ahrs=GONE))
            if self.doubted:
                state = dataclasses.replace(state, sensors=ALL_GOOD._replace(dvl=DRIFTS))
            applied = Applied((0.0, 0.0, rudder, rudder), self.n, True, False)
            propeller = ActuatorFault.SILENT if self.raceless else NONE
            if self.watch.update(Tick(self.k, DT_NS), frame, applied, state, water, self.adopted, propeller):
                self.changed.append(t)
            self.k += 1
        return self.watch.fault(UPPER)

    def rudder(self, t: float) -> float:
        """Return where the pilot has the rudder, rad."""
        return 0.15 * math.copysign(1.0, math.sin(2.0 * math.pi * t / self.period))

    def step(self, current: float) -> None:
        """Let the current across the hull be so much more, m/s; the hull goes on over the ground."""
        self.current += current
        self.v -= current


def test_rudders_that_do_what_held_are_sound_however_wrong_the_file_is() -> None:
    assert Yawing(0.2, None).run(120.0) is not NONE  # by vehicle.toml
    assert Yawing(0.2, knowing(0.2)).run(300.0) is NONE


def test_filters_follow_what_eddies_do_by_what_held_and_so_they_do_when_a_flight_is_entered_in_its_middle() -> None:
    file = dataclasses.replace(VEHICLE.coefficients, N_v=0.5 * VEHICLE.coefficients.N_v)
    believed = dataclasses.replace(VEHICLE, coefficients=file)
    reference, true = HullReference(believed, 0.1), HullReference(VEHICLE, 0.1)
    assert reference.eddies[1] < 0.6 * true.eddies[1]
    held = knowing(1.0).held_steering
    assert reference.refer(1, held)
    assert reference.eddies[1] == pytest.approx(true.eddies[1], rel=0.1)
    slightly = steering_coefficients(VEHICLE)._replace(N_v=1.02 * VEHICLE.coefficients.N_v)
    assert not reference.refer(1, tuple(slightly))  # filters are not designed anew for so little
    assert not reference.refer(0, knowing(1.0).held_diving)
    assert reference.refer(1, ())
    hull = Yawing(1.0, knowing(1.0), SPEED)
    hull.watch = HullWatch(ActuatorParams(), believed)
    hull.run(5.0)
    twin = copy.deepcopy(hull)
    twin.watch = HullWatch(ActuatorParams(), believed)
    twin.watch.thaw(hull.watch.freeze())
    hull.run(5.0)
    twin.run(5.0)
    assert twin.watch.freeze() == hull.watch.freeze()


def test_an_ahrs_that_was_away_in_flight_is_no_witness_against_fins_for_two_minutes() -> None:
    hull = Yawing(1.0, None)
    hull.lost = True
    hull.run(0.5)
    hull.lost, hull.effect = False, 0.0  # or it is late, and they do not what it tells of
    assert hull.run(119.0) is NONE
    assert hull.run(30.0) is LOST


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


def test_what_adoption_found_halved_is_weak_and_held_to_what_fins_did_before() -> None:
    half = dataclasses.replace(knowing(1.0), halved=(False, True))
    for effect, left, fault in ((0.5, 0.5, WEAK), (1.0, 1.0, NONE), (0.0, 0.0, LOST)):
        hull = Yawing(0.5, knowing(0.5), SPEED)
        assert hull.run(30.0) is NONE
        hull.adopted = half
        assert hull.run(0.1) is WEAK
        assert hull.watch.left(UPPER) == 0.5
        hull.adopted, hull.effect = knowing(0.5), effect
        assert hull.run(60.0) is fault
        assert hull.watch.left(UPPER) == left


@pytest.mark.parametrize("liar", ["lost", "doubted", "raceless"])
def test_what_an_ahrs_or_a_dvl_taught_that_is_not_believed_is_no_fault_of_the_fins(liar: str) -> None:
    """A late AHRS, a DVL that drifted, a propeller that stood unheard: what was learned said that rudders did half."""
    half = dataclasses.replace(knowing(1.0), halved=(False, True))
    hull = Yawing(1.0, knowing(1.0), SPEED)
    assert hull.run(30.0) is NONE
    hull.adopted = half
    setattr(hull, liar, True)
    assert hull.run(10.0) is NONE
    setattr(hull, liar, False)
    assert hull.run(10.0) is (NONE if liar == "lost" else WEAK)  # an AHRS that was away may be late


def test_an_axis_is_judged_by_what_held_as_soon_as_that_is_proven_whatever_is_known_of_the_other_one() -> None:
    """A rudder lost 10 s after its law was adopted was never named, for planes were not known yet."""
    cautious = dataclasses.replace(knowing(0.6), caution=1.0)
    proven = dataclasses.replace(cautious, proven=(False, True))
    for adopted, named in ((cautious, NONE), (proven, WEAK)):
        hull = Yawing(0.6, adopted)
        assert hull.run(30.0) is NONE
        hull.effect = 0.3
        assert hull.run(5.0) is named


class Swinging(Yawing):
    """A small hull whose rudders swing by `swing`, rad, as a law makes them for which servos are too slow."""

    late, n, swing = True, SPEED * SMALL.propeller.n_trim / SMALL.propeller.u_trim, math.radians(1.0)

    def __init__(self, period: float) -> None:
        super().__init__(1.0, knowing(1.0, SMALL), SPEED, SMALL)
        self.period = period

    def rudder(self, t: float) -> float:
        return self.swing * math.sin(2.0 * math.pi * t / self.period)


@pytest.mark.parametrize("period", [0.4, 0.5, 0.6])
def test_rudders_that_swing_fast_are_sound_and_half_of_them_is_found_in_seconds(period: float) -> None:
    """They were called weak: an angle counted 40 ms too soon."""
    hull = Swinging(period)
    assert hull.run(60.0) is NONE
    hull.effect = 0.5
    assert hull.run(3.0) is WEAK


@pytest.mark.parametrize("angle", [-0.25, 0.25])
def test_a_rudder_that_stays_and_does_not_report_it_is_told_of_as_soon_as_it_is_found(angle: float) -> None:
    hull = Yawing(1.0, knowing(1.0))
    hull.mute = True
    hull.run(30.0)
    assert hull.changed == []
    assert math.isnan(hull.watch.stuck(UPPER))
    hull.stays = angle
    hull.run(15.0)
    assert hull.changed
    assert hull.changed[0] < 45.0
    assert hull.watch.stuck(UPPER) == pytest.approx(angle, abs=0.07)


def test_a_fin_of_an_x_tail_counts_a_whole_step_later_in_pitch_and_in_yaw() -> None:
    """The watch of one axis took the angle that the other one had found half a step before."""
    params, told = ActuatorParams(), Applied((0.0,) * 4, 10.0, True, False)
    watch = HullWatch(params, load_vehicle("torpedo_x"))
    state = StateEstimate(
        Eta(0.0, 0.0, 10.0, 0.0, 0.0, 0.0), Nu(*[0.0] * 6), 0.0, 0.0, 0.0, 30.0, True, True, True, False
    )
    for k in range(9):
        fins = tuple([Heard(0.01 * k, k * DT_NS * 1e-9, True, True)] * 4)
        watch.update(Tick(k, DT_NS), dataclasses.replace(silence(4), fins=fins), told, state, ())
    assert [last for _, last in watch.freeze().angles] == [(0.08,) * 4, (0.06,) * 4]  # of ticks 8 and 6


def test_what_they_make_of_the_hull_is_known_but_for_the_noise_of_the_gyros() -> None:
    """Damping takes 13 % of a moment within a step."""
    hull = Swinging(0.6)
    hull.swing = math.radians(3.0)
    assert hull.run(20.0) is NONE
    assert hull.watch.freeze().left[1].variance < 1.5 * GYRO_STD**2 / 4.0  # the mean of four


def test_rudders_are_not_judged_in_the_race_of_a_propeller_that_goes_astern() -> None:
    """Reverse takes the way off sooner than a modelled speed may follow: sound rudders were called lost."""
    hull = Yawing(1.0, knowing(1.0), SPEED)
    assert hull.run(60.0) is NONE
    hull.effect, hull.n = 0.0, -700.0 / 60.0
    assert hull.run(8.0) is NONE


@pytest.mark.parametrize("share", [0.5, 0.55])
def test_nor_while_it_is_slowed_to_half_of_what_the_hull_still_makes(share: float) -> None:
    """The speed that it makes in the end fell and rose again while the hull's did not: sound fins were called weak."""
    hull, slow = Yawing(1.0, knowing(1.0), SPEED), 5.0
    hull.period = 3.0
    assert hull.run(60.0) is NONE
    cruise, begun = hull.n, hull.k * DT_NS * 1e-9
    hull.rudder = lambda t: 0.3 * min(1.0, 0.3 + 0.7 * (t - begun) / slow)  # type: ignore[method-assign]
    for k in range(100):
        hull.n = cruise * (1.0 - (1.0 - share) * min(k, 100 - k) / 50.0)
        if k == 50:
            hull.rudder = lambda _t: 0.3 * min(1.0, 1.3 - hull.n / cruise)  # type: ignore[method-assign]
        assert hull.run(0.1) is NONE


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_rudders_that_cancel_each_other_hold_against_nothing(side: float) -> None:
    """One was jammed hard over, the other held against it, and was called lost when the vehicle turned in a current."""
    hull = Yawing(1.0, knowing(1.0), SPEED)
    hull.push, hull.current = side * 0.002, side * 0.2
    assert hull.run(60.0) is NONE
    hull.against = 0.4 + side * 0.0005
    hull.rudder = lambda _t: -0.4  # type: ignore[method-assign]
    assert hull.run(60.0) is NONE


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
