"""The case of damage counts seconds at which a valid value is wrong, and honesty by silence is none."""

from __future__ import annotations

import numpy as np
from sternplane.study.cases.damaged import CASES, WAYS, evaluate
from sternplane.study.rows import RunArrays


def run(way: int, wrong: int = 0, known: int = 9) -> RunArrays:
    valid = np.full(10, 60)
    return {
        "way": np.array(way),
        "completed": np.array(True),
        "valid": valid,
        "wrong": np.where(np.arange(10) == 2, wrong, 0),
        "known": np.arange(10) < known,
    }


def test_values_that_are_right_meet_every_target() -> None:
    (case,) = CASES
    rows = evaluate([run(k % len(WAYS)) for k in range(case.runs)]).rows
    assert [row.ok for row in rows if row.target is not None].count(False) == 0


def test_one_coefficient_that_is_wrong_for_half_of_the_time_is_too_much() -> None:
    rows = evaluate([run(k, 36) for k in range(len(WAYS))]).rows
    assert rows[0].value == 0.06
    assert rows[0].ok is False


def test_to_call_nothing_valid_is_no_honesty() -> None:
    rows = evaluate([run(k, known=0) for k in range(len(WAYS))]).rows
    assert [row.figure for row in rows if row.ok is False] == [
        f"{way.label}: coefficients that are not valid in the end, of ten"
        for way in WAYS
        if way.unknown_max is not None
    ]
