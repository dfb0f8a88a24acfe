"""Navigation against voyages whose truth is known: noise, delay, silence, nonsense, and whether its sigma is honest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.estimation.navigation.dead_reckoning import PositionParams
from firmware_py.estimation.navigation.navigation import KeptNavigation, Navigation, NavigationParams
from firmware_py.marine import Origin, local_to_geodetic
from firmware_py.params import dump, load
from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix, Heard, SensorFrame, never, silence
from firmware_py.tick import Tick

DT_NS = 10_000_000
DT = 0.01
ORIGIN = Origin(0.9, 0.2)
ARMED = Applied((0.0,) * 4, 500.0 / 60.0, True, False)
ASHORE = Applied((0.0,) * 4, 0.0, False, False)
DEG = math.pi / 180
G = 9.80665


class Truth(NamedTuple):
    """Columns over time, at every tick."""

    phi: Any
    theta: Any
    psi: Any
    p: Any
    q: Any
    r: Any
    u: Any
    v: Any
    w: Any
    x: Any
    y: Any
    z: Any


class Noise(NamedTuple):
    roll_pitch: float = 0.3 * DEG
    yaw: float = 0.5 * DEG
    gyro: float = 0.05 * DEG
    dvl: float = 0.01
    pressure: float = 50.0


PARAMS = NavigationParams()
NOISY = Noise()
QUIET = Noise(0.0, 0.0, 0.0, 0.0, 0.0)


def swim(t: Any) -> tuple[Any, ...]:
    """A weaving voyage: (phi, theta, psi, u, v, w) over t."""
    psi = 3.0 + 0.25 * np.sin(0.2 * t)  # to both sides of pi
    return (
        0.05 * np.sin(0.7 * t),
        0.15 * np.sin(0.3 * t),
        psi,
        1.8 + 0.1 * np.sin(0.2 * t),
        0.05 * np.cos(t),
        0.02 * t**0,
    )


def truth_of(path: Callable[[Any], tuple[Any, ...]], duration: float, z: float = 5.0) -> Truth:
    """Rates and positions by finite differences and trapezoids, ten times finer than the tick."""
    t = np.arange(round(duration / DT) * 10 + 1) * DT / 10
    phi, theta, psi, u, v, w = (np.broadcast_to(c, t.shape) for c in path(t))
    phi_dot, theta_dot, psi_dot = (np.gradient(angle, t) for angle in (phi, theta, psi))
    s, c = np.sin, np.cos
    p = phi_dot - psi_dot * s(theta)
    q = theta_dot * c(phi) + psi_dot * s(phi) * c(theta)
    r = psi_dot * c(phi) * c(theta) - theta_dot * s(phi)
    one, nil = np.ones_like(t), np.zeros_like(t)
    about_z = np.array([[c(psi), -s(psi), nil], [s(psi), c(psi), nil], [nil, nil, one]])
    about_y = np.array([[c(theta), nil, s(theta)], [nil, one, nil], [-s(theta), nil, c(theta)]])
    about_x = np.array([[one, nil, nil], [nil, c(phi), -s(phi)], [nil, s(phi), c(phi)]])
    rate = np.einsum("ijt,jkt,klt,lt->it", about_z, about_y, about_x, np.array([u, v, w]))
    steps = np.cumsum((rate[:, 1:] + rate[:, :-1]) / 2 * (DT / 10), axis=1)
    place = np.concatenate([np.zeros((3, 1)), steps], axis=1) + np.array([[0.0], [0.0], [z]])
    psi = (psi + np.pi) % (2 * np.pi) - np.pi
    return Truth(*(column[::10] for column in (phi, theta, psi, p, q, r, u, v, w, *place)))


def sail(
    truth: Truth,
    seed: int = 0,
    noise: Noise = NOISY,
    params: NavigationParams = PARAMS,
    change: Callable[[int, SensorFrame], SensorFrame] = lambda k, frame: frame,
    heading_off: float = 0.0,
    scale: float = 1.0,
    bias: tuple[float, float] = (0.0, 0.0),
    applied: Applied = ARMED,
    every: int = 1,
) -> list[StateEstimate]:
    """The estimates of a voyage: AHRS 100 Hz, 10 ms late; DVL 5 Hz, 100 ms late; pressure 20 Hz, 20 ms late."""
    rng = np.random.default_rng(seed)
    count = len(truth.x)
    spread = np.array([noise.roll_pitch] * 2 + [noise.yaw] + [noise.gyro] * 3)
    ahrs = (np.array(truth[:6]).T + rng.normal(size=(count, 6)) * spread + [0, 0, heading_off, 0, 0, 0]).tolist()
    log = np.array(truth[6:9]).T * scale + rng.normal(size=(count, 3)) * noise.dvl + [*bias, 0.0]
    pings = log.tolist()
    water = np.float32(101325.0 + 1000.0 * G * truth.z + rng.normal(size=count) * noise.pressure).astype(float).tolist()
    navigation, frame, answers = Navigation(params, ORIGIN), silence(4), []
    for k in range(count):
        tick, a, d, p = Tick(k, DT_NS), max(k - 1, 0), max(k - 10, 0), max(k - 2, 0)
        frame = SensorFrame(
            ahrs=Heard(Ahrs(*ahrs[a]), a * DT, True, True),
            dvl=Heard(Dvl(*pings[d], 0.01, 20.0), d * DT, True, True) if k % 20 == 10 else replace_fresh(frame.dvl),
            pressure=Heard(water[p], p * DT, True, True) if k % 5 == 2 else replace_fresh(frame.pressure),
            altitude=frame.altitude,
            fix=frame.fix,
            fins=frame.fins,
            n=frame.n,
            battery=frame.battery,
            leak=frame.leak,
        )
        answer = navigation.update(tick, change(k, frame), applied)
        if k % every == 0:
            answers.append(answer)
    return answers


def replace_fresh(heard: Heard[Any]) -> Heard[Any]:
    return Heard(heard.value, heard.t_valid, False, heard.ok)


def column(answers: list[StateEstimate], name: str) -> Any:
    return np.array([getattr(a.eta, name) if name in a.eta._fields else getattr(a.nu, name) for a in answers])


def off(answers: list[StateEstimate], truth: Truth, name: str, since: float = 3.0) -> Any:
    error = column(answers, name) - getattr(truth, name)
    if name in ("phi", "psi"):
        error = (error + np.pi) % (2 * np.pi) - np.pi
    return error[round(since / DT) :]


def rms(x: Any) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


WEAVING = truth_of(swim, 60.0)


def test_noise_of_the_angles_is_reduced_and_none_of_their_motion_lost() -> None:
    answers = sail(WEAVING)
    for name, sigma in (("phi", 0.3 * DEG), ("theta", 0.3 * DEG), ("psi", 0.5 * DEG)):
        # white noise through a first-order filter: sigma sqrt(T / 2 tau), with the defaults a tenth
        assert 0.07 * sigma < rms(off(answers, WEAVING, name)) < 0.14 * sigma, name
    for name in ("p", "q", "r"):
        assert rms(off(answers, WEAVING, name)) < 0.12 * DEG, name
    quiet = sail(WEAVING, noise=QUIET)
    for name in ("phi", "theta", "psi"):
        assert np.max(np.abs(off(quiet, WEAVING, name))) < 0.01 * DEG, name
    assert all(a.attitude_ok and a.depth_ok for a in quiet[10:])


def test_a_gyro_bias_stays_a_small_angle() -> None:
    biased = WEAVING._replace(p=WEAVING.p + 0.1 * DEG, q=WEAVING.q - 0.1 * DEG)
    for name, sign in (("phi", 1.0), ("theta", -1.0)):
        error = off(sail(biased, noise=QUIET), WEAVING, name)
        assert np.mean(error) == pytest.approx(sign * 0.1 * DEG * 0.5, rel=0.2)  # b tau


def test_rates_can_be_passed_through() -> None:
    params = load(NavigationParams, {"attitude": {"tau_rate_s": 0}}, "test")
    answers = sail(WEAVING, noise=QUIET, params=params)
    assert column(answers, "r")[1:] == pytest.approx(WEAVING.r[:-1], abs=1e-9)


def test_depth_is_smooth_and_not_late_in_a_dive() -> None:
    dive = truth_of(lambda t: (0 * t, 0 * t - 0.3, 0 * t, 1.8 + 0 * t, 0 * t, 0 * t), 30.0)
    answers = sail(dive, noise=QUIET)
    assert np.max(np.abs(off(answers, dive, "z"))) < 2e-3  # at half a metre per second
    noisy = off(sail(dive), dive, "z")
    assert rms(noisy) < 0.7 * 50.0 / (1000.0 * G)
    assert np.max(np.abs(noisy)) < 3.0 * answers[-1].depth_std


def test_a_late_ping_is_placed_where_it_was_true() -> None:
    """From rest at 0.3 m/s^2 for 6 s, then steady: what the DVL's delay and hold would lose is 0.2 s x 1.8 m/s."""
    start = truth_of(lambda t: (0 * t, 0 * t, 0.7 + 0 * t, 0.3 * np.minimum(t, 6.0), 0 * t, 0 * t), 10.0)
    answers = sail(start, noise=QUIET)
    for name in ("x", "y"):
        assert np.max(np.abs(off(answers, start, name, 8.0))) < 0.02
    assert np.max(np.abs(off(answers, start, "u", 8.0))) < 1e-9
    accelerating = off(answers, start, "u", 1.0)[:400]
    assert -0.3 * 0.31 <= np.min(accelerating) <= np.max(accelerating) <= -0.3 * 0.09  # held: between 0.1 and 0.3 s old


def test_position_of_a_noise_free_voyage() -> None:
    answers = sail(WEAVING, noise=QUIET)
    distance = 1.8 * 60.0
    for name in ("x", "y"):
        assert np.max(np.abs(off(answers, WEAVING, name))) < 2e-3 * distance


def test_sigma_of_the_position_is_honest() -> None:
    """Over many vehicles, each off by errors of the declared size: neither too sure of itself nor too modest."""
    path = truth_of(swim, 40.0)
    params = NavigationParams(position=PositionParams(std_start=1.0))
    draw, ratios = np.random.default_rng(7), []
    for seed in range(60):
        heading, scale = draw.normal(0, 1.0 * DEG), 1.0 + draw.normal(0, 0.005)
        bias, start = tuple(draw.normal(0, 0.002, 2)), draw.normal(0, 1.0 / math.sqrt(2.0), 2)
        answers = sail(path, seed, params=params, heading_off=heading, scale=scale, bias=bias, every=200)
        errors = [
            math.hypot(a.eta.x - path.x[i * 200] - start[0], a.eta.y - path.y[i * 200] - start[1])
            for i, a in enumerate(answers)
        ]
        sigmas = [a.position_std for a in answers]
        assert all(b > a for a, b in pairwise(sigmas))
        ratios.append([e / s for e, s in zip(errors, sigmas, strict=True)])
    ratio = np.array(ratios)
    for i in (0, 5, 10, 20):
        assert np.mean(ratio[:, i] < 2.5) >= 0.95
        assert 0.75 < rms(ratio[:, i]) < 1.25


def test_sigma_grows_with_the_distance_not_with_the_time_alone() -> None:
    rest = truth_of(lambda t: (0 * t,) * 6, 40.0)
    still, moving = sail(rest, noise=QUIET, every=1000), sail(truth_of(swim, 40.0), noise=QUIET, every=1000)

    def growth(answers: list[StateEstimate]) -> float:
        return math.sqrt(answers[-1].position_std ** 2 - answers[1].position_std ** 2)

    assert growth(moving) > 5.0 * growth(still)


def test_without_a_dvl_the_propeller_speaks_for_the_speed_and_sigma_tells() -> None:
    slowing = truth_of(lambda t: (0 * t, 0 * t, 0 * t, np.where(t < 20.0, 1.8, 1.5), 0 * t, 0 * t), 40.0)

    def lost(k: int, frame: SensorFrame) -> SensorFrame:
        return replace(frame, dvl=replace(frame.dvl, ok=k < 2000))

    params = NavigationParams(position=PositionParams(std_start=0.1))
    half = replace(ARMED, n=250.0 / 60.0)
    answers = sail(slowing, noise=QUIET, params=params, change=lost, applied=half)
    last = 1990 - 10  # the tick at which the last good ping was valid
    assert [a.velocity_ok for a in answers[last + 199 : last + 202]] == [True, True, False]
    assert answers[last + 150].nu.u == pytest.approx(1.8)
    assert answers[-1].nu.u == pytest.approx(0.9144, abs=0.01)  # half the trim point's speed
    stds = [a.velocity_std for a in answers[2000:]]
    assert stds[:1300] == sorted(stds[:1300])
    assert 1.5 - answers[-1].nu.u < stds[-1] < stds[1500]  # it coasts, and slows down
    assert stds[0] < 0.02
    error = abs(answers[-1].eta.x - slowing.x[-1])
    assert 0.5 * error < answers[-1].position_std < 3.0 * error
    assert answers[-1].attitude_ok


def test_the_reported_speed_of_the_propeller_comes_before_the_commanded() -> None:
    still = truth_of(lambda t: (0 * t,) * 6, 20.0)

    def reported(value: float, age: float) -> Callable[[int, SensorFrame], SensorFrame]:
        return lambda k, frame: replace(frame, dvl=silence(4).dvl, n=Heard(value, k * DT - age, True, True))

    for value, age, u in ((10.0, 0.0, 2.19), (10.0, 1.5, 1.83), (math.nan, 0.0, 1.83), (1e300, 0.0, 10.0)):
        assert sail(still, change=reported(value, age), every=100)[-1].nu.u == pytest.approx(u, abs=0.02)


def test_a_lost_ping_or_two_change_little() -> None:
    def some(k: int, frame: SensorFrame) -> SensorFrame:
        return replace(frame, dvl=replace(frame.dvl, ok=k // 20 % 4 != 1))

    answers = sail(WEAVING, noise=QUIET, change=some)
    assert all(a.velocity_ok for a in answers[10:])
    assert np.max(np.abs(off(answers, WEAVING, "x"))) < 0.3


def test_without_pressure_depth_goes_on_by_dead_reckoning() -> None:
    dive = truth_of(lambda t: (0 * t, 0 * t - 0.2, 0 * t, 1.5 + 0 * t, 0 * t, 0 * t), 30.0)

    def lost(k: int, frame: SensorFrame) -> SensorFrame:
        return frame if k < 1000 else replace(frame, pressure=replace(frame.pressure, ok=False))

    answers = sail(dive, noise=QUIET, change=lost)
    assert np.max(np.abs(off(answers, dive, "z"))) < 0.05
    valid = 995  # of the last reading, heard in tick 997
    assert [a.depth_ok for a in answers[valid + 99 : valid + 102]] == [True, True, False]
    assert answers[-1].depth_std > 10.0 * answers[900].depth_std


def test_without_pressure_depth_is_carried_no_higher_than_the_surface_and_deeper_again_from_there() -> None:
    def surfacing(t: Any) -> tuple[Any, ...]:
        nil = 0.0 * t
        return nil, np.where(t < 15.0, 0.3, -0.3), nil, 1.8 + nil, nil, nil

    def without(k: int, frame: SensorFrame) -> SensorFrame:
        return frame if k < 200 else replace(frame, pressure=replace(frame.pressure, ok=False))

    depths = column(sail(truth_of(surfacing, 20.0), change=without), "z")
    assert depths.min() >= 0.0
    assert depths[1490] == 0.0
    assert depths[-1] > 1.5


def test_sigma_of_the_depth_grows_from_the_time_out_up_to_the_range() -> None:
    navigation = afloat()
    stds = [hear(navigation, k, ASHORE).depth_std for k in (50, 100, 200, 300, 10**9)]
    assert stds[0] == stds[1] == PARAMS.depth.std
    assert stds[2:4] == [pytest.approx(math.hypot(0.03, 0.05 * lost)) for lost in (1.0, 2.0)]
    assert stds[4] == 500.0


def test_sigma_of_the_depth_covers_a_climb_that_nothing_aboard_can_see() -> None:
    """Without pressure and AHRS it climbed from 27 m to the surface, and was said to be in 25 m, 1 sigma 3 m."""

    def climbing(t: Any) -> tuple[Any, ...]:
        nil = 0.0 * t
        return nil, np.where(t < 10.0, 0.0, math.radians(20.0)), nil, 1.5 + nil, nil, nil

    def blind(k: int, frame: SensorFrame) -> SensorFrame:
        if k < 900:
            return frame
        return replace(frame, pressure=replace(frame.pressure, ok=False), ahrs=replace(frame.ahrs, ok=False))

    climb = truth_of(climbing, 50.0)
    answers = sail(climb, change=blind)
    error = np.abs(off(answers, climb, "z", since=0.0))
    assert error[-1] > 15.0
    assert np.all(error[1500:] < 3.0 * np.array([a.depth_std for a in answers[1500:]]))


def test_without_attitude_it_says_so_and_stays_finite() -> None:
    def lost(k: int, frame: SensorFrame) -> SensorFrame:
        return frame if k < 1000 else replace(frame, ahrs=replace(frame.ahrs, fresh=False))

    answers = sail(WEAVING, change=lost)
    valid = 998
    assert [a.attitude_ok for a in answers[valid + 49 : valid + 52]] == [True, True, False]
    grown = answers[-1].position_std ** 2 - answers[1000].position_std ** 2
    assert math.sqrt(grown) > 0.5 * 1.8 * 50.0
    assert column(answers, "psi")[-1] == column(answers, "psi")[valid + 60]


def test_sigma_of_the_depth_covers_a_dive_at_a_pitch_that_nobody_knows() -> None:
    dive = truth_of(lambda t: (0 * t, 0 * t - 0.3 * np.minimum(t / 10.0, 1.0), 0 * t, 1.5 + 0 * t, 0 * t, 0 * t), 30.0)

    def lost(k: int, frame: SensorFrame) -> SensorFrame:
        return frame if k < 200 else replace(frame, ahrs=replace(frame.ahrs, fresh=False))

    answers = sail(dive, noise=QUIET, change=lost)
    error = np.abs(off(answers, dive, "z"))
    assert error[-1] > 0.1  # held at the pitch of before, depth lags behind the pressure
    assert error[-1] < 3.0 * answers[-1].depth_std
    assert answers[100].depth_std == pytest.approx(PARAMS.depth.std)


# Surface, fixes and zeros


def hear(navigation: Navigation, k: int, applied: Applied = ARMED, **parts: Any) -> StateEstimate:
    return navigation.update(Tick(k, DT_NS), replace(silence(4), **parts), applied)


def fix_at(x: float, y: float, t: float, std: float = 2.0, ok: bool = True) -> Heard[Fix]:
    return Heard(Fix(*local_to_geodetic(ORIGIN, x, y), std), t, True, ok)


def pressed(depth: float, t: float) -> Heard[float]:
    return Heard(101325.0 + 1000.0 * G * depth, t, True, True)


def afloat(params: NavigationParams = PARAMS, depth: float = 0.0) -> Navigation:
    navigation = Navigation(params, ORIGIN)
    hear(navigation, 0, ASHORE, pressure=pressed(depth, 0.0))
    return navigation


def dived(heading: float, silent: Callable[[float], bool]) -> tuple[float, float]:
    """How far off the position is, m, and its sigma, 110 s after a minute of fixes at the surface, 1 m/s to the north.

    The AHRS says `heading`, rad, and the DVL says nothing while it is `silent`.
    """
    navigation = Navigation(PARAMS, ORIGIN)
    for k in range(17_000):
        t = k * DT
        parts: dict[str, Any] = {"ahrs": Heard(Ahrs(0.0, 0.0, heading, 0.0, 0.0, 0.0), t, True, True)}
        if k % 20 == 0:
            parts |= {"pressure": pressed(0.0 if t < 60.0 else 5.0, t)}
            parts |= {} if silent(t) else {"dvl": Heard(Dvl(1.0, 0.0, 0.0, 0.01, 20.0), t, True, True)}
        if k % 100 == 0 and t < 60.0:
            parts |= {"fix": fix_at(t, 0.0, t)}
        state = hear(navigation, k, **parts)
    return math.hypot(state.eta.x - t, state.eta.y), state.position_std


def test_what_the_velocity_was_off_by_without_pings_is_forgotten_when_they_come() -> None:
    off, sigma = dived(0.0, silent=lambda t: t < 60.0)
    assert off < 3.0 * sigma
    assert sigma < 5.0


def test_what_pings_were_off_by_at_the_surface_is_remembered_over_a_silence_of_theirs() -> None:
    off, sigma = dived(0.3, silent=lambda t: 65.0 < t < 70.0)
    assert 25.0 < off < 3.0 * sigma


@pytest.mark.parametrize("seed", range(5))
def test_fixes_show_that_a_velocity_carries_the_position_away(seed: int) -> None:
    """At rest, the DVL says 0.4 m/s; fixes scatter by 2 m."""
    navigation, draw, worst = Navigation(PARAMS, ORIGIN), np.random.default_rng(seed), 0.0
    for k in range(12_000):
        t = k * DT
        parts: dict[str, Any] = {"ahrs": Heard(Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), t, True, True)}
        if k % 20 == 0:
            parts |= {"pressure": pressed(0.0, t), "dvl": Heard(Dvl(0.0, 0.4, 0.0, 0.01, 20.0), t, True, True)}
        if k % 100 == 0:
            parts |= {"fix": fix_at(*draw.normal(0.0, 2.0, 2), t)}
        state = hear(navigation, k, **parts)
        if t > 40.0:  # fixes of 2 m tell a velocity to 0.13 m/s after 18 s
            worst = max(worst, math.hypot(state.eta.x, state.eta.y) / state.position_std)
    assert worst < 5.2  # 6.3 to 7.9 where nothing looks at what fixes leave the position by


def test_a_boat_that_was_carried_between_dives_has_no_velocity_that_is_wrong() -> None:
    """Kept with a sigma of 30 m, it was 91 m away: three sigmas, and the sigma of the dive grew by 0.2 m/s for it."""
    navigation = Navigation(PARAMS, ORIGIN)
    navigation.resume(KeptNavigation(91.0, 0.0, 30.0, 101325.0))
    for k in range(12_000):
        t = k * DT
        parts: dict[str, Any] = {"ahrs": Heard(Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), t, True, True)}
        if k % 20 == 0:
            parts |= {"pressure": pressed(0.0 if t < 30.0 else 5.0, t)}
            parts |= {"dvl": Heard(Dvl(0.0, 0.0, 0.0, 0.01, 20.0), t, True, True)}
        if k % 100 == 0 and t < 30.0:
            parts |= {"fix": fix_at(0.0, 0.0, t)}
        state = hear(navigation, k, **parts)
    assert math.hypot(state.eta.x, state.eta.y) < 3.0 * state.position_std < 3.0


def test_before_anything_is_heard_nothing_is_known_however_slowly_it_is_lost() -> None:
    velocity, depth = replace(PARAMS.velocity, accel_std=0.0), replace(PARAMS.depth, lost_std=0.0)
    state = hear(Navigation(replace(PARAMS, velocity=velocity, depth=depth), ORIGIN), 1000)
    assert state.depth_std == PARAMS.depth.range
    assert state.velocity_std >= PARAMS.velocity.lost_std
    assert state.position_std > PARAMS.position.std_start


def test_the_first_fix_is_taken_nearly_whole() -> None:
    state = hear(afloat(), 1, fix=fix_at(40.0, -30.0, 0.01))
    assert (state.eta.x, state.eta.y) == (pytest.approx(40.0, abs=0.1), pytest.approx(-30.0, abs=0.1))
    assert state.position_std == pytest.approx(2.0 * math.sqrt(2.0), abs=0.01)


def test_fixes_of_equal_worth_are_averaged_down_to_their_common_bias() -> None:
    navigation, draw = afloat(), np.random.default_rng(1)
    for k in range(1, 5):
        state = hear(navigation, k, fix=fix_at(10.0, 10.0, k * DT))
    assert state.position_std == pytest.approx(2.0 * math.sqrt(2.0) / 2.0, rel=0.01)
    for k in range(5, 200):
        x, y = 10.0 + draw.normal(0, 2.0, 2)
        state = hear(navigation, k, fix=fix_at(x, y, k * DT))
        assert state.position_std >= 0.5
    assert math.hypot(state.eta.x - 10.0, state.eta.y - 10.0) < 2.5 * state.position_std
    assert state.position_std == pytest.approx(0.5, abs=0.01)


def test_a_fix_is_moved_from_where_it_was_true() -> None:
    navigation = afloat()
    for k in range(1, 101):
        ping = Heard(Dvl(2.0, 0.0, 0.0, 0.01, 20.0), k * DT, True, True)
        level = Heard(Ahrs(0, 0, 0, 0, 0, 0), k * DT, True, True)
        fix = fix_at(0.0, 0.0, 0.5) if k == 100 else never(Fix(*[math.nan] * 3))
        state = hear(navigation, k, dvl=ping, ahrs=level, fix=fix)
    assert state.eta.x == pytest.approx(2.0 * 0.5, abs=0.01)


@pytest.mark.parametrize(
    ("depth", "fix", "taken"),
    [
        (0.999, fix_at(9.0, 9.0, 0.01), True),
        (1.001, fix_at(9.0, 9.0, 0.01), False),
        (0.0, fix_at(9.0, 9.0, 0.01, std=30.0), True),
        (0.0, fix_at(9.0, 9.0, 0.01, std=30.1), False),
        (0.0, fix_at(9.0, 9.0, 0.01, std=0.0), False),
        (0.0, fix_at(9.0, 9.0, 0.01, std=math.nan), False),
        (0.0, fix_at(9.0, 9.0, 0.01, ok=False), False),
        (0.0, fix_at(9.0, 9.0, 0.02), False),
        (0.0, fix_at(0.0, 19990.0, 0.01), True),
        (0.0, fix_at(0.0, 20010.0, 0.01), False),
        (0.0, Heard(Fix(0.0, 0.0, 2.0), 0.01, True, True), False),
        (0.0, Heard(Fix(math.nan, 0.0, 2.0), 0.01, True, True), False),
        (0.0, Heard(Fix(0.0, math.inf, 2.0), 0.01, True, True), False),
    ],
)
def test_which_fixes_are_believed(depth: float, fix: Heard[Fix], taken: bool) -> None:
    state = hear(afloat(depth=depth), 1, ASHORE, fix=fix)
    assert (state.position_std < 99.0) is taken
    assert (state.eta.y != 0.0) is taken


def test_the_zero_of_the_pressure_is_found_ashore_and_rests_afterwards() -> None:
    def depth_after(air: float, applied: Applied, then: float) -> float:
        navigation = Navigation(PARAMS, ORIGIN)
        for k in range(0, 500, 5):
            hear(navigation, k, applied, pressure=Heard(101325.0 + air, k * DT, True, True))
        for k in range(500, 1000, 5):
            state = hear(navigation, k, ARMED, pressure=Heard(101325.0 + air + then, k * DT, True, True))
        return state.eta.z

    water = 1000.0 * G * 3.0
    for air in (-1999.0, 0.0, 1999.0):
        assert depth_after(air, ASHORE, water) == pytest.approx(3.0, abs=1e-3)
    for air in (-2001.0, 2001.0):  # rather a depth than weather
        assert depth_after(air, ASHORE, water) == pytest.approx(3.0 + air / (1000.0 * G), abs=1e-3)
    assert depth_after(1500.0, ARMED, water) == pytest.approx(3.0 + 1500.0 / (1000.0 * G), abs=1e-3)
    fixed = afloat(load(NavigationParams, {"depth": {"zero_window_pa": 0}}, "test"))
    assert hear(fixed, 5, ASHORE, pressure=pressed(0.15, 5 * DT)).eta.z > 0.01
    assert hear(afloat(depth=0.15), 5, ASHORE).eta.z == 0.0
    navigation = afloat()
    hear(navigation, 1, ARMED)  # once is enough
    for k in range(5, 500, 5):  # disarmed again, awash: no new zero
        state = hear(navigation, k, ASHORE, pressure=pressed(0.15, k * DT))
    assert state.eta.z == pytest.approx(0.15, abs=1e-3)


def test_altitude_is_the_lesser_of_altimeter_and_dvl_and_unknown_without() -> None:
    def altitude(echo: Heard[float], ping: Heard[Dvl], k: int = 500) -> float:
        return hear(Navigation(PARAMS, ORIGIN), k, altitude=echo, dvl=ping).altitude

    def ping(value: float, t: float, ok: bool = True) -> Heard[Dvl]:
        return Heard(Dvl(0.0, 0.0, 0.0, 0.01, value), t, False, ok)

    none = silence(4)
    assert altitude(Heard(8.0, 4.9, False, True), ping(9.0, 4.8)) == 8.0
    assert altitude(Heard(8.0, 4.7, False, True), ping(9.0, 4.8)) == 8.0  # the nearer one, not the newer one
    assert altitude(Heard(8.0, 4.9, False, True), ping(7.0, 4.8)) == 7.0
    assert altitude(Heard(8.0, 4.9, False, False), ping(9.0, 4.8)) == 9.0
    assert altitude(Heard(math.nan, 4.9, False, True), ping(9.0, 4.8)) == 9.0
    assert altitude(Heard(8.0, 4.7, False, True), ping(-1.0, 4.8)) == 8.0
    assert altitude(Heard(8.0, 3.0, False, True), none.dvl) == 8.0
    for echo in (none.altitude, Heard(8.0, 2.99, False, True), Heard(math.inf, 4.9, True, True)):
        assert math.isnan(altitude(echo, ping(9.0, 4.9, ok=False)))


def test_humidity_over_its_limit_is_a_leak() -> None:
    for value, ok, leak in ((0.79, True, False), (0.8, True, False), (0.81, True, True), (0.81, False, False)):
        assert hear(afloat(), 1, leak=Heard(value, 0.01, True, ok)).leak is leak
    assert not hear(afloat(), 1, leak=Heard(math.nan, 0.01, True, True)).leak


# Nonsense

ANY = st.floats(allow_nan=True, allow_infinity=True)


def any_heard(values: st.SearchStrategy[Any]) -> st.SearchStrategy[Heard[Any]]:
    times = st.one_of(st.sampled_from([0.0, 0.01, 0.02, 0.03]), ANY)
    return st.builds(Heard, values, times, st.booleans(), st.booleans())


FRAMES = st.builds(
    SensorFrame,
    ahrs=any_heard(st.builds(Ahrs, *[st.one_of(st.floats(-2, 2), ANY)] * 6)),
    dvl=any_heard(st.builds(Dvl, *[st.one_of(st.floats(-5, 5), ANY)] * 5)),
    pressure=any_heard(st.one_of(st.floats(0, 1e6), ANY)),
    altitude=any_heard(ANY),
    fix=any_heard(
        st.builds(Fix, st.one_of(st.just(0.9), ANY), st.one_of(st.just(0.2), ANY), st.floats() | st.just(1.0))
    ),
    fins=st.just(()),
    n=any_heard(ANY),
    battery=any_heard(st.builds(Battery, ANY, ANY, ANY)),
    leak=any_heard(ANY),
)


@given(st.lists(FRAMES, min_size=1, max_size=8))
def test_whatever_is_heard_the_answer_is_finite(frames: list[SensorFrame]) -> None:
    navigation = Navigation(PARAMS, ORIGIN)
    for k, frame in enumerate(frames):
        state = navigation.update(Tick(k, DT_NS), frame, ARMED)
        numbers = (*state.eta, *state.nu, state.position_std, state.depth_std, state.velocity_std)
        assert all(map(math.isfinite, numbers))
        assert math.isnan(state.altitude) or 0.0 <= state.altitude < math.inf
        assert abs(state.eta.theta) <= math.pi / 2
        assert -math.pi <= state.eta.psi < math.pi
        assert min(state.position_std, state.depth_std, state.velocity_std) > 0.0


def test_nothing_heard_is_nothing_known() -> None:
    state = Navigation(PARAMS, ORIGIN).update(Tick(0, DT_NS), silence(4), ASHORE)
    assert (state.attitude_ok, state.depth_ok, state.velocity_ok, state.leak) == (False,) * 4
    assert math.isnan(state.altitude)


BAD = [math.nan, math.inf, -math.inf]


@pytest.mark.parametrize("bad", BAD)
def test_a_broken_value_now_and_then_leaves_no_trace(bad: float) -> None:
    def broken(k: int, frame: SensorFrame) -> SensorFrame:
        if k % 50 != 7:
            return frame
        now = Heard(bad, k * DT, True, True)
        ahrs, dvl = Heard(Ahrs(*[bad] * 6), k * DT, True, True), Heard(Dvl(*[bad] * 5), k * DT, True, True)
        return replace(frame, ahrs=ahrs, dvl=dvl, pressure=now, leak=now, n=now)

    answers = sail(WEAVING, noise=QUIET, change=broken)
    assert np.max(np.abs(off(answers, WEAVING, "psi"))) < 0.02 * DEG
    assert np.max(np.abs(off(answers, WEAVING, "z"))) < 0.01
    assert all(a.attitude_ok and a.velocity_ok and a.depth_ok for a in answers[10:])


def test_what_is_out_of_range_is_not_heard() -> None:
    wild: list[dict[str, Any]] = [
        {"ahrs": Heard(Ahrs(0.1, 1.6, 0.1, 0, 0, 0), 0.01, True, True)},
        {"ahrs": Heard(Ahrs(0.1, 0.1, 0.1, 0, 4.0, 0), 0.01, True, True)},
        {"dvl": Heard(Dvl(1.0, -10.1, 0.0, 0.01, 9.0), 0.01, True, True)},
        {"dvl": Heard(Dvl(1.0, 0.0, 0.0, 0.21, 9.0), 0.01, True, True)},
        {"pressure": Heard(101325.0 - 5.1 * 1000 * G, 0.01, True, True)},
        {"pressure": Heard(101325.0 + 501 * 1000 * G, 0.01, True, True)},
        {"ahrs": Heard(Ahrs(0.1, 0.1, 0.1, 0, 0, 0), 0.02, True, True)},  # from the future
        {"dvl": Heard(Dvl(1.0, 0.0, 0.0, 0.01, 9.0), 0.02, True, True)},
        {"pressure": pressed(3.0, 0.02)},
    ]
    for parts in wild:
        state = hear(Navigation(PARAMS, ORIGIN), 1, **parts)
        assert (state.attitude_ok, state.depth_ok, state.velocity_ok) == (False,) * 3, parts
    state = hear(Navigation(PARAMS, ORIGIN), 1, dvl=Heard(Dvl(1.0, 0, 0, math.nan, 9), 0.01, True, True))
    assert state.velocity_ok  # an unknown figure of merit is no bad one


def test_one_broken_number_spoils_its_whole_report() -> None:
    whole = Ahrs(0.1, 0.1, 0.1, 0.1, 0.1, 0.1)
    broken = [(field, bad) for field in Ahrs._fields for bad in BAD]
    for field, bad in [*broken, *[(rate, sign * 3.15) for rate in "pqr" for sign in (-1.0, 1.0)]]:
        report = whole._replace(**{field: bad})
        assert not hear(Navigation(PARAMS, ORIGIN), 1, ahrs=Heard(report, 0.01, True, True)).attitude_ok, report
    for rate in "pqr":
        report = whole._replace(**{rate: 3.14})
        assert hear(Navigation(PARAMS, ORIGIN), 1, ahrs=Heard(report, 0.01, True, True)).attitude_ok
    ping = Dvl(1.0, 0.1, 0.1, 0.01, 9.0)
    for field, bad in [(field, bad) for field in "uvw" for bad in (*BAD, 10.01, -10.01)]:
        wrong = Heard(ping._replace(**{field: bad}), 0.01, True, True)
        assert not hear(Navigation(PARAMS, ORIGIN), 1, dvl=wrong).velocity_ok, wrong
    assert hear(
        Navigation(PARAMS, ORIGIN), 1, dvl=Heard(ping._replace(altitude=math.nan), 0.01, True, True)
    ).velocity_ok


def test_what_is_told_twice_or_late_is_not_heard_again() -> None:
    def repeated(k: int, frame: SensorFrame) -> SensorFrame:
        ahrs, dvl, pressure = (replace(h, fresh=True) for h in (frame.ahrs, frame.dvl, frame.pressure))
        if k % 7 == 3:
            ahrs = replace(ahrs, t_valid=ahrs.t_valid - 0.5, value=Ahrs(*[0.5] * 6))
        return replace(frame, ahrs=ahrs, dvl=dvl, pressure=pressure)

    same = sail(WEAVING, noise=QUIET, every=100)
    told = sail(WEAVING, noise=QUIET, every=100, change=repeated)
    assert np.max(np.abs(column(told, "psi") - column(same, "psi"))) < 0.01 * DEG
    assert np.array_equal(column(told, "u"), column(same, "u"))
    assert column(told, "z") == pytest.approx(column(same, "z"), abs=1e-4)


def test_through_the_vertical_it_follows_the_ahrs() -> None:
    def steep(t: Any) -> tuple[Any, ...]:
        return 0 * t, 1.55 * np.sin(0.3 * t), 1.0 + 0 * t, 1.0 + 0 * t, 0 * t, 0 * t

    truth = truth_of(steep, 20.0)
    answers = sail(truth, noise=QUIET)
    assert np.max(np.abs(off(answers, truth, "theta"))) < 0.05 * DEG
    assert np.max(np.abs(off(answers, truth, "z"))) < 0.02


def test_frozen_and_thawed_it_goes_on_the_same() -> None:
    frames: list[SensorFrame] = []

    def keep(k: int, frame: SensorFrame) -> SensorFrame:
        frames.append(frame)
        return frame

    answers = sail(truth_of(swim, 6.0), change=keep)
    first, second = Navigation(PARAMS, ORIGIN), Navigation(PARAMS, ORIGIN)
    for k in range(300):
        first.update(Tick(k, DT_NS), frames[k], ARMED)
    second.thaw(first.freeze())
    for k in range(300, 600):
        assert repr(second.update(Tick(k, DT_NS), frames[k], ARMED)) == repr(answers[k])


def test_parameters_come_back_from_their_table() -> None:
    assert load(NavigationParams, dump(PARAMS), "test") == PARAMS
