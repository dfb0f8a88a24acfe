"""One step of the observer model, compiled: RK4 for the state (paper Eq. 14), and the linearised step for its error.

Nothing is allocated. The layout of x is in `state`; the sensors' biases are not read here. Inputs, held over the step:
delta_s, delta_r, delta_b (rad), n (rev/s).
"""

from __future__ import annotations

from firmware_py.compiled import Vector, kernel
from firmware_py.estimation.model.flow import cross_flow, race, turn
from firmware_py.estimation.model.jacobians import forces, kinematics, mass
from firmware_py.estimation.model.kernel_arguments import Linearisation, Model
from firmware_py.estimation.model.state import (
    CURRENT,
    CURRENT_EAST,
    CURRENT_NORTH,
    EDDIES,
    EDDY_DOWN,
    EDDY_EAST,
    EDDY_NORTH,
    MOVING,
)
from firmware_py.estimation.model.transition import Nine, Three, invert, linearise, transition


@kernel()
def rates(model: Model, inputs: Vector, x: Nine, water: Three) -> Nine:
    """x_dot = f(x, inputs) of the nine motion states; their velocities are over ground, as is `water`, m/s, NED."""
    c, m = model.constants, model.inverse_mass
    u, v, w, p, q, r, phi, theta, psi = x
    t = turn(phi, theta, psi)
    u_c, v_c, w_c, u_turn, v_turn, w_turn, phi_dot, theta_dot, psi_dot = kinematics(p, q, r, *t, *water)
    u, v, w = u - u_c, v - v_c, w - w_c
    s, e, jet = race(c, u, inputs[3])
    X, Y, Z, K, M, N = forces(c, u, v, w, p, q, r, t[0], t[1], t[2], t[3], inputs[0], inputs[1], inputs[2], s, e, jet)
    Y_d, Z_d, M_d, N_d = cross_flow(c, v, w, q, r)
    Y, Z, M, N = Y + Y_d, Z + Z_d, M + M_d, N + N_d
    return (
        m[0, 0] * X + m[0, 1] * Y + m[0, 2] * Z + m[0, 3] * K + m[0, 4] * M + m[0, 5] * N + u_turn,
        m[1, 0] * X + m[1, 1] * Y + m[1, 2] * Z + m[1, 3] * K + m[1, 4] * M + m[1, 5] * N + v_turn,
        m[2, 0] * X + m[2, 1] * Y + m[2, 2] * Z + m[2, 3] * K + m[2, 4] * M + m[2, 5] * N + w_turn,
        m[3, 0] * X + m[3, 1] * Y + m[3, 2] * Z + m[3, 3] * K + m[3, 4] * M + m[3, 5] * N,
        m[4, 0] * X + m[4, 1] * Y + m[4, 2] * Z + m[4, 3] * K + m[4, 4] * M + m[4, 5] * N,
        m[5, 0] * X + m[5, 1] * Y + m[5, 2] * Z + m[5, 3] * K + m[5, 4] * M + m[5, 5] * N,
        phi_dot,
        theta_dot,
        psi_dot,
    )


@kernel()
def along(x: Nine, h: float, k: Nine) -> Nine:
    """x + h k."""
    return (
        x[0] + h * k[0],
        x[1] + h * k[1],
        x[2] + h * k[2],
        x[3] + h * k[3],
        x[4] + h * k[4],
        x[5] + h * k[5],
        x[6] + h * k[6],
        x[7] + h * k[7],
        x[8] + h * k[8],
    )


@kernel()
def water_velocity(x: Vector, water: int) -> Three:
    """Velocity of the water, m/s, NED, of a state with that many water states."""
    if water == EDDIES:
        return x[CURRENT_NORTH] + x[EDDY_NORTH], x[CURRENT_EAST] + x[EDDY_EAST], x[EDDY_DOWN]
    if water == CURRENT:
        return x[CURRENT_NORTH], x[CURRENT_EAST], 0.0
    return 0.0, 0.0, 0.0


@kernel()
def load_parameters(model: Model, x: Vector, step: Linearisation) -> bool:
    """Writes the parameters of x into the constants, and into the inverse mass matrix if some are added mass.

    Returns:
        False if the mass matrix has no inverse.
    """
    constants, first = model.constants, model.first
    places, parameters, weights = model.terms.constant, model.terms.parameter, model.terms.weight
    for k in range(len(weights)):
        constants[places[k]] = weights[k] * x[first + parameters[k]]
    if not model.added_mass:
        return True
    mass(constants, step.mass)
    return invert(step.mass, model.inverse_mass)


@kernel()
def predict(model: Model, inputs: Vector, h: float, x: Vector, step: Linearisation) -> bool:
    """Moves x on by h (s), paper Eq. 14, and linearises the step at its middle.

    Args:
        model: the parameters are taken from x and left in its constants.
        inputs: delta_s, delta_r, delta_b, n: means over the step.
        h: step, s.
        x: state; its nine motion states move.
        step: out.

    Returns:
        False, with x as it was, if the step leads to a number that is not finite or the mass matrix has no inverse.
    """
    if not load_parameters(model, x, step):
        return False
    water = water_velocity(x, model.water)
    x_1 = (x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8])
    k_1 = rates(model, inputs, x_1, water)
    k_2 = rates(model, inputs, along(x_1, 0.5 * h, k_1), water)
    x_3 = along(x_1, 0.5 * h, k_2)
    k_3 = rates(model, inputs, x_3, water)
    k_4 = rates(model, inputs, along(x_1, h, k_3), water)
    end = along(along(along(along(x_1, h / 6.0, k_1), h / 3.0, k_2), h / 3.0, k_3), h / 6.0, k_4)
    check = 0.0
    for value in end:
        check += value * 0.0
    if check != 0.0:
        return False

    linearise(model, inputs, x_3, k_3, water, step)
    transition(model, h, step)
    for i in range(MOVING):
        x[i] = end[i]
    return True
