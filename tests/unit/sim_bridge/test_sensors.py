"""How instruments err: noise, bias, latency, dropout, and that none of them disturbs another."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from firmware_py.marine import Eta, Nu, Origin, geodetic_to_local
from firmware_py.params import ParamError, load
from sim_bridge.devices.instruments import (
    AhrsParams,
    AltimeterParams,
    BatteryParams,
    DvlParams,
    FixParams,
    Instruments,
    InstrumentsParams,
    LeakParams,
    PressureParams,
    Water,
)
from sim_bridge.devices.sensors import Sensor, Timing, due

ROOT = Path(__file__).resolve().parents[3]
WATER = Water(1000.0, 101_325.0, Origin(math.radians(36.8), math.radians(-121.8)))
QUIET = InstrumentsParams(
    ahrs=AhrsParams(100, 0.0, 0.0, 0.0, 0.0, 0.0),
    pressure=PressureParams(20, noise=0.0),
    dvl=DvlParams(5, noise=0.0, altitude_noise=0.0),
    altimeter=AltimeterParams(10, noise=0.0),
    fix=FixParams(1, noise=0.0),
    battery=BatteryParams(1, noise=0.0),
    leak=LeakParams(1, noise=0.0),
)


def plant(z: float = 5.0, altitude: float = 20.0, n: float = 0.0, **motion: float) -> SimpleNamespace:
    eta = Eta(0.0, 0.0, z, 0.0, 0.0, 0.0)._replace(**{k: v for k, v in motion.items() if k in Eta._fields})
    nu = Nu(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)._replace(**{k: v for k, v in motion.items() if k in Nu._fields})
    return SimpleNamespace(eta=eta, nu=nu, n=n, altitude=altitude)


def sensor(timing: Timing, noise: float = 0.0, bias: float = 0.0, seed: int = 1, name: str = "s") -> Sensor:
    return Sensor(name, timing, lambda b, e: b + e[0], (noise,), (bias,), seed, 100)


def run(s: Sensor, ticks: int, signal=lambda k: 0.0) -> list[tuple[int, object]]:
    return [(k, r) for k in range(ticks) if (r := s.update(k, signal(k))) is not None]


def errors(noise: float, bias: float = 0.0, seed: int = 1, name: str = "s", ticks: int = 20_000) -> np.ndarray:
    return np.array([r.value for _, r in run(sensor(Timing(100), noise, bias, seed, name), ticks)])


def test_noise_is_white_with_the_sigma_that_was_asked_for():
    e = errors(0.3)
    n = len(e)
    assert n == 20_000
    assert abs(e.mean()) < 4 * 0.3 / math.sqrt(n)
    assert e.std() == pytest.approx(0.3, rel=4 / math.sqrt(2 * n))
    lag = np.array([np.mean(e[i:] * e[:-i]) for i in range(1, 20)]) / e.var()
    assert np.all(np.abs(lag) < 4 / math.sqrt(n))
    assert np.mean(np.abs(e) < 0.3) == pytest.approx(math.erf(1 / math.sqrt(2)), abs=0.015)


def test_bias_is_constant_in_a_run_and_spread_over_seeds():
    drawn = []
    for seed in range(400):
        e = errors(0.0, bias=2.0, seed=seed, ticks=300)
        assert np.all(e == e[0])
        drawn.append(e[0])
    assert abs(np.mean(drawn)) < 4 * 2.0 / 20
    assert np.std(drawn) == pytest.approx(2.0, rel=4 / math.sqrt(800))


@pytest.mark.parametrize("ticks", [0, 1, 7, 10, 33])
def test_latency_is_exact_in_ticks_and_the_reading_is_of_its_time_of_validity(ticks):
    s = sensor(Timing(20, latency=ticks * 0.01))
    heard = run(s, 300, signal=float)
    assert [k for k, _ in heard] == [k for k in range(ticks, 300) if (k - ticks) % 5 == 0]
    for k, reading in heard:
        assert reading.value == k - ticks
        assert reading.t_valid == pytest.approx((k - ticks) * 0.01, abs=1e-12)


def test_latency_is_rounded_to_whole_ticks():
    assert sensor(Timing(20, latency=0.0949)).delay == 9
    assert sensor(Timing(20, latency=0.0951)).delay == 10


@pytest.mark.parametrize("p", [0.0, 0.1, 0.5, 1.0])
def test_dropout_loses_its_share_and_shifts_no_noise(p):
    whole = dict(run(sensor(Timing(100), noise=1.0), 10_000))
    rest = dict(run(sensor(Timing(100, dropout=p), noise=1.0), 10_000))
    assert 1 - len(rest) / len(whole) == pytest.approx(p, abs=4 * math.sqrt(p * (1 - p) / 10_000))
    assert all(whole[k] == reading for k, reading in rest.items())


def test_dropouts_are_not_periodic():
    gaps = np.diff([k for k, _ in run(sensor(Timing(100, dropout=0.5)), 20_000)])
    for gap in range(1, 5):  # geometric
        assert np.mean(gaps == gap) == pytest.approx(0.5**gap, abs=0.02)


def test_streams_of_two_instruments_and_two_seeds_are_independent():
    a, b, c = errors(1.0), errors(1.0, name="t"), errors(1.0, seed=2)
    for other in (b, c):
        assert abs(np.corrcoef(a, other)[0, 1]) < 4 / math.sqrt(len(a))
    assert np.array_equal(a, errors(1.0))


def test_changing_one_instrument_leaves_the_others_readings_alone():
    def readings(params: InstrumentsParams) -> dict[str, list]:
        instruments = Instruments(params, WATER, 7, 100)
        names = [f.name for f in dataclasses.fields(params)]
        return {name: run(getattr(instruments, name), 400, lambda k: plant(z=0.1)) for name in names}

    shipped = load_shipped()
    before = readings(shipped)
    for name in before:
        changed = dataclasses.replace(getattr(shipped, name), rate=2, latency=0.05, dropout=0.3)
        after = readings(dataclasses.replace(shipped, **{name: changed}))
        assert {k for k in before if repr(before[k]) != repr(after[k])} == {name}


@pytest.mark.parametrize("rate", [101, 150, 1000])
def test_an_instrument_that_is_faster_than_the_base_rate_speaks_once_every_tick(rate):
    assert [k for k, _ in run(sensor(Timing(rate)), 250)] == list(range(250))
    assert run(sensor(Timing(rate), noise=1.0), 250) == run(sensor(Timing(100), noise=1.0), 250)


@pytest.mark.parametrize(("rate", "base"), [(1, 50), (20, 50), (30, 100), (100, 250), (7, 1000), (100, 100)])
def test_a_rate_has_its_ticks_in_every_second_and_evenly(rate, base):
    ticks = [k for k in range(3 * base) if due(k, rate, base)]
    assert ticks[0] == 0
    assert [sum(s * base <= k < (s + 1) * base for k in ticks) for s in range(3)] == [rate] * 3
    assert set(np.diff(ticks)) <= {base // rate, -(-base // rate)}


def load_shipped() -> InstrumentsParams:
    table = tomllib.loads((ROOT / "configs/npsauv2/sensors.toml").read_text())
    names = {f.name for f in dataclasses.fields(InstrumentsParams)}
    return load(InstrumentsParams, {k: v for k, v in table.items() if k in names}, "sensors.toml")


def test_the_shipped_instruments_are_those_of_the_data_sheet():
    p = load_shipped()
    assert [p.ahrs.rate, p.pressure.rate, p.dvl.rate] == [100, 20, 5]
    assert math.degrees(p.ahrs.roll_pitch_noise) == pytest.approx(0.3)
    assert math.degrees(p.ahrs.yaw_noise) == pytest.approx(0.5)
    assert math.degrees(p.ahrs.gyro_noise) == pytest.approx(0.05)
    assert p.dvl.noise == 0.01


def value(name: str, b: SimpleNamespace, params: InstrumentsParams = QUIET):
    return getattr(Instruments(params, WATER, 1, 100), name).update(0, b).value


def test_dvl_measures_over_the_ground_and_loses_lock_out_of_range():
    moving = {"u": 1.8, "v": -0.2, "w": 0.05}
    near, far = QUIET.dvl.range_min, QUIET.dvl.range_max
    assert value("dvl", plant(**moving, altitude=20.0))[:3] == (1.8, -0.2, 0.05)
    for altitude, locked in [
        (math.nextafter(near, 0), False),
        (near, True),
        (far, True),
        (math.nextafter(far, 99), False),
        (-1.0, False),
    ]:
        assert (value("dvl", plant(altitude=altitude)) is not None) is locked


def test_altimeter_tells_too_near_from_too_far():
    assert value("altimeter", plant(altitude=12.5)) == 12.5
    assert value("altimeter", plant(altitude=0.29)) == 0.0
    assert value("altimeter", plant(altitude=60.01)) == math.inf


def test_there_is_a_fix_only_at_the_surface():
    at_surface = value("fix", plant(z=0.3, x=100.0, y=-50.0))
    assert geodetic_to_local(WATER.origin, at_surface.latitude, at_surface.longitude) == pytest.approx((100.0, -50.0))
    assert value("fix", plant(z=math.nextafter(0.3, 1))) is None


def test_fix_errs_by_its_sigma_in_metres():
    params = dataclasses.replace(QUIET, fix=FixParams(100, noise=2.0))
    s = Instruments(params, WATER, 3, 100).fix
    fixes = [geodetic_to_local(WATER.origin, *r.value[:2]) for _, r in run(s, 4000, lambda k: plant(z=0.0))]
    assert np.std(fixes, axis=0) == pytest.approx([2.0, 2.0], rel=0.05)


def test_pressure_grows_by_the_weight_of_the_water_and_not_above_it():
    assert value("pressure", plant(z=0.0)) == 101_325.0
    assert value("pressure", plant(z=-1.0)) == 101_325.0
    assert value("pressure", plant(z=10.0)) == pytest.approx(101_325.0 + 98_066.5)


def test_heading_stays_in_half_open_turn():
    noisy = dataclasses.replace(QUIET, ahrs=AhrsParams(100, yaw_noise=0.2))
    psi = np.array(
        [r.value.psi for _, r in run(Instruments(noisy, WATER, 1, 100).ahrs, 2000, lambda k: plant(psi=3.1))]
    )
    assert psi.min() < -3.0
    assert psi.max() > 3.0
    assert np.all((psi >= -math.pi) & (psi < math.pi))


def test_battery_drains_by_hotel_and_the_cube_of_the_shaft_speed_and_never_below_empty():
    p = BatteryParams(1, capacity=60.0 * 460.0, noise=0.0)  # 460 W for a minute

    def after(seconds: int, n: float) -> float:
        s, still = Instruments(dataclasses.replace(QUIET, battery=p), WATER, 1, 100).battery, plant(n=n)
        return run(s, seconds * 100 + 1, lambda k: still)[-1][1].value

    assert after(60, 500 / 60).remaining == pytest.approx(0.0, abs=1e-9)  # 60 W + 400 W for a minute
    assert after(60, 250 / 60).remaining == pytest.approx(1 - (60 + 50) / 460)
    assert after(60, -250 / 60).remaining == pytest.approx(1 - (60 + 50) / 460)
    empty = after(66, 500 / 60)
    assert empty.remaining == 0.0
    assert empty.voltage < after(10, 500 / 60).voltage < after(10, 0.0).voltage < 50.4


def test_a_battery_that_rises_when_it_empties_is_refused():
    with pytest.raises(ParamError, match="voltage_empty_v"):
        Instruments(dataclasses.replace(QUIET, battery=BatteryParams(1, voltage_empty=60.0)), WATER, 1, 100)
