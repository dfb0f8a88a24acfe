"""The sliding-mode observer (paper Eq. 3 to 11): x_hat_dot = f(x_hat) - L tanh(y_tilde / Phi), y_tilde = x_hat - y.

While it slides, the switching term is the acceleration that the model gets wrong (Eq. 10), and that moves the
coefficients. With a constant L, the paper's, each coefficient has one channel, the switching term of its own equation,
with the sign that its regressor has in the manoeuvre L is made for. It rests wherever the *sum* of an equation's forces
is right: on a hyperplane of coefficients, at a point that depends on where it began. With L weighted by the regressor
(ours: down the gradient of that sum's square, normalised) the hyperplane turns with the motion, and only the true
coefficients lie on all of them, if the motion is rich enough.

It reckons with still water and no noise. L and Phi follow from the vehicle file, for a manoeuvre of usual size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from firmware_py.compiled import Matrix, Vector, kernel
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.model.jacobians import Array, mass
from firmware_py.estimation.model.kernel_arguments import Linearisation, Model
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.prediction import predict
from firmware_py.estimation.model.state import EQUATIONS, MOVING, PHI, STILL
from firmware_py.params import ParamError, param
from firmware_py.vehicle.vehicle import Vehicle

DRIFT, HEAVE, ROLL, TURN = 0.1, 0.04, 0.04, 0.2
"""A manoeuvre of usual size at the trim speed u, fins at their limits: v / u, w / u, L p / u, and L q / u and L r / u.

The convergence under excitation hangs on these sizes, since they make the coefficients of an equation comparable.
"""
FLOOR = 1e-4
"""Where the squares of the regressors are below this part of the usual manoeuvre's, there is little to learn from."""


@dataclass(frozen=True, slots=True)
class SmoParams:
    """What is estimated, how, and how fast."""

    names: tuple[str, ...] = TEN
    """What is learned: coefficients, C_d0, C_dy, C_dz; added mass is not."""
    weighted: bool = False
    """L weighted by the regressor; else constant, as in the paper."""
    uncertainty: float = param(
        100.0, unit="%", low=1.0, high=1000.0, doc="How wrong a coefficient may be, of its size."
    )
    margin: float = param(1.5, low=1.0, high=100.0, doc="L over the acceleration that such errors make (Eq. 9).")
    bandwidth: float = param(25.0, unit="1/s", low=0.1, high=1000.0, doc="L over Phi: how fast it slides in the layer.")
    rate: float = param(5.0, unit="1/s", low=0.001, high=100.0, doc="How fast an error of force is learned away.")
    speed_layer: float = param(1e-3, unit="m/s", low=1e-9, high=1.0, doc="Least Phi of u, v, w.")
    rate_layer: float = param(0.01, unit="deg/s", low=1e-9, high=10.0, doc="Least Phi of p, q, r.")
    angle_layer: float = param(0.01, unit="deg", low=1e-9, high=10.0, doc="Least Phi of the angles.")


class ObserverEstimate(NamedTuple):
    """What is believed: coefficients, (names,); nu, m/s and rad/s, (6,); phi, theta, psi, rad, (3,)."""

    values: Array
    nu: Array
    angles: Array


class ObserverHistory(NamedTuple):
    """What a run went through.

    Attributes:
        steps: how many were made; fewer than asked if one led to a number that is not finite.
        x: states, (K / every, n).
        s: y_tilde / Phi, (K / every, 9); 0 where nothing came.
    """

    steps: int
    x: Array
    s: Array


class Gains(NamedTuple):
    """What the kernel takes beside the model, and its scratch.

    Attributes:
        L: switching gains of the nine outputs, m/s^2, rad/s^2, rad/s, (9,).
        Phi: boundary layers of the nine outputs, (9,).
        learning: of each parameter: L, its sign included; or, weighted, what weighs the squares of the regressors.
        rate: of learning, 1/s, where L is weighted.
        weighted: see `SmoParams`.
        mass: mass matrix, (6, 6).
        switching: scratch, (9,): L tanh(s).
        force: scratch, (6,): the force that each equation gets wrong.
        square: scratch, (6,): the squares of the regressors of each equation.
    """

    L: Vector
    Phi: Vector
    learning: Vector
    rate: float
    weighted: bool
    mass: Matrix
    switching: Vector
    force: Vector
    square: Vector


@kernel()
def observe(
    model: Model, step: Linearisation, gains: Gains, x: Vector, inputs: Vector, h: float, z: Vector, s: Vector
) -> bool:
    """Moves x on by h (s), then back along the switching term of what is measured there (Eq. 6).

    Args:
        model: see `prediction.predict`, as for step.
        step: see model.
        gains: see there.
        x: state, (n,).
        inputs: delta_s, delta_r, delta_b (rad), n (rev/s): means over the step.
        h: step, s.
        z: u v w p q r phi theta psi at its end; NaN where nothing came.
        s: out, y_tilde / Phi, (9,); 0 where nothing came.

    Returns:
        False, with x as it was, if the step leads to a number that is not finite.
    """
    if not predict(model, inputs, h, x, step):
        return False
    terms, first = model.terms, model.first
    for i in range(MOVING):
        error = x[i] - z[i]
        if i >= PHI:
            error = (error + math.pi) % math.tau - math.pi
        s[i] = error / gains.Phi[i] if math.isfinite(error) else 0.0
        gains.switching[i] = gains.L[i] * math.tanh(s[i])
        x[i] -= h * gains.switching[i]
    if not gains.weighted:
        for k in range(len(terms.weight)):
            i = terms.parameter[k]
            if k == 0 or i != terms.parameter[k - 1]:  # one channel each: the first equation it acts in
                x[first + i] -= h * gains.learning[i] * math.tanh(s[terms.equation[k]])
        return True
    force, square = gains.force, gains.square
    for r in range(EQUATIONS):
        square[r] = FLOOR
        force[r] = 0.0
        for i in range(EQUATIONS):
            force[r] += gains.mass[r, i] * gains.switching[i]
    for k in range(len(terms.weight)):
        regressor = terms.weight[k] * step.regressors[terms.regressor[k]]
        square[terms.equation[k]] += gains.learning[terms.parameter[k]] * regressor * regressor
    for k in range(len(terms.weight)):
        i, r = terms.parameter[k], terms.equation[k]
        regressor = terms.weight[k] * step.regressors[terms.regressor[k]]
        x[first + i] -= h * gains.rate * gains.learning[i] * regressor * force[r] / square[r]
    return True


class SlidingModeObserver:
    """The observer of one vehicle. Its arrays are its own; ask `estimate`."""

    def __init__(self, vehicle: Vehicle, params: SmoParams, sides: tuple[float, float] = (1.0, 1.0)) -> None:
        """Chooses L and Phi for a manoeuvre of usual size.

        Args:
            vehicle: as it is believed to be.
            params: what is estimated, and how.
            sides: to which side stern planes and rudder are put over in the manoeuvre that a constant L is for: +-1.

        Raises:
            ParamError: a name is unknown, occurs twice, is added mass, is believed to be 0, or pushes nothing in the
                manoeuvre, so that nothing says how large its L should be.
        """
        self.params, self.names = params, params.names
        self.model = model = ObserverModel(vehicle, params.names, STILL)
        if model.arrays.added_mass:
            raise ParamError(f"names: {', '.join(params.names)}: this observer does not learn added mass; leave it out")
        M = np.zeros((EQUATIONS, EQUATIONS))
        mass(model.arrays.constants, M)
        push, scale = _pushes(model, vehicle, sides), np.abs(np.array(model.believed))
        for i, name in enumerate(params.names):
            if scale[i] == 0.0 or not push[:, i].any():
                raise ParamError(f"names: nothing says how far {name} moves this vehicle; leave it out")
        moved = np.abs(model.arrays.inverse_mass @ push) * scale
        """Acceleration by all of each coefficient, (6, names)."""
        layers = np.repeat((params.speed_layer, params.rate_layer, params.angle_layer), 3)
        layers[:6] = np.maximum(layers[:6], params.margin * params.uncertainty * moved.sum(axis=1) / params.bandwidth)
        L, learning = params.bandwidth * layers, 1.0 / (push**2).sum(axis=0)
        if not params.weighted:
            terms = model.arrays.terms
            equations = dict(reversed([*zip(terms.parameter.tolist(), terms.equation.tolist(), strict=True)]))
            for i, row in equations.items():
                share = scale[i] / moved[row].sum()
                learning[i] = params.rate * L[row] * share * math.copysign(1.0, push[row, i])
        scratch = (np.zeros(MOVING), np.zeros(EQUATIONS), np.zeros(EQUATIONS))
        self.gains = Gains(L, layers, learning, params.rate, params.weighted, M, *scratch)
        self.x, self.s = model.state((0.0,) * 6, (0.0,) * 3), np.zeros(MOVING)

    def start(self, nu: Sequence[float], angles: Sequence[float], values: Mapping[str, float] | None = None) -> None:
        """Begins anew at a velocity (m/s, rad/s) and attitude (rad), coefficients as believed but for `values`."""
        self.x[:] = self.model.state(nu, angles)
        for name, value in (values or {}).items():
            self.x[self.model.place(name)] = value

    def step(self, inputs: Array, h: float, z: Array) -> bool:
        """Moves on by h (s), then takes in what was measured there.

        Args:
            inputs: delta_s, delta_r, delta_b (rad), n (rev/s): means over the step, (4,).
            h: step, s; h bandwidth <= 1, or it would chatter.
            z: u v w p q r phi theta psi, (9,); NaN where nothing came.

        Returns:
            False if a number was not finite: call `start`.
        """
        model = self.model
        return observe(model.arrays, model.linearisation, self.gains, self.x, inputs, h, z, self.s)

    def run(self, h: float, inputs: Array, z: Array, every: int = 1) -> ObserverHistory:
        """`step` over the rows of inputs, (K, 4), and z, (K, 9); what it went through at every such row."""
        rows = len(inputs) // every
        x, s = np.zeros((rows, self.model.size)), np.zeros((rows, MOVING))
        for k in range(len(inputs)):
            if not self.step(inputs[k], h, z[k]):
                return ObserverHistory(k, x, s)
            if (k + 1) % every == 0:
                x[k // every], s[k // every] = self.x, self.s
        return ObserverHistory(len(inputs), x, s)

    def estimate(self) -> ObserverEstimate:
        """What is believed now."""
        return ObserverEstimate(self.x[self.model.first :].copy(), self.x[:6].copy(), self.x[6:MOVING].copy())


def _pushes(model: ObserverModel, vehicle: Vehicle, sides: tuple[float, float]) -> Array:
    """The force (N, N m) in each equation by a unit of each coefficient in the usual manoeuvre, (6, names).

    Positive fin angles turn the bow down and to port; the vehicle then drifts to starboard and rises in its own axes.
    """
    fins, u = vehicle.effectiveness, vehicle.propeller.u_trim
    turn = TURN * u / vehicle.hull.length
    s, r = sides
    nu = (u, r * DRIFT * u, -s * HEAVE * u, ROLL * u / vehicle.hull.length, -s * turn, -r * turn)
    inputs = np.array([s * fins.delta_s_max, r * fins.delta_r_max, 0.0, vehicle.propeller.n_trim])
    model.advance(model.state(nu, (0.0, 0.0, 0.0)), inputs, 1e-9)
    return model.unit_forces()
