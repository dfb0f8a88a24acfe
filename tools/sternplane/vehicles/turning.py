"""How the simulated vehicle turns, beside what guidance asks for and what the laws are designed from."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np

from firmware_py.control.control import LawKind
from firmware_py.control.sliding_mode_design import sliding_surface
from firmware_py.number_text import signed
from firmware_py.records.manoeuvrability import Manoeuvrability
from firmware_py.vehicle.linear_models import steering_model
from sim_bridge.plant.plant_error import PlantError
from sim_bridge.plant.truth import Truth
from sternplane.vehicles.finding import Finding, Grade, graded
from sternplane.vehicles.limits import Files
from sternplane.vehicles.swum import Turn, steady_turn

_RUDDERS = 5
_BELIEF = 1.25
"""Radius by the vehicle file over that which is swum, or the reverse, from which on it is told."""
_LAG = math.radians(15.0)
"""Heading behind its reference in a long turn that is told."""


def turns_of(files: Files, cruise: float) -> dict[float, Turn]:
    """Return the turns of the simulated vehicle at cruising speed, by rudder angle, rad, up to its travel."""
    propeller, most = files.vehicle.propeller, files.vehicle.effectiveness.delta_r_max
    limit = min(most, math.pi / 4)
    n = propeller.n_trim * cruise / propeller.u_trim
    angles = np.linspace(limit / _RUDDERS, limit, _RUDDERS).tolist()
    return {angle: steady_turn(files.truth, angle, n, cruise) for angle in angles}


def judged(files: Files, turns: dict[float, Turn], able: Manoeuvrability) -> Iterator[Finding]:
    """Yield whether it turns as guidance asks and as the laws expect.

    Args:
        files: see `read_files`.
        turns: see `turns_of`.
        able: what the vehicle file can do.
    """
    guidance = files.autopilot.guidance
    full, turn = max(turns.items())
    if turn.diverged:
        yield Finding("turn", Grade.WARN, f"with {math.degrees(full):.0f} deg of rudder no steady turn is reached")
        return
    if math.isinf(turn.radius):
        said = f"{math.degrees(full):.0f} deg of rudder does not turn it: check N_dr, Y_dr and shares of truth.toml"
        yield Finding("turn", Grade.FAIL, said)
        return
    port = "to port" if turn.rate < 0.0 else "TO STARBOARD: a positive rudder must turn to port"
    text = f"{math.degrees(full):.0f} deg of rudder turns {port}, radius {turn.radius:.1f} m at {turn.speed:.2f} m/s"
    text += f"; guidance.turn_radius_m = {guidance.turn_radius:g}"
    if turn.rate > 0.0:
        yield Finding("turn", Grade.FAIL, text)
    else:
        mend = "over 0.7 of it, fins that are weaker or a current leave no circle: raise guidance.turn_radius_m to "
        mend += f"{turn.radius / 0.7:.1f}"
        yield graded("turn", turn.radius / guidance.turn_radius, 0.7, 1.0, text, mend)
    asked, does = math.degrees(guidance.turn_rate_max), math.degrees(abs(turn.rate))
    text = f"guidance.turn_rate_max_deg_s = {asked:g}; full rudder turns {does:.1f} deg/s at cruising speed"
    mend = f"more than 0.8 of that leaves the law little rudder: lower guidance.turn_rate_max_deg_s to {0.8 * does:.1f}"
    yield graded("turn rate", asked / does, 0.8, 1.0, text, mend)
    text = f"rolls {math.degrees(turn.roll):.0f} deg in that turn, drift {signed(math.degrees(turn.drift), '.0f')} deg"
    mend = "beyond 20 deg rudders dive and planes turn: lower guidance.turn_rate_max_deg_s, or check z_G and K_p"
    yield graded("roll in turn", turn.roll, math.radians(20.0), math.radians(45.0), text, mend)
    yield from _lag(files, turns)
    yield from _belief(files, turns, able)


def _lag(files: Files, turns: dict[float, Turn]) -> Iterator[Finding]:
    """Yield by how much the heading lags in a long turn, where the hull takes more rudder than the linear model says.

    The sliding law keeps s'(x - x_d) at 0. It takes v and v_d from the linear model, under the rudder that is set and
    that of the feed-forward: what cross-flow drag adds to the rudder counts as sway, and the heading gives way for it.
    """
    autopilot, vehicle = files.autopilot, files.vehicle
    if autopilot.control.law is not LawKind.SLIDING:
        return
    cruise = autopilot.guidance.cruise_speed
    curvature = min(1.0 / autopilot.guidance.turn_radius, autopilot.guidance.turn_rate_max / cruise)
    swum = np.maximum.accumulate([0.0, *(1.0 / turn.radius for turn in turns.values())])
    taken = float(np.interp(curvature, swum, [0.0, *turns]))
    model, r = steering_model(vehicle, cruise), -cruise * curvature
    ((a_vv, a_vr, _), (a_rv, a_rr, _), _), (b_v, b_r, _) = model
    matrix = np.array([[a_vv, b_v], [a_rv, b_r]])
    if not a_vv < 0.0 or abs(np.linalg.det(matrix)) < 1e-12 * abs(matrix).max() ** 2:
        return
    believed = float(np.linalg.solve(matrix, [-a_vr * r, -a_rr * r])[1])
    scale = cruise / vehicle.propeller.u_trim
    p1, p2 = autopilot.control.poles[1]
    s, _, _ = sliding_surface(model, (p1 * scale, p2 * scale), 1.0)
    behind = abs(s[0] * b_v * (taken - believed) / a_vv)
    angles = f"{math.degrees(taken):.1f} deg of rudder, by the linear model {math.degrees(believed):.1f} deg"
    text = (
        f"turns of {1.0 / curvature:.1f} m take {angles}: in long ones heading is {math.degrees(behind):.0f} deg behind"
    )
    mend = "the sliding law takes the difference for sway, more so with faster poles; "
    mend += f'drag across the hull makes it, C_dy = {files.truth.hull.C_dy:g}: measure it, or fly control.law = "pid"'
    yield graded("heading in turns", behind, _LAG, math.inf, text, mend)


def _belief(files: Files, turns: dict[float, Turn], able: Manoeuvrability) -> Iterator[Finding]:
    """Yield whether the circles that are asked for can be swum, and whether the vehicle file believes in like ones."""
    full, turn = max(turns.items())
    propeller, cruise = files.vehicle.propeller, files.autopilot.guidance.cruise_speed
    n = propeller.n_trim * cruise / propeller.u_trim
    try:
        believed = steady_turn(_as_believed(files), full, n, cruise)
    except PlantError:
        yield Finding("belief", Grade.WARN, "with the coefficients of vehicle.toml the simulated hull cannot be swum")
        return
    off = max(turn.radius, believed.radius) / min(turn.radius, believed.radius)
    text = f"full rudder swims {turn.radius:.1f} m, with the coefficients of vehicle.toml {believed.radius:.1f} m"
    if math.isfinite(able.turn):
        asked = max(files.autopilot.guidance.turn_radius, able.turn_radius)
        text = f"circles asked for are {asked:.1f} m or wider; {text}, by its linear model {1.0 / able.turn:.1f} m"
        wide = graded("belief", turn.radius / asked, 1.0, 1.5, text)
        if wide.grade is not Grade.PASS:
            yield wide
            return
        if 1.0 / able.turn > _BELIEF * turn.radius:
            yield Finding("belief", Grade.WARN, f"{text}, which the laws are made from: check L and N_dr of both files")
            return
    if off > _BELIEF and not believed.diverged:
        text += "; N_v, N_r, Y_v, Y_r or N_dr of vehicle.toml and truth.toml are of two hulls"
    yield graded("belief", 1.0 if believed.diverged else off, _BELIEF, math.inf, text)


def _as_believed(files: Files) -> Truth:
    """Return the simulated vehicle with the coefficients of the vehicle file."""
    own = dataclasses.asdict(files.vehicle.coefficients)
    return dataclasses.replace(files.truth, coefficients=dataclasses.replace(files.truth.coefficients, **own))
