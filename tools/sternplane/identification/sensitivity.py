"""The sensitivity of a trajectory to the state at its start, S = Phi S, compiled, and the information it gives.

These kernels have a file of their own: what it imports decides when kernels are compiled again.
"""

from __future__ import annotations

from firmware_py.compiled import Cube, Flags, Indices, Matrix, Vector, kernel
from firmware_py.estimation.model.kernel_arguments import Linearisation, Model
from firmware_py.estimation.model.prediction import predict
from firmware_py.estimation.model.state import MOVING, WATER


@kernel()
def carry(model: Model, step: Linearisation, before: Matrix, after: Matrix) -> None:
    """Slopes by the state at the start, (9, size), over a step: Phi `before`, and what water and parameters do in it.

    Args:
        model: steady or still water.
        step: as `prediction.predict` leaves it.
        before: of the motion states before the step.
        after: out, of those after it.
    """
    size, terms = after.shape[1], model.terms
    for i in range(MOVING):
        for j in range(size):
            after[i, j] = 0.0
        for k in range(MOVING):
            f = step.Phi[i, k]
            for j in range(size):
                after[i, j] += f * before[k, j]
        for j in range(model.water):
            after[i, MOVING + j] += step.Phi[i, WATER + j]
        for k in range(len(terms.weight)):
            force = terms.weight[k] * step.regressors[terms.regressor[k]]
            after[i, model.first + terms.parameter[k]] += force * step.response[i, terms.equation[k]]


@kernel()
def inform(S: Matrix, bias: Indices, came: Flags, std: Vector, s: Vector, J: Matrix) -> None:
    """Adds to the lower half of the information J, (size, size), what the measurements that `came`, (9,), tell.

    Args:
        S: slopes of the moving states, as `carry` leaves them.
        bias: place in the state of what each sensor reads too much, (9,); negative for none.
        came: which of the nine were measured.
        std: of their noise, (9,).
        s: scratch, (size,).
        J: changed.
    """
    size = len(s)
    for i in range(MOVING):
        if came[i]:
            for j in range(size):
                s[j] = S[i, j] / std[i]
            if bias[i] >= 0:
                s[bias[i]] += 1.0 / std[i]
            for a in range(size):
                f = s[a]
                if f != 0.0:
                    for b in range(a + 1):
                        J[a, b] += f * s[b]


@kernel()
def shoot(
    model: Model, inputs: Matrix, h: float, x: Vector, step: Linearisation, S: Matrix, predicted: Matrix, slopes: Cube
) -> bool:
    """Fills `predicted`, (K, 9), and `slopes`, (K, 9, size), step by step; False if a step becomes non-finite.

    Args:
        model: see `prediction.predict`, as for step and h (s).
        inputs: of all the steps, (K, 4).
        h: see model.
        x: at the start; at the end where it came to.
        step: see model.
        S: slopes at the start, (9, size): the identity's rows.
        predicted: out.
        slopes: out.
    """
    for k in range(len(inputs)):
        if not predict(model, inputs[k], h, x, step):
            return False
        carry(model, step, S if k == 0 else slopes[k - 1], slopes[k])
        for i in range(MOVING):
            predicted[k, i] = x[i]
    return True
