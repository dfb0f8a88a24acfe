"""Eq. 26 to 33: the linear models and the sliding surfaces that follow from coefficients, beside the printed ones."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from firmware_py.control.sliding_mode_design import DesignError, design_sliding_mode
from firmware_py.control.sliding_mode_params import PAPER_DEPTH_GAINS, PAPER_HEADING_GAINS
from firmware_py.vehicle.linear_models import LinearModel, diving_model, steering_model
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.paper.printed import NUMBERS, SIGNS, TABLE_1, Number, U

OPPOSITE = ("k_q", "k_theta", "k_zd_dot", "k_v", "k_r", "k_psid_dot")
"""Printed with the other sign than Eq. 25 gives; compared by size."""
_MODELS = ("27", "31")


class Comparison(NamedTuple):
    """A printed number and what it should be.

    Attributes:
        number: the printed one.
        low: the least, and `high` the greatest that the paper's own inputs give, as they are rounded: Table 1 for
            Eq. 27 and 31, the printed models for the rest.
        high: see low.
        follows: whether these contain a number that is printed so.
        found: by whose coefficients -> ours; None where no law can be designed.
    """

    number: Number
    low: float
    high: float
    follows: bool
    found: dict[str, float | None]


def with_values(vehicle: Vehicle, values: Mapping[str, float]) -> Vehicle:
    """The vehicle with other coefficients."""
    return dataclasses.replace(vehicle, coefficients=dataclasses.replace(vehicle.coefficients, **values))


def compare(vehicle: Vehicle, estimates: Mapping[str, Mapping[str, float]]) -> list[Comparison]:
    """Every printed number of Eq. 27 to 33 beside what each set of coefficients gives.

    Args:
        vehicle: as it really is.
        estimates: by whom -> coefficient -> value.
    """
    ours = {name: numbers(*models(with_values(vehicle, values))) for name, values in estimates.items()}
    followed = {True: list(_from_table_1(vehicle)), False: list(_from_printed_models())}
    rows = []
    for number in NUMBERS:
        inputs = [found[number.key] for found in followed[number.equation in _MODELS]]
        given = [value for value in inputs if value is not None]
        low, high = min(given), max(given)
        least, most = (-high, -low) if number.key in OPPOSITE else (low, high)
        follows = least <= number.box[1] and most >= number.box[0]
        rows.append(Comparison(number, low, high, follows, {name: found[number.key] for name, found in ours.items()}))
    return rows


def models(vehicle: Vehicle) -> tuple[LinearModel, LinearModel]:
    """Eq. 27 and Eq. 31."""
    return diving_model(vehicle, U), steering_model(vehicle, U)


def numbers(dive: LinearModel, steer: LinearModel) -> dict[str, float | None]:
    """By `Number.key`; the factors of Eq. 29 and 33 as Eq. 25 has them: u = -k'x + (s'b)^-1 s'x_d_dot - ..."""
    found: dict[str, float | None] = {
        "a_qq": dive.A[0][0],
        "a_qt": dive.A[0][1],
        "a_zt": dive.A[2][1],
        "b_q": dive.b[0],
        "a_vv": steer.A[0][0],
        "a_vr": steer.A[0][1],
        "b_v": steer.b[0],
        "a_rv": steer.A[1][0],
        "a_rr": steer.A[1][1],
        "b_r": steer.b[1],
    }
    for model, gains, last, keys in (
        (dive, PAPER_DEPTH_GAINS, -1.0, ("s_q", "s_theta", "k_q", "k_theta", "k_zd_dot")),
        (steer, PAPER_HEADING_GAINS, 1.0, ("s_v", "s_r", "k_v", "k_r", "k_psid_dot")),
    ):
        try:
            law = design_sliding_mode(model, gains.poles, last, gains.delta_sw, gains.phi_b)
            found |= dict(zip(keys, (law.s[0], law.s[1], -law.k[0], -law.k[1], law.s[2] / law.s_b), strict=True))
        except DesignError:
            found |= dict.fromkeys(keys)
    return found


def _from_table_1(vehicle: Vehicle) -> Iterator[dict[str, float | None]]:
    """What the EKF's column gives: with every sign that it may have, and at either end of its rounding."""
    names, table = tuple(name for name in TABLE_1["ekf"] if not name.startswith("Z_")), TABLE_1["ekf"]
    signs = itertools.product(*((SIGNS[name],) if name in SIGNS else (-1.0, 1.0) for name in names))
    for sign, half in itertools.product(signs, (-0.005, 0.005)):
        errors = {name: 0.01 * side * (table[name] + half) for name, side in zip(names, sign, strict=True)}
        values = {name: getattr(vehicle.coefficients, name) * (1.0 + error) for name, error in errors.items()}
        yield numbers(*models(with_values(vehicle, values)))


def _from_printed_models() -> Iterator[dict[str, float | None]]:
    """What Eq. 27 and 31 give as printed: at every corner of their rounding."""
    box = {number.key: number.box for number in NUMBERS if number.equation in _MODELS}
    dive, steer = ("a_qq", "a_qt", "a_zt", "b_q"), ("a_vv", "a_vr", "a_rv", "a_rr", "b_v", "b_r")
    dives = [
        LinearModel(((qq, qt, 0.0), (1.0, 0.0, 0.0), (0.0, zt, 0.0)), (b, 0.0, 0.0))
        for qq, qt, zt, b in itertools.product(*(box[key] for key in dive))
    ]
    steers = [
        LinearModel(((vv, vr, 0.0), (rv, rr, 0.0), (0.0, 1.0, 0.0)), (b_v, b_r, 0.0))
        for vv, vr, rv, rr, b_v, b_r in itertools.product(*(box[key] for key in steer))
    ]
    for i in range(max(len(dives), len(steers))):
        yield numbers(dives[i % len(dives)], steers[i % len(steers)])


def document(rows: list[Comparison]) -> list[dict[str, Any]]:
    """For results.json."""
    return [
        {
            "equation": row.number.equation,
            "number": row.number.what,
            "printed": row.number.value,
            "printed_with_other_sign": row.number.key in OPPOSITE,
            "from_the_paper_s_inputs": [row.low, row.high],
            "follows": row.follows,
            **row.found,
        }
        for row in rows
    ]
