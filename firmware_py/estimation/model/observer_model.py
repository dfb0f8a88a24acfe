"""The observer model of a vehicle: its numbers packed for the kernels, and which of them are states."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.model.equations import AXES, BODY, COEFFICIENTS, CONSTANTS
from firmware_py.estimation.model.jacobians import FACTORS, Array, mass
from firmware_py.estimation.model.prediction import CURRENT, RESPONSE, WORK, flow_of, load, predict, rates
from firmware_py.estimation.model.transition import DRAG, MOVING, WATER, Nine, invert
from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

Floats = Sequence[float] | Array
MOTIONS = ("u", "v", "w", "p", "q", "r", "phi", "theta", "psi")
"""The states that move by themselves."""
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

    The state x, shape (size,): u v w p q r phi theta psi; the water, 0, 2 or 5 numbers (see `prediction`); one number
    for each of `biases`, what a sensor of that moving state reads too much; one for each of `names`, a nondimensional
    coefficient or the scale of a group.
    """

    __slots__ = (
        *("believed", "biases", "c", "first", "heavy", "inverse", "names", "picks", "size"),
        *("water", "weight", "work", "y"),
    )

    def __init__(
        self, vehicle: Vehicle, names: Sequence[str], water: int = CURRENT, biases: Sequence[str] = ()
    ) -> None:
        """Packs the vehicle, with `names` as parameters: any of COEFFICIENTS or GROUPS.

        Raises:
            ParamError: a name is unknown, or occurs twice, or the mass matrix is not positive definite.
        """
        self.names = tuple(names)
        self.water = water
        """How many states the water has: STILL, CURRENT or EDDIES."""
        self.biases = tuple(MOTIONS.index(name) for name in biases)
        """The moving states whose sensors have one."""
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
        """See `prediction.predict`."""
        self.weight = np.array(weights, dtype=np.float64)
        self.heavy = any("dot" in name for name in self.names)
        """Whether the inverse of the mass matrix changes with the state."""
        self.believed = tuple(1.0 if name in GROUPS else float(self.c[CONSTANTS.index(name)]) for name in self.names)
        """The parameters as the vehicle file has them."""
        self.first = MOVING + water + len(self.biases)
        """Place of the first parameter in x."""
        self.size = self.first + len(self.names)
        self.work, self.y = np.zeros(WORK), np.zeros(DRAG + 8)

    def state(self, nu: Floats, angles: Floats) -> Array:
        """A state with the believed parameters in still water, at a velocity (m/s, rad/s) and attitude (rad)."""
        x = np.zeros(self.size)
        x[:MOVING] = (*nu, *angles)
        x[self.first :] = self.believed
        return x

    def place(self, name: str) -> int:
        """Where a moving state or a parameter stands in x."""
        return MOTIONS.index(name) if name in MOTIONS else self.first + self.names.index(name)

    def rates(self, x: Array, inputs: Array) -> Nine:
        """f(x, inputs): the rates of u v w p q r phi theta psi; NaN if the mass matrix has no inverse."""
        if not load(self.c, self.inverse, self.picks, self.weight, self.first, self.heavy, x, np.zeros((6, 6))):
            return (math.nan,) * 9
        u, v, w, p, q, r, phi, theta, psi = x[:MOVING].tolist()
        return rates(self.c, self.inverse, inputs, (u, v, w, p, q, r, phi, theta, psi), flow_of(x, self.water))

    def transition(self) -> Array:
        """Room for the transition matrix's nine rows, shape (9, size)."""
        return np.zeros((MOVING, self.size))

    def predict(self, x: Array, inputs: Array, h: float, Phi: Array) -> bool:
        """Moves x on by h (s), inputs (delta_s, delta_r, delta_b, n) being means over the step; fills Phi, (9, size).

        The rest of the state stays: its rows of the transition matrix would be those of the identity.
        """
        if not self.advance(x, inputs, h):
            return False
        moved, response = self.work[:MOVING], self.work[RESPONSE : RESPONSE + MOVING]
        Phi[:] = 0.0
        Phi[:, :MOVING] = moved[:, :MOVING]
        for j in range(self.water):
            Phi[:, MOVING + j] = moved[:, WATER + (j if j < CURRENT else j - CURRENT)]
        for (i, factor, row, _), weight in zip(self.picks.tolist(), self.weight.tolist(), strict=True):
            Phi[:, self.first + i] += weight * self.y[factor] * response[:, row]
        return True

    def advance(self, x: Array, inputs: Array, h: float) -> bool:
        """As `predict`, but leaves what moves the error where it was made, in `work` and `y`."""
        return predict(
            *(self.c, self.inverse, self.picks, self.weight, self.water, self.first, self.heavy),
            *(inputs, x, h, self.work, self.y),
        )


def constants(vehicle: Vehicle) -> Array:
    """The vector that CONSTANTS names."""
    hull, body, propeller = vehicle.hull, vehicle.body, vehicle.propeller
    L, load = hull.length, 0.5 * propeller.C_t * hull.length**2
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
        **vehicle.force_coefficients,
    }
    return np.array([values[name] for name in CONSTANTS], dtype=np.float64)


def refuse_no_inertia(vehicle: Vehicle) -> None:
    """Raises ParamError if the vehicle's mass matrix is not positive definite."""
    inverse_mass(constants(vehicle))


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
            known = "the names are those of [coefficients], C_d0, C_dy, C_dz, X_dot to N_dot"
            hint = f"did you mean {', '.join(near)}?" if near else known
            raise ParamError(f"no coefficient is called {name!r}; {hint}")
        members.append(GROUPS.get(name, (name,)))
        for member in members[-1]:
            if member in owner:
                twice = (
                    f"{owner[member]!r} and {name!r} both hold {member}" if owner[member] != name else f"{name!r} twice"
                )
                raise ParamError(f"{twice}; name every coefficient once")
            owner[member] = name
    return members
