"""How the vehicle of a case is flown and measured, and how a filter runs over the flight."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from firmware_py import params
from firmware_py.adapters.installation import configs
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.model.state import EDDIES, MOVING
from firmware_py.guidance.excitation import PERIOD, opposite, prbs
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.plant.truth import Truth
from sim_bridge.truth_file import read_truth
from sternplane.identification.cramer_rao_bound import bounds, true_states
from sternplane.logs.tracking import Array
from sternplane.sitl.busless_flight import N_TRIM, SENSOR_STD, BuslessFlight, fly, held_level, measure, measurement_mask
from sternplane.study.rows import RunArrays
from sternplane.study.shipped_filter import shipped

CONFIG = configs() / "npsauv2"
FINS = ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")
"""Its fins."""
PAPER_EKF = dict(zip(TEN, (0.12, 0.26, 0.33, 0.58, 0.13, 0.05, 0.09, 14.53, 9.61, 23.29), strict=True))
"""Table 1 of the paper, %: the steady-state errors of its EKF, noise-free."""
PAPER_SMO = dict(zip(TEN, (1.10, 1.46, 24.67, 17.78, 30.35, 3.07, 2.48, 49.34, 102.57, 44.22), strict=True))
"""The same of its sliding-mode observer."""
AMPLITUDE, CLOCK = math.radians(20.0), 4.0
"""Of the PRBS, rad and s: chosen by the bound, which after 900 s is then 0.72 of the tightest target; at 17 deg and
2.5 s 0.96. Pitch stays below 30 deg."""
WRONG = 0.5
"""How far off every coefficient starts; it is also the filter's prior sigma."""
START_UP_TIMES = 3.5
"""After so many of its time constants a start-up noise is left with exp(-7) = 0.1 % of its variance."""
FIXED_SEED = 1000  # of runs without noise: the same whatever seeds the study is given
MARGIN = 1.25
"""The target of a row without noise over what was reached when the target was written."""
POINTS = 24
"""At how many times a run is looked at."""


@functools.cache
def true_vehicle() -> Truth:
    """Return the simulated vehicle."""
    return read_truth(CONFIG / "truth.toml")


@functools.cache
def vehicle() -> Vehicle:
    """Return the vehicle as the vehicle file has it."""
    path = CONFIG / "vehicle.toml"
    return params.load(Vehicle, tomllib.loads(path.read_text()), str(path))


def flying(**changes: Any) -> CoefficientParams:
    """Return the shipped settings as the study's flights need them.

    Sensors have no bias, fin angles are exact, coefficients are known to `WRONG` before, and all but the ten is known.
    """
    unbiased = {"std": WRONG, "speed_bias": 0.0, "rate_bias": 0.0, "angle_bias": 0.0}
    known: dict[str, Any] = {"nuisances": (), "stds": {}, "surge_noise": 0.0, "roll_noise": 0.0, "fin_resolution": 0.0}
    return dataclasses.replace(shipped(), **{**unbiased, **known, **changes})


def start_up_over() -> float:
    """Return the age, s, from which the start-up noise is less than 0.1 % of its variance.

    Until then NIS and NEES stay below 1, on purpose.
    """
    return shipped().learning_delay + START_UP_TIMES * shipped().startup_time


@dataclass(frozen=True, slots=True)
class Setup:
    """One way of flying and measuring."""

    duration: float = 60.0
    h: float = 0.01
    inertial: float = 100.0
    """Rate of gyro and attitude, Hz."""
    dvl: float = 5.0
    """Rate of the velocity over ground, Hz."""
    current: float = 0.0
    """m/s, to a side drawn by the seed."""
    turbulence: float = 0.0
    noise: float = 1.0
    """Of the sensors, as a part of SENSOR_STD: in what they say and in what the filter is told. 0 is exact, and told
    to be a thousandth."""

    @property
    def label(self) -> str:
        """Duration and rates, as a row names them."""
        both = f"inertial {self.inertial:g} Hz, DVL {self.dvl:g} Hz"
        return f"{self.duration:g} s, {both if self.inertial != self.dvl else f'all sensors {self.dvl:g} Hz'}"

    @property
    def rates(self) -> tuple[float, ...]:
        """Of u v w p q r phi theta psi, Hz."""
        return (self.dvl,) * 3 + (self.inertial,) * 6

    @property
    def std(self) -> Array:
        """What the filter is told of the nine, 1 sigma."""
        std: Array = SENSOR_STD * (self.noise or 1e-3)
        return std

    def drift(self, seed: int) -> tuple[float, float, float]:
        """Return the steady current of a seed, NED, m/s."""
        side = np.random.default_rng([seed, *b"side"]).uniform(0.0, math.tau)
        return self.current * math.cos(side), self.current * math.sin(side), 0.0


def excitation(setup: Setup, seed: int) -> Array:
    """Return the PRBS of a seed, rad, (K, 2): each seed begins elsewhere in the sequence."""
    clock, register = round(CLOCK / setup.h), 1 + seed % PERIOD
    other = opposite(register)
    steps = range(round(setup.duration / setup.h))
    return AMPLITUDE * np.array([(prbs(k, clock, register), prbs(k, clock, other)) for k in steps])


def fly_prbs(setup: Setup, seed: int, truth: Truth | None = None) -> BuslessFlight:
    """Fly the simulated vehicle under its PRBS, held softly at its depth."""
    return fly(
        truth or true_vehicle(),
        excitation(setup, seed),
        N_TRIM,
        setup.h,
        seed,
        setup.drift(seed),
        setup.turbulence,
        hold=held_level(),
    )


def starts(seed: int, wrong: float, names: Sequence[str] = TEN) -> dict[str, float]:
    """Return factors 1 +- wrong, the sign of each coefficient drawn by the seed."""
    signs = np.random.default_rng([seed, *b"start"]).choice((-1.0, 1.0), len(names))
    return {name: 1.0 + wrong * float(sign) for name, sign in zip(names, signs, strict=True)}


class FilterRun(NamedTuple):
    """What a filter made of a flight, at POINTS times; NaN from where it broke off at a number that was not finite."""

    t: Array
    """(points,), s."""
    error: Array
    """(points, names), as a part of the true value."""
    std: Array
    """What the filter says of it."""
    nees: Array
    """(points, 2): normalised error squared of the learned coefficients, and of all states."""
    freedom: tuple[int, int]
    """How many numbers these are sums over."""
    nis: Array
    """(points, 3, 2): of DVL, gyro and attitude, since the point before: the sum of normalised innovations squared, and
    how many."""
    weights: Array
    """(points, members) of the bank."""
    current: Array
    """(points, 2): error of the steady current, m/s."""
    steps: int
    """Made, of those asked."""

    def arrays(self) -> RunArrays:
        """Return all fields as arrays by name."""
        return {name: np.asarray(value) for name, value in self._asdict().items()}


def run_filter(
    setup: Setup,
    flight: BuslessFlight,
    ekf: CoefficientEkf,
    seed: int,
    factors: Mapping[str, float],
    true: Array | None = None,
) -> FilterRun:
    """Run a filter over a flight.

    Args:
        setup: how it is measured.
        flight: what was flown.
        ekf: the filter.
        seed: of the noise.
        factors: what each coefficient begins with, over what is believed.
        true: true values of the model's parameters, (parameters,); None is as believed.
    """
    model = ekf.model
    z = measure(flight, SENSOR_STD * setup.noise, setup.rates, seed)
    begin = np.random.default_rng([seed, *b"begin"]).standard_normal(9) * SENSOR_STD * setup.noise + flight.x[0]
    believed = dict(zip(model.names, model.believed, strict=True))
    ekf.start(begin[:6], begin[6:], setup.std, {name: believed[name] * f for name, f in factors.items()})
    size = np.abs(np.array(true_or_believed(true, model.believed)))[: len(ekf.names)]
    current = setup.drift(seed)[:2]
    states = true_states(model, flight.x, (*current, 0.0, 0.0, 0.0), true)
    if model.water == EDDIES:
        states[1:, MOVING + 2 : MOVING + 5] = flight.water - setup.drift(seed)
    steps = len(flight.inputs)
    edges = np.linspace(0, steps, POINTS + 1).round().astype(int)
    rows: list[tuple[Array, ...]] = []
    made = 0
    for a, b in itertools.pairwise(edges.tolist()):
        history = ekf.run(setup.h, flight.inputs[a:b], z[a:b], setup.std**2, every=b - a)
        made += history.steps
        seen = ekf.estimate()
        off = seen.mean - states[b]
        off[6:9] = (off[6:9] + math.pi) % math.tau - math.pi
        first, count = model.first, len(ekf.names)
        part = slice(first, first + count)
        kept = np.diag(seen.covariance) > 0.0
        rows.append(
            (
                off[part] / size,
                seen.std / size,
                np.array(
                    [
                        _square(off[part], seen.covariance[part, part]),
                        _square(off[kept], seen.covariance[kept][:, kept]),
                    ]
                ),
                seen.weights,
                seen.current - current,
                np.array([(np.nansum(came), np.isfinite(came).sum()) for came in np.split(history.nis, 3, axis=1)]),
            )
        )
        if history.steps < b - a:
            lost = tuple([part * math.nan for part in rows[-1]])
            rows[-1:] = [lost] * (POINTS + 1 - len(rows))
            break
    error, std, nees, weights, flow, nis = (np.array(column) for column in zip(*rows, strict=True))
    return FilterRun(
        flight.t[edges[1:]],
        error,
        std,
        nees,
        (len(ekf.names), int(kept.sum())),
        nis,
        weights,
        flow,
        made,
    )


def true_or_believed(true: Array | None, believed: Sequence[float]) -> Array:
    """Return the true values; None means as believed."""
    return np.array(believed) if true is None else true


def bound_std(
    setup: Setup,
    flight: BuslessFlight,
    ekf: CoefficientEkf,
    seed: int,
    at: Sequence[float] | Array,
    true: Array | None = None,
) -> Array:
    """Return the bound's 1 sigma of the learned coefficients at the times `at`, s: (len(at), names).

    In parts of the true values. It takes the filter's prior and the sensors into account, not its process noise: the
    eddies that a filter assumes are left out.
    """
    steady = BankArrays(vehicle(), dataclasses.replace(ekf.params, turbulence=(0.0,)))
    model, prior = steady.model, steady.prior.copy()
    prior[:MOVING] = setup.std
    found = bounds(
        model,
        true_states(model, flight.x, setup.drift(seed)[:2], true),
        flight.inputs,
        setup.h,
        measurement_mask(len(flight.inputs), setup.h, setup.rates),
        setup.std,
        prior,
        [round(t / setup.h) for t in at],
    )
    part = slice(model.first, model.first + len(ekf.names))
    std: Array = np.sqrt(np.diagonal(found, axis1=1, axis2=2)[:, part])
    return std / np.abs(true_or_believed(true, model.believed)[: len(ekf.names)])


def _square(off: Array, covariance: Array) -> float:
    """off' covariance^-1 off, each state measured against its own sigma first."""
    sigma = np.sqrt(np.diag(covariance))
    scaled = covariance / np.outer(sigma, sigma)
    try:
        return float(off / sigma @ np.linalg.solve(scaled, off / sigma))
    except np.linalg.LinAlgError:
        return math.nan
