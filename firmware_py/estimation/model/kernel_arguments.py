"""What the kernels of the observer model take: the vehicle, what its parameters scale, and room for a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firmware_py.compiled import Indices, Matrix, Vector
from firmware_py.estimation.model.state import EQUATIONS, MOVING, WIDTH


class ForceTerms(NamedTuple):
    """The forces that the parameters scale, one entry each, (terms,): the model is linear in every parameter.

    Attributes:
        parameter: which parameter it is of; entries of one parameter stand together.
        regressor: place in `Linearisation.regressors` of the force that a unit of the coefficient makes.
        equation: in which of X Y Z K M N it acts.
        constant: place of the coefficient in the constants.
        weight: the coefficient over the parameter: 1, or as believed where a parameter scales a group.
    """

    parameter: Indices
    regressor: Indices
    equation: Indices
    constant: Indices
    weight: Vector


GROUP = 4
"""Forces of one equation that are added up together."""


class ForceGroups(NamedTuple):
    """The same entries by equation, GROUP together: what is missing of a group has the weight 0.

    Attributes:
        parameter: see `ForceTerms`, (groups * GROUP,); the next two likewise.
        regressor: see parameter.
        weight: see parameter.
        equation: of each group, (groups,).
    """

    parameter: Indices
    regressor: Indices
    weight: Vector
    equation: Indices


def grouped(terms: ForceTerms) -> ForceGroups:
    """Return the terms by equation."""
    entries: list[int] = []
    for equation in range(EQUATIONS):
        mine = np.flatnonzero(terms.equation == equation).tolist()
        entries += [*mine, *[-1] * (-len(mine) % GROUP)]
    order = np.array(entries, dtype=np.int64)
    return ForceGroups(
        parameter=np.append(terms.parameter, 0)[order],
        regressor=np.append(terms.regressor, 0)[order],
        weight=np.append(terms.weight, 0.0)[order],
        equation=terms.equation[order[::GROUP]],
    )


def first_terms(terms: ForceTerms, count: int) -> ForceTerms:
    """Those of the first `count` parameters."""
    mine = terms.parameter < count
    return ForceTerms(
        parameter=terms.parameter[mine],
        regressor=terms.regressor[mine],
        equation=terms.equation[mine],
        constant=terms.constant[mine],
        weight=terms.weight[mine],
    )


class Model(NamedTuple):
    """The observer model of one vehicle.

    Attributes:
        constants: see `equations.CONSTANTS`; the parameters are written into it before each step.
        inverse_mass: inverse of the mass matrix, (6, 6); computed anew if `added_mass`.
        terms: what the parameters scale.
        groups: the same by equation.
        water: how many states the water has: STILL, CURRENT or EDDIES.
        first: place of the first parameter in the state.
        added_mass: whether a parameter is added mass.
    """

    constants: Vector
    inverse_mass: Matrix
    terms: ForceTerms
    groups: ForceGroups
    water: int
    first: int
    added_mass: bool


def without_parameters(model: Model) -> Model:
    """Return the same vehicle with its parameters as they were loaded last: nothing of it is uncertain."""
    terms = first_terms(model.terms, 0)
    return model._replace(terms=terms, groups=grouped(terms), added_mass=False)


class Linearisation(NamedTuple):
    """A step, linearised: F* of paper Eq. 15 in factors, F* = [[Phi, G], [0, 1]], and the room to make it.

    A parameter's column of G is the response to the equation that it acts in, times its regressor.

    Attributes:
        Phi: motion after the step by motion and water velocity before it, (9, WIDTH).
        response: motion after the step by a force in each equation, held, N or N m: six columns of (9, WIDTH).
        regressors: the force that a unit of each coefficient makes at mid-step, N or N m.
        A: slopes of x_dot by motion and water velocity, (9, WIDTH).
        B: slopes of the water velocity in body axes, (3, WIDTH).
        D: slopes of the forces, (6, WIDTH).
        series: partial sums of the exponential of A, (9, WIDTH).
        mass: mass matrix, (6, 6); used up where it is inverted.
    """

    Phi: Matrix
    response: Matrix
    regressors: Vector
    A: Matrix
    B: Matrix
    D: Matrix
    series: Matrix
    mass: Matrix


def new_linearisation(regressors: int) -> Linearisation:
    """Room for a step of a model with so many regressors."""
    return Linearisation(
        Phi=np.zeros((MOVING, WIDTH)),
        response=np.zeros((MOVING, WIDTH)),
        regressors=np.zeros(regressors),
        A=np.zeros((MOVING, WIDTH)),
        B=np.zeros((3, WIDTH)),
        D=np.zeros((EQUATIONS, WIDTH)),
        series=np.zeros((MOVING, WIDTH)),
        mass=np.zeros((6, 6)),
    )
