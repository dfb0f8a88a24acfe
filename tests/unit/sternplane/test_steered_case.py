"""The case of missions in eddies counts what was wrong while it was valid, whatever became of it."""

from __future__ import annotations

import numpy as np
from sternplane.study.cases.honesty import FAR
from sternplane.study.cases.steered import CASES, WAYS, evaluate
from sternplane.study.rows import RunArrays


def run(way: int, valid: int, wrong: int = 0) -> RunArrays:
    z = np.zeros(10)
    z[:wrong] = FAR + 0.1
    return {"way": np.array(way), "completed": np.array(True), "valid": np.arange(10) < valid, "z": z}


def test_values_that_are_right_meet_every_target() -> None:
    (case,) = CASES
    rows = evaluate([run(k % len(WAYS), 7) for k in range(case.runs)]).rows
    assert [row.ok for row in rows if row.target is not None].count(False) == 0


def test_one_in_ten_that_were_wrong_for_a_while_are_too_many() -> None:
    rows = evaluate([run(k % len(WAYS), 10, 1) for k in range(10)]).rows
    assert rows[0].value == 0.1
    assert rows[0].ok is False


def test_to_call_nothing_valid_is_no_honesty() -> None:
    rows = evaluate([run(k, 0) for k in range(len(WAYS))]).rows
    assert {row.figure.partition(":")[0] for row in rows if row.ok is False} == {
        way.label for way in WAYS if way.unknown_max is not None
    }
