"""The sea: a current that is what was asked, turbulence with the statistics that were asked."""

from __future__ import annotations

import math

import numpy as np
import pytest

from firmware_py import params
from firmware_py.marine import Origin
from sim_bridge.plant.environment import Environment, EnvironmentParams


def samples(turbulence: float, time: float, dt: float, count: int, seed: int = 7) -> np.ndarray:
    environment = Environment(EnvironmentParams((0.3, -0.1, 0.05), turbulence, time), seed, dt)
    out = []
    for _ in range(count):
        out.append(environment.current)
        environment.step()
    return np.array(out)


def test_without_turbulence_the_current_is_constant_and_nothing_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(np.random, "Generator", lambda _bits: None)  # from which nothing can be drawn
    environment = Environment(EnvironmentParams((0.3, -0.1, 0.05)), 7, 0.01)
    for _ in range(2000):
        environment.step()
        assert environment.current == (0.3, -0.1, 0.05)


@pytest.mark.parametrize("dt", [0.01, 0.1])
def test_turbulence_has_its_mean_intensity_and_correlation_time(dt: float) -> None:
    series = samples(0.2, 1.0, dt, round(4000.0 / dt))  # 4000 correlation times
    eddies = series - np.array([0.3, -0.1, 0.05])
    assert np.abs(eddies.mean(axis=0)).max() < 4.0 * 0.2 * math.sqrt(2.0 / 4000.0)
    np.testing.assert_allclose(eddies.std(axis=0), 0.2, rtol=0.06)
    lag = round(1.0 / dt)
    correlation = (eddies[:-lag] * eddies[lag:]).mean(axis=0) / eddies.var(axis=0)
    np.testing.assert_allclose(correlation, math.exp(-1.0), atol=0.06)
    across = np.corrcoef(eddies.T) - np.eye(3)
    assert np.abs(across).max() < 0.1


def test_it_starts_stationary() -> None:
    first = np.array([samples(0.2, 5.0, 0.01, 1, seed)[0] for seed in range(2000)]) - np.array([0.3, -0.1, 0.05])
    np.testing.assert_allclose(first.std(axis=0), 0.2, rtol=0.06)


def test_the_seed_decides_everything() -> None:
    one, again, other = (samples(0.2, 1.0, 0.01, 3000, seed) for seed in (1, 1, 2))
    assert one.tobytes() == again.tobytes()
    assert not np.any(one == other)


def test_twice_the_intensity_is_the_same_sea_twice_as_rough() -> None:
    mean = np.array([0.3, -0.1, 0.05])
    np.testing.assert_allclose(samples(0.4, 1.0, 0.01, 500) - mean, 2.0 * (samples(0.2, 1.0, 0.01, 500) - mean))


def test_a_scenario_table_makes_it_and_bad_values_are_named() -> None:
    table = {
        "current_ned_m_s": [0.2, 0.0, 0.0],
        "turbulence_m_s": 0.05,
        "turbulence_time_s": 20.0,
        "bottom_depth_m": 60.0,
        "surface_pressure_pa": 101000.0,
        "latitude_deg": 45.0,
        "longitude_deg": -90.0,
    }
    sea = params.load(EnvironmentParams, table, "scenario.toml: environment")
    assert sea == EnvironmentParams((0.2, 0.0, 0.0), 0.05, 20.0, 60.0, 101000.0, math.pi / 4.0, -math.pi / 2.0)
    assert sea.origin == Origin(math.pi / 4.0, -math.pi / 2.0)
    assert params.load(EnvironmentParams, {}, "x").turbulence == 0.0
    with pytest.raises(params.ParamError, match=r"turbulence_m_s = -1"):
        params.load(EnvironmentParams, {"turbulence_m_s": -1}, "scenario.toml: environment")
