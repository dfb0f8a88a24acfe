"""One step of the observer model, compiled: RK4 for the state, and the matrices that carry its error along.

Nothing is allocated. The state x: u v w p q r phi theta psi; the water, 0, 2 or 5 numbers in m/s (the steady current
north and east, then eddies north, east and down); biases of sensors, which nothing here reads; the parameters. Inputs,
held over the step: delta_s, delta_r, delta_b (rad), n (rev/s).
"""

from __future__ import annotations

from firmware_py.compiled import kernel
from firmware_py.estimation.model.flow import cross_flow, race, turn
from firmware_py.estimation.model.jacobians import Array, forces, kinematics, mass
from firmware_py.estimation.model.transition import WIDTH, Nine, Picks, Three, invert, linearise, transition

WORK = (45, WIDTH)
"""Shape of the array of matrices: Phi and the response, then A and G of `transition` take 9 rows each, D 6, B 3."""
RESPONSE = 9
"""Its row where the response begins; Phi stands first."""
STILL, CURRENT, EDDIES = 0, 2, 5
"""How many states the water has."""


@kernel("UniTuple(f8,9)(f8[::1],f8[:,::1],f8[::1],UniTuple(f8,9),UniTuple(f8,3))")
def rates(c: Array, inverse: Array, inputs: Array, x: Nine, water: Three) -> Nine:
    """f(x, u, theta): x_dot of the nine moving states. Velocities are over ground, and so is `water`'s (NED)."""
    u, v, w, p, q, r, phi, theta, psi = x
    t = turn(phi, theta, psi)
    u_c, v_c, w_c, u_turn, v_turn, w_turn, phi_dot, theta_dot, psi_dot = kinematics(p, q, r, *t, *water)
    u, v, w = u - u_c, v - v_c, w - w_c
    s, e, jet = race(c, u, inputs[3])
    X, Y, Z, K, M, N = forces(c, u, v, w, p, q, r, t[0], t[1], t[2], t[3], inputs[0], inputs[1], inputs[2], s, e, jet)
    Y_d, Z_d, M_d, N_d = cross_flow(c, v, w, q, r)
    Y, Z, M, N = Y + Y_d, Z + Z_d, M + M_d, N + N_d
    i = inverse
    return (
        i[0, 0] * X + i[0, 1] * Y + i[0, 2] * Z + i[0, 3] * K + i[0, 4] * M + i[0, 5] * N + u_turn,
        i[1, 0] * X + i[1, 1] * Y + i[1, 2] * Z + i[1, 3] * K + i[1, 4] * M + i[1, 5] * N + v_turn,
        i[2, 0] * X + i[2, 1] * Y + i[2, 2] * Z + i[2, 3] * K + i[2, 4] * M + i[2, 5] * N + w_turn,
        i[3, 0] * X + i[3, 1] * Y + i[3, 2] * Z + i[3, 3] * K + i[3, 4] * M + i[3, 5] * N,
        i[4, 0] * X + i[4, 1] * Y + i[4, 2] * Z + i[4, 3] * K + i[4, 4] * M + i[4, 5] * N,
        i[5, 0] * X + i[5, 1] * Y + i[5, 2] * Z + i[5, 3] * K + i[5, 4] * M + i[5, 5] * N,
        phi_dot,
        theta_dot,
        psi_dot,
    )


@kernel("UniTuple(f8,9)(UniTuple(f8,9),f8,UniTuple(f8,9))")
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


@kernel("UniTuple(f8,3)(f8[::1],i8)")
def flow_of(x: Array, water: int) -> Three:
    """Velocity of the water, m/s, NED, of a state with that many water states."""
    if water == EDDIES:
        return x[9] + x[11], x[10] + x[12], x[13]
    if water == CURRENT:
        return x[9], x[10], 0.0
    return 0.0, 0.0, 0.0


@kernel("b1(f8[::1],f8[:,::1],i8[:,::1],f8[::1],i8,b1,f8[::1],f8[:,::1])")
def load(c: Array, inverse: Array, picks: Picks, weight: Array, first: int, heavy: bool, x: Array, M: Array) -> bool:
    """Takes the parameters from x into the constants, and into the inverse of the mass matrix if they are `heavy`.

    Returns:
        False if M (scratch, (6, 6)) has no inverse.
    """
    for k in range(len(weight)):
        c[picks[k, 3]] = weight[k] * x[first + picks[k, 0]]
    if not heavy:
        return True
    mass(c, M)
    return invert(M, inverse)


@kernel("b1(f8[::1],f8[:,::1],i8[:,::1],f8[::1],i8,i8,b1,f8[::1],f8[::1],f8,f8[:,::1],f8[::1])")
def predict(
    c: Array,
    inverse: Array,
    picks: Picks,
    weight: Array,
    water: int,
    first: int,
    heavy: bool,
    inputs: Array,
    x: Array,
    h: float,
    work: Array,
    y: Array,
) -> bool:
    """Moves x on by h (s), and fills what moves its error: Phi and the response, in `work`, and y.

    Args:
        c: constants; the parameters are taken from x and left in it.
        inverse: inverse of the mass matrix; computed anew if the parameters are `heavy`.
        picks: rows (parameter, place in y, equation, place in the constants), one for every force a parameter scales.
        weight: what a parameter's unit is of each, so that a parameter can scale a group of coefficients.
        water: how many states it has.
        first: place of the first parameter in x.
        heavy: some parameters are added mass.
        inputs: delta_s, delta_r, delta_b, n: means over the step.
        x: state; its first nine numbers move.
        h: step, s.
        work: shape WORK; rows 0 to 8 out: Phi, the moving states after the step by the moving states and the water
            before it; rows 9 to 17, six columns, out: the same by a force in each equation, held; the rest is scratch.
        y: out, the force that each coefficient multiplies at mid-step (see `transition.linearise`).

    Returns:
        False, with x as it was, if the step leads to a number that is not finite or the mass matrix has no inverse.
    """
    if not load(c, inverse, picks, weight, first, heavy, x, y[:36].reshape((6, 6))):
        return False
    stream = flow_of(x, water)
    x_1 = (x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8])
    k_1 = rates(c, inverse, inputs, x_1, stream)
    k_2 = rates(c, inverse, inputs, along(x_1, 0.5 * h, k_1), stream)
    x_3 = along(x_1, 0.5 * h, k_2)
    k_3 = rates(c, inverse, inputs, x_3, stream)
    k_4 = rates(c, inverse, inputs, along(x_1, h, k_3), stream)
    end = along(along(along(along(x_1, h / 6.0, k_1), h / 3.0, k_2), h / 3.0, k_3), h / 6.0, k_4)
    check = 0.0
    for value in end:
        check += value * 0.0
    if check != 0.0:
        return False

    linearise(c, inverse, inputs, x_3, k_3, stream, work[18:27], work[36:42], work[42:], y)
    transition(inverse, h, work[18:27], work[27:36], work[:9], work[9:18])
    x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8] = end
    return True
