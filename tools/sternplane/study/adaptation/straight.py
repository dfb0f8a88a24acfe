"""Straight ahead for an hour: what was learned in manoeuvres does not drift away where nothing tells of it."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import numpy as np

from firmware_py import config_files
from firmware_py.control.sliding_mode_design import design_sliding_mode
from firmware_py.control.sliding_mode_params import S_LAST_DEPTH, S_LAST_HEADING, SlidingGains
from firmware_py.records.cycle import Cycle
from firmware_py.vehicle.linear_models import (
    DivingCoefficients,
    LinearModel,
    SteeringCoefficients,
    diving_model,
    steering_model,
)
from sim_bridge.truth_sample import TruthSample
from sternplane.logs.tracking import Array
from sternplane.sitl.request import parse_settings
from sternplane.study.adaptation.courses import track
from sternplane.study.adaptation.flight import Course, Witness, flown_as
from sternplane.study.laid_settings import settings_now
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import CONFIG, starts, vehicle
from sternplane.study.wrong_vehicle import coefficients

WRONG, LEARNS = 0.5, 120.0
"""How far off the file is, and for how long the track teaches, s."""
MOVES = 0.02
"""What coefficients and gains may move by in the hour."""
_COEFFICIENTS, _GAINS = len(DivingCoefficients._fields) + len(SteeringCoefficients._fields), 6
_SWAY = 3
"""Of the six gains, the one of sway: k and the slope of the switching term all but cancel there."""
_SETTLES = 20.0
"""After the last turn, s."""


class AdoptionWitness(Witness):
    """Takes down, once a second from a time on, the coefficients that are in force."""

    def __init__(self, begin: float) -> None:
        super().__init__()
        self._next = begin
        self.in_force: list[tuple[float, ...]] = []

    def see(self, cycle: Cycle, truth: TruthSample) -> None:
        """Take one cycle and the truth at its tick."""
        super().see(cycle, truth)
        if cycle.tick.t >= self._next:
            self._next += 1.0
            self.in_force.append((*cycle.adopted.diving, *cycle.adopted.steering))


def straight(duration: float) -> Course:
    """Return the track for `LEARNS`, and then a straight line, s."""
    learning = track(LEARNS)
    text = learning.scenario.replace(f"duration_s = {LEARNS}", f"duration_s = {LEARNS + duration}", 1)
    text += f"[[orders]]\nt_s = {LEARNS}\ndepth_m = 10.0\nheading_deg = 0.0\n"
    return Course("straight", text, LEARNS + _SETTLES)


def _layer_gains(coefficients: Sequence[float]) -> Array:
    """Return the fin angle per state within the boundary layers, of depth and of heading, at the trim speed."""
    believed, u = vehicle(), vehicle().propeller.u_trim
    control = config_files.autopilot_params(
        config_files.read_configuration(CONFIG, settings=parse_settings(settings_now()))
    ).control

    def gains(model: LinearModel, law: SlidingGains, s_last: float) -> list[float]:
        design = design_sliding_mode(model, law.poles, s_last, law.delta_sw, law.phi_b)
        return [k + law.bandwidth * s / design.s_b for k, s in zip(design.k, design.s, strict=True)]

    diving = diving_model(believed, u, DivingCoefficients(*coefficients[:2]))
    steering = steering_model(believed, u, SteeringCoefficients(*coefficients[2:]))
    return np.array(
        gains(diving, control.depth, S_LAST_DEPTH) + gains(steering, control.heading, S_LAST_HEADING),
    )


def _run(seed: int, k: int, duration: float) -> RunArrays:
    del k
    course = straight(duration)
    witness = AdoptionWitness(course.settled)
    errors = flown_as(course, seed, coefficients(starts(seed, WRONG)), adoption=True, witness=witness)
    figures = errors.figures(course.settled)
    found = {
        "failed": np.array(float(errors.failed)),
        "errors": np.array([figures["depth"], figures["heading"]]),
    }
    if not witness.in_force:  # the flight ended while it still learned: it meets no target
        return found | {"coefficients": np.full(_COEFFICIENTS, math.inf), "gains": np.full(_GAINS, math.inf)}
    in_force = np.array(witness.in_force)
    gains = np.array([_layer_gains(row) for row in in_force[:: max(len(in_force) // 100, 1)].tolist()])
    return found | {
        "coefficients": np.max(np.abs(in_force / in_force[0] - 1.0), axis=0),
        "gains": np.max(np.abs(gains / gains[0] - 1.0), axis=0),
    }


def _evaluate(runs: Sequence[RunArrays], name: str) -> Results:
    n = len(runs)
    if not n:
        return Results(())
    names = (*DivingCoefficients._fields, *SteeringCoefficients._fields)
    moved = np.max([run["coefficients"] for run in runs], axis=0)
    gains = np.max([run["gains"] for run in runs], axis=0)
    rows = [
        Row(name, "failed flights", float(np.sum([run["failed"] for run in runs])), 0.0, n),
        Row(name, "coefficients in force: most that one moves, worst flight", float(np.max(moved)), MOVES, n),
        Row(name, "gains: most that one moves, worst flight", float(np.max(np.delete(gains, _SWAY))), MOVES, n),
        Row(name, "gain of sway, a difference of two: moves, worst flight", float(gains[_SWAY]), None, n),
        *(Row(name, f"{one} moves, worst flight", float(x), None, n) for one, x in zip(names, moved, strict=True)),
    ]
    for i, (quantity, unit) in enumerate((("depth", "m"), ("heading", "deg"))):
        worst = max(float(run["errors"][i]) for run in runs)
        rows.append(Row(name, f"{quantity} RMS, worst flight, {unit}", worst, None, n))
    return Results(rows)


def _case(name: str, duration: float, runs: int, short: int) -> Case:
    return Case(
        name,
        f"Coefficients 50 % wrong, {LEARNS:g} s of the track to learn them, then a straight line in a current of "
        "0.1 m/s: how far what is in force moves from what it was when the vehicle was steady on the line, as a part "
        "of it. Gains: fin angle per state within the boundary layers.",
        functools.partial(_run, duration=duration),
        functools.partial(_evaluate, name=name),
        runs,
        short,
    )


CASES = (_case("five minutes straight", 300.0, 40, 1), _case("one hour straight", 3600.0, 4, 0))
