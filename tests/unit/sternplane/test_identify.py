"""The parts of `identify`: slopes, the fit, what widens its intervals, and what it calls not identifiable."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from sternplane.identification import likelihood, simulation
from sternplane.identification.assessment import assess, learned_table
from sternplane.identification.confidence import confidence
from sternplane.identification.estimate import Estimated
from sternplane.identification.recording import Recording
from sternplane.identification.remedies import remedies
from sternplane.sitl import busless_flight

from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.model.observer_model import GROUPS, ObserverModel
from firmware_py.estimation.model.state import MOTIONS
from firmware_py.params import load
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.plant.truth import Truth

CONFIGS = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
TABLE = tomllib.loads((CONFIGS / "vehicle.toml").read_text())
VEHICLE = load(Vehicle, TABLE, "vehicle.toml")
TRUTH = load(Truth, tomllib.loads((CONFIGS / "truth.toml").read_text()), "truth.toml")
H = 0.02


def doublets(seconds: float) -> np.ndarray:
    """Stern planes and rudder at every combination of sides, not in step."""
    t = np.arange(round(seconds / H)) * H
    return np.radians(np.column_stack((10.0 * np.sign(np.sin(1.1 * t)), 12.0 * np.sign(np.sin(0.7 * t + 1.0)))))


def recorded(vehicle: Vehicle, seconds: float = 30.0) -> Recording:
    """A flight of the plant, measured without noise at every step, and a vehicle to believe in."""
    flight = busless_flight.fly(TRUTH, doublets(seconds), busless_flight.N_TRIM, H, current=(0.1, -0.05, 0.0))
    return Recording(
        vehicle=vehicle,
        table=TABLE,
        t=flight.t,
        h=H,
        inputs=flight.inputs,
        z=flight.x[1:],
        start=flight.x[0],
        dropped={},
        params=CoefficientParams(),
        std=busless_flight.SENSOR_STD,
    )


def wrong(factors: dict[str, float]) -> Vehicle:
    c = VEHICLE.coefficients
    return dataclasses.replace(
        VEHICLE, coefficients=dataclasses.replace(c, **{name: getattr(c, name) * f for name, f in factors.items()})
    )


def test_an_ascent_without_power_is_left_out_by_name_and_a_coefficient_that_lacks_is_named() -> None:
    recording = recorded(VEHICLE, 30.0)
    inputs = recording.inputs.copy()
    inputs[recording.t[1:] > 20.0, 3] = 0.0
    still = dataclasses.replace(recording, inputs=inputs)
    found = remedies(still, ("M_q", "N_r"), white=False, doubtful=False)
    assert found[0] == "the shaft stood still from 20.0 s on, as in an ascent: leave that out with --to 20.0"
    assert found[1].endswith("--coefficients M_q,N_r,M_w")
    assert len(remedies(recording, ("M_q", "N_r"), white=True, doubtful=True)) == 1
    assert remedies(recording, ("M_q", "M_w"), white=False, doubtful=True) == []
    assert remedies(still, ("M_q",), white=True, doubtful=False) == []
    from_rest = dataclasses.replace(recording, inputs=inputs[::-1])
    assert "--from 10.0" in remedies(from_rest, ("N_r",), white=False, doubtful=True)[0]


def test_slopes_of_the_whole_flight_are_those_of_finite_differences() -> None:
    model = ObserverModel(VEHICLE, TEN, 2, ("u", "q", "theta"))
    recording = recorded(VEHICLE, 4.0)
    x = model.state(recording.start[:6].tolist(), recording.start[6:].tolist())
    trajectory = simulation.simulate(model, recording, x)
    assert trajectory is not None
    for i in range(model.size):
        step = 1e-4 * (abs(x[i]) if i >= model.first else 1.0) * np.eye(model.size)[i]
        ahead, back = (simulation.simulate(model, recording, x + sign * step) for sign in (1.0, -1.0))
        assert ahead is not None
        assert back is not None
        wanted = (back.residuals - ahead.residuals) / (2.0 * step[i])  # residuals fall as predictions rise
        size = np.abs(wanted).max(axis=0)
        off = np.abs(trajectory.slopes[:, :, i] - wanted).max(axis=0)
        assert (off <= 2e-3 * size + 1e-6 * size.max()).all(), (*MOTIONS, "x_c", "y_c", "u", "q", "theta", *TEN)[i]


def test_without_noise_the_fit_finds_the_plant_s_coefficients_from_far_away() -> None:
    factors = {name: 1.4 if i % 3 else 0.6 for i, name in enumerate(TEN)}
    model = ObserverModel(wrong(factors), TEN, 2)
    prior = np.concatenate((np.full(9, np.inf), [0.3, 0.3], 0.7 * np.abs(model.believed)))
    found = likelihood.fit(model, recorded(wrong(factors)), prior)
    assert found.found
    true = [getattr(VEHICLE.coefficients, name) for name in TEN]
    assert found.x[model.first :] == pytest.approx(true, rel=1e-3)
    assert found.x[9:11] == pytest.approx([0.1, -0.05], abs=1e-4)


def test_a_heading_through_south_is_no_residual() -> None:
    recording = recorded(VEHICLE, 4.0)
    turned = recording.z.copy()
    turned[:, 8] += 2.0 * math.pi
    model = ObserverModel(VEHICLE, (), 2)
    x = model.state(recording.start[:6].tolist(), recording.start[6:].tolist())
    straight = simulation.simulate(model, recording, x)
    around = simulation.simulate(model, dataclasses.replace(recording, z=turned), x)
    assert straight is not None
    assert around is not None
    np.testing.assert_allclose(around.residuals, straight.residuals, atol=1e-12)


def mean_of(noise: np.ndarray) -> likelihood.Fit:
    """The fit of one number, the mean of a series; the other eight motions carry noise that tells nothing of it."""
    n = len(noise)
    residuals = np.random.default_rng(0).standard_normal((n, 9))
    residuals[:, 0] = noise - noise.mean()
    slopes = np.zeros((n, 9, 1))
    slopes[:, 0, 0] = 1.0
    return likelihood.Fit(np.zeros(1), residuals, slopes, likelihood.spread(residuals), np.zeros(1), 1, True)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_intervals_widen_as_the_mean_of_correlated_noise_asks(rho: float) -> None:
    rng, n = np.random.default_rng(5), 20000
    noise, kicks = np.zeros(n), rng.standard_normal(n)
    for k in range(1, n):
        noise[k] = rho * noise[k - 1] + kicks[k]
    sure = confidence(mean_of(noise))
    # The variance of the mean of a first-order process is (1 + rho) / (1 - rho) that of white noise.
    assert sure.widening[0] == pytest.approx(math.sqrt((1.0 + rho) / (1.0 - rho)), rel=0.35)
    assert sure.widening[0] >= 1.0
    assert sure.whiteness[0] == pytest.approx(rho, abs=0.03)


def answer(std: dict[str, float], correlated: dict[tuple[str, str], float] | None = None) -> SimpleNamespace:
    """Of the ten with a prior of 70 %; `std` as shares of what is believed, 1 % where not given."""
    believed = np.array([getattr(VEHICLE.coefficients, name) for name in TEN])
    deviations = np.array([std.get(name, 0.01) for name in TEN]) * np.abs(believed)
    covariance = np.diag(deviations**2)
    for (a, b), rho in (correlated or {}).items():
        i, j = TEN.index(a), TEN.index(b)
        covariance[i, j] = covariance[j, i] = rho * deviations[i] * deviations[j]
    return SimpleNamespace(
        names=TEN,
        believed=believed,
        prior=0.7 * np.abs(believed),
        taken=Estimated(1.1 * believed, covariance),
        sizes=np.abs(1.1 * believed),
    )


def test_all_that_is_known_is_laid_into_the_vehicle_s_table_and_nothing_else() -> None:
    found = answer({})
    verdict = assess(found)  # type: ignore[arg-type]
    assert verdict.sentences == ()
    table = learned_table(TABLE, found, verdict)  # type: ignore[arg-type]
    changed = {name for name, value in table["coefficients"].items() if value != TABLE["coefficients"][name]}
    assert changed == set(TEN)
    assert {key: value for key, value in table.items() if key != "coefficients"} == {
        key: value for key, value in TABLE.items() if key != "coefficients"
    }


@pytest.mark.parametrize("hull", ["npsauv2", "remus100", "torpedo_x"])
@pytest.mark.parametrize("group", GROUPS)
def test_a_scale_of_added_mass_scales_what_the_file_has_of_it_and_leaves_out_what_it_has_not(
    hull: str, group: str
) -> None:
    table = tomllib.loads((CONFIGS.parent / hull / "vehicle.toml").read_text())
    found = SimpleNamespace(names=(group,), taken=Estimated(np.array([1.5]), np.eye(1)))
    learned = learned_table(table, found, SimpleNamespace(unknown=()))  # type: ignore[arg-type]
    there, now = (load(Vehicle, one, hull).coefficients for one in (table, learned))
    assert learned["coefficients"].keys() == table["coefficients"].keys()
    for name in table["coefficients"]:
        assert getattr(now, name) == getattr(there, name) * (1.5 if name in GROUPS[group] else 1.0)


def test_what_nothing_excites_is_named_and_stays() -> None:
    found = answer({"M_ds": 0.7, "Z_ds": 0.699})
    verdict = assess(found)  # type: ignore[arg-type]
    assert verdict.sentences == ("M_ds, Z_ds: nothing in this span of the log excites them",)
    table = learned_table(TABLE, found, verdict)  # type: ignore[arg-type]
    for name in TEN:
        assert (table["coefficients"][name] == TABLE["coefficients"][name]) == (name in ("M_ds", "Z_ds"))


def test_a_sum_that_nothing_tells_is_named_and_its_members_stay() -> None:
    """Each alone looks half known; their sum along one diagonal is as it was before, the other is known."""
    found = answer({"Y_r": 0.5, "Y_v": 0.5}, {("Y_r", "Y_v"): 0.9999})
    verdict = assess(found)  # type: ignore[arg-type]
    assert verdict.unknown == ("Y_r", "Y_v")
    assert len(verdict.sentences) == 1
    assert "0.7 Y_r + 0.7 Y_v" in verdict.sentences[0]
