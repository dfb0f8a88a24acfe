"""Fig. 3 to 7 and Table 1: one motion, and what the extended Kalman filter and the sliding-mode observer make of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import STILL
from firmware_py.guidance.excitation import opposite, prbs
from firmware_py.marine import Nu
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.plant.truth import Truth
from sternplane.logs.tracking import Array
from sternplane.paper.design import with_values
from sternplane.paper.printed import TABLE_1
from sternplane.paper.sliding_mode_observer import SlidingModeObserver, SmoParams
from sternplane.sitl.busless_flight import N_TRIM, SENSOR_STD, BuslessFlight, Start, fly, held_level

H = 0.01
"""Step of plant and estimators, s."""
LENGTH = 60.0
"""Of the scenario, s: the paper does not say. Speeds and rates are then within 2 % of where they stay."""
ANGLE, SPEED = math.radians(20.0), 1.8
"""In the paper: rudder and elevator, rad, and the speed at the start, m/s."""
SHARE = 0.5
"""Where the estimates begin, as a share of the true values; the paper does not say."""
SHARES = (0.5, 0.8, 1.2, 1.5)
"""Other beginnings, to show what they do to the result."""
EXCITED, CLOCK, AMPLITUDE = 120.0, 4.0, math.radians(15.0)
"""The excited motion: its length and the PRBS's clock, s, and its fin angle, rad."""
STD = 0.1 * SENSOR_STD
"""What the filter is given as the noise of measurements that have none: a tenth of the sensors'."""
EQUATIONS = {"M": 4, "N": 5, "Z": 2, "Y": 1}
"""The four equations with estimated coefficients, by their place in the force."""


class EstimatorRun(NamedTuple):
    """What an estimator went through.

    Attributes:
        t: (K,), s, the start included.
        values: of the ten, (K, 10).
        errors: of the ten at the end, % of the true values, signed.
    """

    t: Array
    values: Array
    errors: dict[str, float]


class Plane(NamedTuple):
    """Where an estimate lies in an equation, by forces in N or N m.

    Attributes:
        sum: error of the equation's force at the end: 0 is on the hyperplane.
        parts: coefficient -> error of its own force.
    """

    sum: float
    parts: dict[str, float]

    @property
    def share(self) -> float:
        """The sum over the greatest part."""
        return abs(self.sum) / max(map(abs, self.parts.values()))


class Estimation(NamedTuple):
    """All of section 2: motions, estimates, and where on their hyperplanes they lie.

    Attributes:
        flight: the scenario.
        excited: the motion under PRBS.
        learned: "ekf", "smo", "smo_weighted" on the scenario; "ekf_prbs", "smo_prbs" (weighted) on the other motion.
        planes: "smo" and "begin" -> equation -> where; and "paper": the share of the greatest part that remains of the
            sum with Table 1's errors under the most favourable signs.
        starts: estimator -> share of the true values at the start -> errors, %.
        nose: |pitch| that elevator alone comes to, rad, and when, s.
    """

    flight: BuslessFlight
    excited: BuslessFlight
    learned: dict[str, EstimatorRun]
    planes: dict[str, dict[str, Plane]]
    paper: dict[str, dict[str, float]]
    starts: dict[str, dict[float, dict[str, float]]]
    nose: tuple[float, float]


def estimate(truth: Truth, vehicle: Vehicle, done: Callable[[str], None]) -> Estimation:
    """Flies the motions and lets the estimators look at them.

    Args:
        truth: the simulated vehicle.
        vehicle: the vehicle file that is right.
        done: told what is done.
    """
    flight = scenario(truth, ANGLE, ANGLE, LENGTH)
    alone = scenario(truth, ANGLE, 0.0, 2.0 * LENGTH)
    excited = prbs_motion(truth)
    done("the motions")
    constant, weighted = SmoParams(), SmoParams(weighted=True)
    learned = {
        "ekf": with_ekf(vehicle, flight, SHARE),
        "smo": with_smo(vehicle, flight, SHARE, constant),
        "smo_weighted": with_smo(vehicle, flight, SHARE, weighted),
        "ekf_prbs": with_ekf(vehicle, excited, SHARE),
        "smo_prbs": with_smo(vehicle, excited, SHARE, weighted),
    }
    done("the estimates")
    starts = {
        "ekf": {share: with_ekf(vehicle, flight, share).errors for share in SHARES},
        "smo": {share: with_smo(vehicle, flight, share, constant).errors for share in SHARES},
        "smo_prbs": {share: with_smo(vehicle, excited, share, weighted).errors for share in SHARES},
    }
    done("other starts")
    planes = {
        "begin": plane(vehicle, flight, dict.fromkeys(TEN, 100.0 * (SHARE - 1.0))),
        "smo": plane(vehicle, flight, learned["smo"].errors),
    }
    paper = {who: nearest(vehicle, flight, TABLE_1[who]) for who in ("smo", "ekf")}
    steepest = int(np.argmax(np.abs(alone.x[:, 7])))
    nose = (float(abs(alone.x[steepest, 7])), float(alone.t[steepest]))
    return Estimation(flight, excited, learned, planes, paper, starts, nose)


def scenario(truth: Truth, delta_s: float, delta_r: float, length: float) -> BuslessFlight:
    """The paper's motion: fins put over (rad) from the start, the propeller as in trim."""
    demands = np.tile((delta_s, delta_r), (round(length / H), 1))
    return fly(truth, demands, N_TRIM, H, start=Start(nu=Nu(SPEED, 0.0, 0.0, 0.0, 0.0, 0.0)))


def prbs_motion(truth: Truth) -> BuslessFlight:
    """Both fins under a PRBS half a period apart; depth and pitch are held softly, so that it stays in the sea."""
    steps = round(CLOCK / H)
    sides = [(prbs(k, steps, 1), prbs(k, steps, opposite(1))) for k in range(round(EXCITED / H))]
    return fly(truth, AMPLITUDE * np.array(sides), N_TRIM, H, hold=held_level())


def with_ekf(vehicle: Vehicle, flight: BuslessFlight, share: float) -> EstimatorRun:
    """The filter that flies, in still water as the paper's; its vehicle file has `share` of the true ten."""
    ekf = CoefficientEkf(_wrong(vehicle, share), CoefficientParams(current=False))
    ekf.start(flight.x[0, :6].tolist(), flight.x[0, 6:].tolist(), STD.tolist())
    history = ekf.run(H, flight.inputs, np.ascontiguousarray(flight.x[1:]), STD**2)
    return _learned(vehicle, flight, share, history.x[:, ekf.model.first :])


def with_smo(vehicle: Vehicle, flight: BuslessFlight, share: float, params: SmoParams) -> EstimatorRun:
    """The observer, in the same way."""
    smo = SlidingModeObserver(_wrong(vehicle, share), params)
    smo.start(flight.x[0, :6].tolist(), flight.x[0, 6:].tolist())
    history = smo.run(H, flight.inputs, np.ascontiguousarray(flight.x[1:]))
    return _learned(vehicle, flight, share, history.x[:, smo.model.first :])


def plane(vehicle: Vehicle, flight: BuslessFlight, errors: Mapping[str, float]) -> dict[str, Plane]:
    """What errors of coefficients, %, come to in each equation's force at the end of a motion."""
    model = ObserverModel(vehicle, TEN, STILL)
    model.advance(model.state(flight.x[-1, :6].tolist(), flight.x[-1, 6:].tolist()), flight.inputs[-1], 1e-9)
    forces, parts = model.unit_forces().tolist(), {}
    for axis, equation in EQUATIONS.items():
        own = [(i, name) for i, name in enumerate(TEN) if name.startswith(axis)]
        parts[axis] = {name: forces[equation][i] * model.believed[i] * 0.01 * errors[name] for i, name in own}
    return {axis: Plane(sum(part.values()), part) for axis, part in parts.items()}


def nearest(vehicle: Vehicle, flight: BuslessFlight, table: Mapping[str, float]) -> dict[str, float]:
    """How near errors without signs, %, can lie to the hyperplane of each equation: the least `Plane.share`."""
    found = {}
    for name, at in plane(vehicle, flight, table).items():
        sizes = list(at.parts.values())
        sums = [abs(sum(_signed(sizes, signs))) for signs in range(2 ** len(sizes))]
        found[name] = min(sums) / max(map(abs, sizes))
    return found


def document(found: Estimation) -> dict[str, Any]:
    """For results.json: Table 1 as in the paper (without signs), and what stands behind it."""
    unsigned = {name: {k: abs(v) for k, v in one.errors.items()} for name, one in found.learned.items()}
    return {
        "table1": {"ekf": unsigned["ekf"], "smo": unsigned["smo"], "paper": TABLE_1},
        "table1_signed": {name: found.learned[name].errors for name in ("ekf", "smo")},
        "table1_weighted": {"scenario": unsigned["smo_weighted"], "prbs": unsigned["smo_prbs"]},
        "table1_ekf_prbs": unsigned["ekf_prbs"],
        "starts": {who: {f"{s:g}": e for s, e in by_share.items()} for who, by_share in found.starts.items()},
        "hyperplane": {
            who: {name: {"sum": at.sum, "parts": at.parts, "share": at.share} for name, at in planes.items()}
            for who, planes in found.planes.items()
        },
        "hyperplane_paper": found.paper,
        "scenario": {
            "length_s": LENGTH,
            "step_s": H,
            "start_share": SHARE,
            "told_noise": {"m_s": STD[0], "deg_s": math.degrees(STD[3]), "deg": math.degrees(STD[6])},
            "prbs": {"length_s": EXCITED, "clock_s": CLOCK, "amplitude_deg": math.degrees(AMPLITUDE)},
            "elevator_alone": {"pitch_deg": math.degrees(found.nose[0]), "at_s": found.nose[1]},
        },
        "ok": {
            "ekf": under(found.learned["ekf"], "ekf"),
            "smo_weighted_prbs": under(found.learned["smo_prbs"], "smo"),
        },
    }


def under(learned: EstimatorRun, column: str) -> bool:
    """Whether every row is at or under the paper's."""
    return all(abs(learned.errors[name]) <= limit for name, limit in TABLE_1[column].items())


def _wrong(vehicle: Vehicle, share: float) -> Vehicle:
    return with_values(vehicle, {name: share * getattr(vehicle.coefficients, name) for name in TEN})


def _learned(vehicle: Vehicle, flight: BuslessFlight, share: float, values: Array) -> EstimatorRun:
    true = np.array([getattr(vehicle.coefficients, name) for name in TEN])
    errors = 100.0 * (values[-1] / true - 1.0)
    return EstimatorRun(flight.t, np.vstack((share * true, values)), dict(zip(TEN, errors.tolist(), strict=True)))


def _signed(sizes: list[float], signs: int) -> list[float]:
    return [-size if signs >> i & 1 else size for i, size in enumerate(sizes)]
