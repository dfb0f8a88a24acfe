"""The parameters of the plant as arrays for the kernels; a list of names gives the index of every number."""

from __future__ import annotations

import dataclasses
from collections import namedtuple
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware_py.params import ParamError
from sim_bridge.plant.coefficients import PlantCoefficients, dimensional
from sim_bridge.plant.truth import Truth

Array = NDArray[np.float64]

FOOT = 0.3048


def places(names: str) -> Any:
    """Return a named tuple of the index of each name: `places("a b").b` is 1. A constant inside a kernel."""
    return namedtuple("Places", names)(*range(len(names.split())))


_BODY = ("m", "I_x", "I_y", "I_z", "I_xy", "I_yz", "I_xz", "x_G", "y_G", "z_G", "x_B", "y_B", "z_B", "W", "B")
_HULL = ("L", "radius", "k_y", "k_z")
_PROPELLER = ("advance", "k_thrust", "k_race", "knee", "x_prop", "z_prop", "d_prop")
_ACTUATORS = ("servo_tau", "servo_limit", "shaft_tau", "shaft_rate", "shaft_limit")
_COEFFICIENTS = tuple(field.name for field in dataclasses.fields(PlantCoefficients))

C = places(" ".join((*_BODY, *_HULL, *_PROPELLER, *_ACTUATORS, *_COEFFICIENTS)))
"""Constants of the vehicle; coefficients are dimensional (SI)."""
S = places("x y z e0 e1 e2 e3 u v w p q r n")
"""State: position, attitude quaternion (scalar e0 first), body velocity, shaft; servo and fin angles follow."""
F = places("x y z span to_s to_r to_b effectiveness jammed rate half_play")
"""One row per fin."""


def constants(truth: Truth) -> Array:
    """Return the vector that `C` indexes. Source of the propeller's constants: see `propulsion`."""
    body, hull, propeller = truth.body, truth.hull, truth.propeller
    half_rho, load = 0.5 * hull.rho, 0.5 * propeller.C_t * hull.L**2
    values = {
        **{name: getattr(body, name) for name in _BODY if not name.startswith(("x_", "y_", "z_"))},
        **dict(zip(("x_G", "y_G", "z_G", "x_B", "y_B", "z_B"), (*body.r_G, *body.r_B), strict=True)),
        "L": hull.L,
        "radius": 0.5 * hull.height,
        "k_y": half_rho * hull.C_dy * hull.height,
        "k_z": half_rho * hull.C_dz * hull.width,
        "advance": propeller.eta_n * 60.0 * FOOT,
        "k_thrust": half_rho * hull.L**2 * propeller.C_d0,
        "k_race": load,
        "knee": (1.0 + load) ** 0.5 - 1.0,
        "x_prop": propeller.x,
        "z_prop": propeller.z,
        "d_prop": propeller.diameter,
        "servo_tau": truth.servo.tau,
        "servo_limit": truth.servo.limit,
        "shaft_tau": truth.shaft.tau,
        "shaft_rate": truth.shaft.rate,
        "shaft_limit": truth.shaft.limit,
        **dimensional(truth.coefficients, hull.rho, hull.L),
    }
    return np.array([values[name] for name in C._fields])


def fin_table(truth: Truth) -> Array:
    """Return one row per fin (see `F`), shape (fins, len(F))."""
    servo = (truth.servo.rate, 0.5 * truth.servo.backlash)
    rows = [(*fin.centre, fin.span, *fin.share, fin.effectiveness, 0.0, *servo) for fin in truth.fins]
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(F))


def mass_matrix(truth: Truth) -> Array:
    """Return M = M_RB + M_A, shape (6, 6), about the origin of the body frame (paper's appendix, errata applied).

    Raises:
        ParamError: M is singular, or nearly.
    """
    body = truth.body
    x_G, y_G, z_G = body.r_G
    mx, my, mz = body.m * x_G, body.m * y_G, body.m * z_G
    M = np.array(
        [
            [body.m, 0.0, 0.0, 0.0, mz, -my],
            [0.0, body.m, 0.0, -mz, 0.0, mx],
            [0.0, 0.0, body.m, my, -mx, 0.0],
            [0.0, -mz, my, body.I_x, -body.I_xy, -body.I_xz],
            [mz, 0.0, -mx, -body.I_xy, body.I_y, -body.I_yz],
            [-my, mx, 0.0, -body.I_xz, -body.I_yz, body.I_z],
        ]
    )
    for name, value in dimensional(truth.coefficients, truth.hull.rho, truth.hull.L).items():
        if name.endswith("dot"):
            M["XYZKMN".index(name[0]), "uvwpqr".index(name[2])] -= value
    if not np.linalg.cond(M) < 1e9:
        raise ParamError("the mass matrix is singular: check masses, inertias and added masses")
    return M
