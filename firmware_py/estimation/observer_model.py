"""The observer model of a vehicle: its numbers packed for the kernels, and which of them are states."""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.jacobians import FACTORS, Array, mass
from firmware_py.estimation.model import AXES, BODY, COEFFICIENTS, CONSTANTS
from firmware_py.estimation.prediction import WORK, load, predict, rates
from firmware_py.estimation.transition import DRAG, MOVING, Nine, invert
from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

C_T = 0.008
"""Thrust loading of the propeller, C_t = C_T L^2 eta|eta| / 2 with L in m (Healey and Lienard 1993)."""
GROUPS = {
    f"{axis}_dot": tuple(name for name in COEFFICIENTS if name.startswith(f"{axis}_") and name.endswith("dot"))
    for axis in AXES
}
"""One scale, 1 as believed, for all added mass of an equation: estimated in the place of its members."""
_PLACES = {
    **{name: ((i, row),) for i, (name, row) in enumerate(FACTORS)},
    **{
        name: tuple((DRAG + 4 * i + j, row) for j, row in enumerate((1, 2, 4, 5)))
        for i, name in enumerate(("C_dy", "C_dz"))
    },
}
"""Where the forces that a coefficient multiplies lie in y, and the equations they act in."""


class ObserverModel:
    """x_dot = f(x, inputs) of one vehicle. Kernels read its arrays; it is no more than their keeper.

    The state x, shape (size,): u v w p q r phi theta psi, one number for each of `names` (a nondimensional coefficient,
    or the scale of a group), then, with `current`, the water's speed north and east.
    """

    __slots__ = ("believed", "c", "heavy", "inverse", "names", "picks", "size", "weight", "work", "y")

    def __init__(self, vehicle: Vehicle, names: Sequence[str], current: bool = True) -> None:
        """Packs the vehicle, with `names` as parameters to be estimated: any of COEFFICIENTS or GROUPS.

        Raises:
            ParamError: a name is unknown, or occurs twice, or the mass matrix is not positive definite.
        """
        self.names = tuple(names)
        self.c = constants(vehicle)
        """Constants, shape (len(CONSTANTS),)."""
        self.inverse = inverse_mass(self.c)
        """Inverse of the mass matrix, (6, 6)."""
        rows, weights = [], []
        for i, members in enumerate(_members(self.names)):
            for member in members:
                place = CONSTANTS.index(member)
                weight = 1.0 if member == self.names[i] else float(self.c[place])
                for factor, row in _PLACES[member]:
                    rows.append((i, factor, row, place))
                    weights.append(weight)
        self.picks = np.array(rows, dtype=np.int64).reshape(len(rows), 4)
        """See `transition.transition`."""
        self.weight = np.array(weights, dtype=np.float64)
        self.heavy = any("dot" in name for name in self.names)
        """Whether the inverse of the mass matrix changes with the state."""
        self.believed = tuple(1.0 if name in GROUPS else float(self.c[CONSTANTS.index(name)]) for name in self.names)
        """The parameters as the vehicle file has them."""
        self.size = MOVING + len(self.names) + (2 if current else 0)
        self.work, self.y = np.zeros(WORK), np.zeros(DRAG + 8)

    def state(self, nu: Sequence[float], angles: Sequence[float]) -> Array:
        """A state with the believed parameters and no current, at a velocity (m/s, rad/s) and attitude (rad)."""
        x = np.zeros(self.size)
        x[: MOVING + len(self.names)] = (*nu, *angles, *self.believed)
        return x

    def rates(self, x: Array, inputs: Array) -> Nine:
        """f(x, inputs): the rates of u v w p q r phi theta psi; NaN if the mass matrix has no inverse."""
        if not load(self.c, self.inverse, self.picks, self.weight, self.heavy, x, np.zeros((6, 6))):
            return (math.nan,) * 9
        x_c, y_c = x[MOVING + len(self.names) :] if self.size > MOVING + len(self.names) else (0.0, 0.0)
        u, v, w, p, q, r, phi, theta, psi = x[:MOVING].tolist()
        return rates(self.c, self.inverse, inputs, (u, v, w, p, q, r, phi, theta, psi), x_c, y_c)

    def transition(self) -> Array:
        """Room for the transition matrix's nine rows, shape (9, size)."""
        return np.zeros((MOVING, self.size))

    def predict(self, x: Array, inputs: Array, h: float, Phi: Array) -> bool:
        """Moves x on by h (s), inputs (delta_s, delta_r, delta_b, n) being means over the step; see `prediction`."""
        return predict(
            *(self.c, self.inverse, self.picks, self.weight, len(self.names), self.heavy),
            *(inputs, x, h, Phi, self.work, self.y),
        )


def constants(vehicle: Vehicle) -> Array:
    """The vector that CONSTANTS names."""
    hull, body, propeller = vehicle.hull, vehicle.body, vehicle.propeller
    L, load = hull.length, 0.5 * C_T * hull.length**2
    long = {"m": "mass", "W": "weight", "B": "buoyancy"}
    values = {
        **{name: getattr(body, long.get(name, name)) for name in BODY},
        "scale": 0.5 * hull.density * L**2,
        "L": L,
        "h_y": hull.height / L**2,
        "h_z": hull.width / L**2,
        "advance": propeller.u_trim / propeller.n_trim,
        "k_race": load,
        "knee": math.sqrt(1.0 + load) - 1.0,
        **dataclasses.asdict(vehicle.coefficients),
        "C_d0": propeller.C_d0,
        "C_dy": hull.C_dy,
        "C_dz": hull.C_dz,
    }
    return np.array([values[name] for name in CONSTANTS], dtype=np.float64)


def inverse_mass(c: Array) -> Array:
    """The inverse of the mass matrix, shape (6, 6).

    Raises:
        ParamError: the matrix, or its symmetric part, is not positive definite.
    """
    M, inverse = np.zeros((6, 6)), np.zeros((6, 6))
    mass(c, M)
    least, modes = np.linalg.eigh(0.5 * (M + M.T))
    if not least[0] > 0.0:
        worst = "uvwpqr"[int(np.argmax(np.abs(modes[:, 0])))]
        raise ParamError(
            f"body, coefficients: the mass matrix is not positive definite, first in {worst}_dot; mass, inertia "
            "or the added mass there has the wrong sign or size (added mass is negative on the diagonal)"
        )
    invert(M, inverse)
    return inverse


def _members(names: tuple[str, ...]) -> list[tuple[str, ...]]:
    """The coefficients behind each name, no coefficient twice."""
    owner: dict[str, str] = {}
    members = []
    for name in names:
        if name not in COEFFICIENTS and name not in GROUPS:
            near = difflib.get_close_matches(name, (*COEFFICIENTS, *GROUPS), 3, 0.5)
            hint = f"did you mean {', '.join(near)}?" if near else "write names as in [coefficients], C_d0, C_dy, C_dz"
            raise ParamError(f"estimated: no coefficient is called {name!r}; {hint}")
        members.append(GROUPS.get(name, (name,)))
        for member in members[-1]:
            if member in owner:
                twice = (
                    f"{owner[member]!r} and {name!r} both hold {member}" if owner[member] != name else f"{name!r} twice"
                )
                raise ParamError(f"estimated: {twice}; name every coefficient once")
            owner[member] = name
    return members
