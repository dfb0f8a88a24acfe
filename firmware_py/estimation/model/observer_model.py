"""The observer model of a vehicle: its numbers packed for the kernels, and which of them are states."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence

import numpy as np

from firmware_py.error_text import quoted, shortened
from firmware_py.estimation.model.equations import AXES, BODY, COEFFICIENTS, CONSTANTS
from firmware_py.estimation.model.jacobians import REGRESSORS, Array, mass
from firmware_py.estimation.model.kernel_arguments import ForceTerms, Model, grouped, new_linearisation
from firmware_py.estimation.model.prediction import load_parameters, predict, rates, water_velocity
from firmware_py.estimation.model.state import CURRENT, EQUATIONS, MOTIONS, MOVING, WATER, WATER_AXIS
from firmware_py.estimation.model.transition import BUOYANCY, DRAG, TRIM, Nine, invert
from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

Floats = Sequence[float] | Array
GROUPS = {
    f"{axis}_dot": tuple(name for name in COEFFICIENTS if name.startswith(f"{axis}_") and name.endswith("dot"))
    for axis in AXES
}
"""One scale, 1 as believed, for all added mass of an equation: estimated in the place of its members."""
SCALED = {**GROUPS, "buoyancy": ("B",)}
"""All that is estimated as a scale, and what of the constants it scales."""
X_G = "x_G"
"""The centre of gravity, forward, m: 0 as believed mostly, so that its size, by which it is uncertain, is L."""
_CROSS_FLOW = tuple(AXES.index(axis) for axis in "YZMN")
"""The equations that cross-flow drag acts in."""
_PLACES = {
    **{name: ((i, equation),) for i, (name, equation) in enumerate(REGRESSORS)},
    **{
        name: tuple((DRAG + len(_CROSS_FLOW) * i + j, equation) for j, equation in enumerate(_CROSS_FLOW))
        for i, name in enumerate(("C_dy", "C_dz"))
    },
    "B": tuple((BUOYANCY + i, i) for i in range(EQUATIONS)),
    X_G: ((TRIM, AXES.index("M")), (TRIM + 1, AXES.index("N"))),
}
"""Where the regressors of a coefficient stand, and the equations that they act in."""
_REGRESSORS = TRIM + 2


class ObserverModel:
    """x_dot = f(x, inputs) of one vehicle; it keeps the arrays that the kernels work on.

    Attributes:
        names: the parameters: nondimensional coefficients, scales of groups and of the buoyancy, x_G.
        water: how many states the water has: STILL, CURRENT or EDDIES.
        biases: motion states whose sensors have a bias.
        believed: the parameters as the vehicle file has them.
        sizes: what each is measured in where it is uncertain.
        first: place of the first parameter in the state x; see `state` for the layout.
        size: how many states there are.
        arrays: what the kernels read.
        linearisation: what a step leaves.
    """

    __slots__ = ("arrays", "believed", "biases", "first", "linearisation", "names", "size", "sizes", "water")

    def __init__(
        self, vehicle: Vehicle, names: Sequence[str], water: int = CURRENT, biases: Sequence[str] = ()
    ) -> None:
        """Packs the vehicle, with `names` as parameters: any of COEFFICIENTS or SCALED, or X_G.

        Raises:
            ParamError: a name is unknown, or occurs twice, or the mass matrix is not positive definite.
        """
        self.names, self.water = tuple(names), water
        self.biases = tuple(MOTIONS.index(name) for name in biases)
        values = constants(vehicle)
        terms = _force_terms(self.names, values)
        self.believed = tuple(1.0 if name in SCALED else float(values[CONSTANTS.index(name)]) for name in self.names)
        sizes = zip(self.names, self.believed, strict=True)
        self.sizes = tuple(vehicle.hull.length if name == X_G else abs(x) for name, x in sizes)
        self.first = MOVING + water + len(self.biases)
        self.size = self.first + len(self.names)
        self.arrays = Model(
            constants=values,
            inverse_mass=inverse_mass(values),
            terms=terms,
            groups=grouped(terms),
            water=water,
            first=self.first,
            added_mass=any("dot" in name for name in self.names),
        )
        self.linearisation = new_linearisation(_REGRESSORS)

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
        if not load_parameters(self.arrays, x, self.linearisation):
            return (math.nan,) * 9
        u, v, w, p, q, r, phi, theta, psi = x[:MOVING].tolist()
        return rates(self.arrays, inputs, (u, v, w, p, q, r, phi, theta, psi), water_velocity(x, self.water))

    def advance(self, x: Array, inputs: Array, h: float) -> bool:
        """Moves x on by h (s), inputs (delta_s, delta_r, delta_b, n) being means over the step, and linearises it.

        Returns:
            False, with x as it was, if the step leads to a number that is not finite.
        """
        return predict(self.arrays, inputs, h, x, self.linearisation)

    def transition(self) -> Array:
        """The motion's rows of F* of the last step, (9, size); its other rows are those of the identity."""
        Phi = self.linearisation.Phi
        F = np.zeros((MOVING, self.size))
        F[:, :MOVING] = Phi[:, :MOVING]
        for j in range(self.water):
            F[:, MOVING + j] = Phi[:, WATER + WATER_AXIS[j]]
        F[:, self.first :] = self.linearisation.response[:, :EQUATIONS] @ self.unit_forces()
        return F

    def unit_forces(self) -> Array:
        """The force in each equation by a unit of each parameter in the last step, (6, parameters), N or N m."""
        forces, terms = np.zeros((EQUATIONS, len(self.names))), self.arrays.terms
        np.add.at(
            forces, (terms.equation, terms.parameter), terms.weight * self.linearisation.regressors[terms.regressor]
        )
        return forces


def _force_terms(names: tuple[str, ...], values: Array) -> ForceTerms:
    """What these parameters scale; `values` are the constants as believed."""
    rows, weights = [], []
    for i, members in enumerate(_members(names)):
        for member in members:
            constant = CONSTANTS.index(member)
            for regressor, equation in _PLACES[member]:
                rows.append((i, regressor, equation, constant))
                weights.append(1.0 if member == names[i] else float(values[constant]))
    parameters, regressors, equations, places = np.array(rows, dtype=np.int64).reshape(len(rows), 4).T.copy()
    return ForceTerms(parameters, regressors, equations, places, np.array(weights, dtype=np.float64))


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
        if name not in (*COEFFICIENTS, *SCALED, X_G):
            near = difflib.get_close_matches(shortened(name), (*COEFFICIENTS, *SCALED, X_G), 3, 0.5)
            known = "the names are those of [coefficients], C_d0, C_dy, C_dz, buoyancy, x_G, X_dot to N_dot"
            hint = f"did you mean {', '.join(near)}?" if near else known
            raise ParamError(f"no coefficient is called {quoted(name)}; {hint}")
        members.append(SCALED.get(name, (name,)))
        for member in members[-1]:
            if member in owner:
                twice = (
                    f"{quoted(owner[member])} and {quoted(name)} both hold {member}"
                    if owner[member] != name
                    else f"{quoted(name)} twice"
                )
                raise ParamError(f"{twice}; name every coefficient once")
            owner[member] = name
    return members
