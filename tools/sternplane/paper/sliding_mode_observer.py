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

from firmware_py.compiled import kernel
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.model.jacobians import Array, mass
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.prediction import STILL, predict
from firmware_py.estimation.model.transition import MOVING, Picks
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


class Estimate(NamedTuple):
    """What is believed: coefficients, (names,); nu, m/s and rad/s, (6,); phi, theta, psi, rad, (3,)."""

    values: Array
    nu: Array
    angles: Array


class History(NamedTuple):
    """What a run went through.

    Attributes:
        steps: how many were made; fewer than asked if one led to a number that is not finite.
        x: states, (K / every, n).
        s: y_tilde / Phi, (K / every, 9); 0 where nothing came.
    """

    steps: int
    x: Array
    s: Array


@kernel(
    "b1(f8[::1],f8[:,::1],i8[:,::1],f8[::1],i8,f8[:,::1],f8[::1],f8[:,::1],f8[:,::1],f8[::1],f8,b1,f8[::1],f8[::1],"
    "f8,f8[::1],f8[::1])"
)
def observe(
    c: Array,
    inverse: Array,
    picks: Picks,
    weight: Array,
    first: int,
    work: Array,
    y: Array,
    M: Array,
    channels: Array,
    gains: Array,
    rate: float,
    weighted: bool,
    x: Array,
    inputs: Array,
    h: float,
    z: Array,
    s: Array,
) -> bool:
    """Moves x on by h (s), then back along the switching term of what is measured there (Eq. 6).

    Args:
        c: the observer model's, as are the next six.
        inverse: see c.
        picks: see c.
        weight: see c.
        first: see c.
        work: see c.
        y: see c.
        M: mass matrix, (6, 6).
        channels: L and Phi of the nine outputs, (2, 9).
        gains: of each coefficient: L, its sign included; or what weighs the squares of the regressors.
        rate: of learning, 1/s, where L is weighted.
        weighted: see `SmoParams`.
        x: state, (n,).
        inputs: delta_s, delta_r, delta_b (rad), n (rev/s): means over the step.
        h: step, s.
        z: u v w p q r phi theta psi at its end; NaN where nothing came.
        s: out, y_tilde / Phi, (9,); 0 where nothing came.

    Returns:
        False, with x as it was, if the step leads to a number that is not finite.
    """
    if not predict(c, inverse, picks, weight, STILL, first, False, inputs, x, h, work, y):
        return False
    switch, force, square = work[0], work[1], work[2]
    for i in range(MOVING):
        error = x[i] - z[i]
        if i >= 6:
            error = (error + math.pi) % math.tau - math.pi
        s[i] = error / channels[1, i] if math.isfinite(error) else 0.0
        switch[i] = channels[0, i] * math.tanh(s[i])
        x[i] -= h * switch[i]
    if not weighted:
        for k in range(len(weight)):
            if k == 0 or picks[k, 0] != picks[k - 1, 0]:  # one channel each: the first equation it acts in
                x[first + picks[k, 0]] -= h * gains[picks[k, 0]] * math.tanh(s[picks[k, 2]])
        return True
    for r in range(6):
        square[r] = FLOOR
        force[r] = 0.0
        for i in range(6):
            force[r] += M[r, i] * switch[i]
    for k in range(len(weight)):
        a = weight[k] * y[picks[k, 1]]
        square[picks[k, 2]] += gains[picks[k, 0]] * a * a
    for k in range(len(weight)):
        i, r = picks[k, 0], picks[k, 2]
        x[first + i] -= h * rate * gains[i] * weight[k] * y[picks[k, 1]] * force[r] / square[r]
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
        if model.heavy:
            raise ParamError(f"names: {', '.join(params.names)}: this observer does not learn added mass; leave it out")
        self._M = np.zeros((6, 6))
        mass(model.c, self._M)
        push, scale = _pushes(model, vehicle, sides), np.abs(np.array(model.believed))
        for i, name in enumerate(params.names):
            if scale[i] == 0.0 or not push[:, i].any():
                raise ParamError(f"names: nothing says how far {name} moves this vehicle; leave it out")
        moved = np.abs(model.inverse @ push) * scale
        """Acceleration by all of each coefficient, (6, names)."""
        layers = np.repeat((params.speed_layer, params.rate_layer, params.angle_layer), 3)
        layers[:6] = np.maximum(layers[:6], params.margin * params.uncertainty * moved.sum(axis=1) / params.bandwidth)
        self.channels = np.array([params.bandwidth * layers, layers])
        """L and Phi of the nine outputs, (2, 9)."""
        self.gains = 1.0 / (push**2).sum(axis=0)
        """L of each coefficient with its sign; or, weighted, one over the square of its usual regressor."""
        if not params.weighted:
            for i, row in {i: row for i, _, row, _ in reversed(model.picks.tolist())}.items():
                share = scale[i] / moved[row].sum()
                self.gains[i] = params.rate * self.channels[0, row] * share * math.copysign(1.0, push[row, i])
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
        m, params = self.model, self.params
        return observe(
            *(m.c, m.inverse, m.picks, m.weight, m.first, m.work, m.y, self._M, self.channels, self.gains),
            *(params.rate, params.weighted, self.x, inputs, h, z, self.s),
        )

    def run(self, h: float, inputs: Array, z: Array, every: int = 1) -> History:
        """`step` over the rows of inputs, (K, 4), and z, (K, 9); what it went through at every such row."""
        rows = len(inputs) // every
        x, s = np.zeros((rows, self.model.size)), np.zeros((rows, MOVING))
        for k in range(len(inputs)):
            if not self.step(inputs[k], h, z[k]):
                return History(k, x, s)
            if (k + 1) % every == 0:
                x[k // every], s[k // every] = self.x, self.s
        return History(len(inputs), x, s)

    def estimate(self) -> Estimate:
        """What is believed now."""
        return Estimate(self.x[self.model.first :].copy(), self.x[:6].copy(), self.x[6:MOVING].copy())


def _pushes(model: ObserverModel, vehicle: Vehicle, sides: tuple[float, float]) -> Array:
    """The force (N, N m) in each equation by a unit of each coefficient in the usual manoeuvre, (6, names).

    Positive fin angles turn the bow down and to port; the boat then drifts to starboard and rises in its own axes.
    """
    fins, u = vehicle.effectiveness, vehicle.propeller.u_trim
    turn = TURN * u / vehicle.hull.length
    s, r = sides
    nu = (u, r * DRIFT * u, -s * HEAVE * u, ROLL * u / vehicle.hull.length, -s * turn, -r * turn)
    inputs = np.array([s * fins.delta_s_max, r * fins.delta_r_max, 0.0, vehicle.propeller.n_trim])
    model.advance(model.state(nu, (0.0, 0.0, 0.0)), inputs, 1e-9)
    push = np.zeros((6, len(model.names)))
    for (i, factor, row, _), weight in zip(model.picks.tolist(), model.weight.tolist(), strict=True):
        push[row, i] += weight * model.y[factor]
    return push
