"""True motion of the plant as frames: what a vehicle hears in flight, tick by tick."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np
from sternplane.sitl.busless_flight import N_TRIM, SENSOR_STD, BuslessFlight, Current, fly, held_level, measure

from firmware_py.estimation.coefficient_estimator import CoefficientEstimator
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.coefficient_validity import ValidityParams
from firmware_py.estimation.learning_params import LearningParams
from firmware_py.marine import Eta, Nu
from firmware_py.records.command import Applied
from firmware_py.records.estimate import Learned, StateEstimate
from firmware_py.records.sensing import Ahrs, Dvl, Heard, SensorFrame, silence
from firmware_py.tick import Tick

from .cases import TRUTH, VEHICLE

DT = 0.01


class Moment(NamedTuple):
    """What one tick hands to the estimator."""

    tick: Tick
    frame: SensorFrame
    applied: Applied
    state: StateEstimate

    @property
    def t(self) -> float:
        return self.tick.t


@functools.cache
def flown(
    seconds: float = 40.0,
    delta_s: float = 0.12,
    delta_r: float = 0.12,
    current: Current | Callable[[float], Current] = (0.0, 0.0, 0.0),
    x_G: float = 0.0,
) -> BuslessFlight:
    """Both planes swing at three frequencies each, the vehicle held about its depth; seconds long.

    Its centre of gravity is x_G forward, m, of where the vehicle file has it.
    """
    truth = dataclasses.replace(TRUTH, body=dataclasses.replace(TRUTH.body, r_G=(x_G, *TRUTH.body.r_G[1:])))
    t = DT * (np.arange(round(seconds / DT)) + 0.5)

    def swing(*periods: float) -> np.ndarray:
        return sum(np.sin(math.tau * t / period) for period in periods) / len(periods)

    demands = np.column_stack((delta_s * swing(3.1, 5.3, 1.7), delta_r * swing(4.1, 7.3, 2.3)))
    return fly(truth, demands, N_TRIM, DT, current=current, hold=held_level() if delta_s else None)


def moments(
    trial: BuslessFlight, noise: float = 1.0, dvl_late: int = 0, ahrs_late: int = 0, fins_late: int = 0, seed: int = 1
) -> list[Moment]:
    """The flight as it is heard: gyros and attitude at 100 Hz, the DVL at 5 Hz, fins and shaft at 100 Hz, so late.

    Fins report the mean of each step as valid at its middle. `noise` scales that of the sensors.
    """
    rates = [5.0] * 3 + [100.0] * 6
    z = measure(trial, noise * SENSOR_STD, rates, seed)
    state = StateEstimate(Eta(*[0.0] * 6), Nu(*[0.0] * 6), 1.0, 0.03, 0.01, math.nan, True, True, True, False)
    frame = silence(len(VEHICLE.fins))
    heard = []
    for k in range(len(z)):
        frame = quiet(frame)
        if k >= ahrs_late:
            p, q, r, phi, theta, psi = z[k - ahrs_late, 3:].tolist()
            frame = hears(frame, ahrs=Heard(Ahrs(phi, theta, psi, p, q, r), time(k - ahrs_late), True, True))
        if k >= dvl_late and not math.isnan(z[k - dvl_late, 0]):
            ping = Dvl(*z[k - dvl_late, :3].tolist(), math.nan, 50.0)
            frame = hears(frame, dvl=Heard(ping, time(k - dvl_late), True, True))
        if k >= fins_late:
            delta_s, delta_r, _, n = trial.inputs[k - fins_late].tolist()
            middle = time(k - fins_late) - 0.5 * DT
            fins = tuple(Heard(angle, middle, True, True) for angle in (delta_s, delta_s, delta_r, delta_r))
            frame = hears(frame, fins=fins, n=Heard(n, middle, True, True))
        angle_s, angle_r, _, n = trial.inputs[k].tolist()
        told = Applied((angle_s, angle_s, angle_r, angle_r), n, True, False)
        eta = Eta(*trial.eta[k + 1].tolist())
        heard.append(Moment(Tick(k + 1, 10_000_000), frame, told, dataclasses.replace(state, eta=eta)))
    return heard


def time(k: int) -> float:
    """When step k ends, s: as ticks count it."""
    return Tick(k + 1, 10_000_000).t


def quiet(frame: SensorFrame) -> SensorFrame:
    """The frame in the tick after: nothing is fresh."""
    old = {name: dataclasses.replace(getattr(frame, name), fresh=False) for name in ("ahrs", "dvl", "n")}
    return hears(frame, **old, fins=tuple(dataclasses.replace(fin, fresh=False) for fin in frame.fins))


def hears(frame: SensorFrame, **changes: object) -> SensorFrame:
    return dataclasses.replace(frame, **changes)


def deaf(moments: Iterable[Moment], sensor: str, begin: float, end: float) -> Iterator[Moment]:
    """The same, but a sensor ("dvl", "ahrs") says nothing from begin to end, s; navigation misses its attitude."""
    last = None
    for moment in moments:
        if begin <= moment.t < end:
            frame = hears(moment.frame, **{sensor: dataclasses.replace(last, fresh=False)})
            lost = sensor == "ahrs" and moment.t - last.t_valid > 0.5
            yield moment._replace(frame=frame, state=dataclasses.replace(moment.state, attitude_ok=not lost))
        else:
            last = getattr(moment.frame, sensor)
            yield moment


def learner(
    params: LearningParams | None = None, health: ValidityParams | None = None, **coefficients: object
) -> CoefficientEstimator:
    return CoefficientEstimator(
        params or LearningParams(), CoefficientParams(**coefficients), health or ValidityParams(), VEHICLE
    )


def said(learning: CoefficientEstimator, moments: Iterable[Moment]) -> list[Learned]:
    """What it says after each tick."""
    return [learning.update(*moment) for moment in moments]
