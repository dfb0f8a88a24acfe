"""The passport as a file says it: what comes back, what is refused, and what is told of changes."""

from __future__ import annotations

import copy
import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.params import ParamError
from firmware_py.records.passport import LearnedModel, model_of, moved, moved_text, to_plain, trimmed

MODEL = LearnedModel(
    ("M_q", "N_dr", "Y_dr"),
    (-0.068, -0.013, 0.027),
    (-0.07, -0.01, 0.0275),
    (True, True, False),
    ((1e-6,), (1e-8, 1e-7), (0.0, -2e-8, 4e-7)),
)
PLAIN = to_plain(MODEL, {"name": "x"}, "hash", {"date": "2026", "utc_s": 1.0, "boot": "b", "uptime_s": 1.0})
TEXT = json.dumps(PLAIN)


def test_it_comes_back_to_the_bit() -> None:
    assert model_of(json.loads(TEXT)) == MODEL


def test_what_people_read_is_beside_the_covariance() -> None:
    assert PLAIN["coefficients"]["M_q"] == {"file": -0.068, "value": -0.07, "std": 1e-3, "valid": True}


def changed(*path: Any, to: Any) -> dict[str, Any]:
    """Return the passport with another value somewhere."""
    found = copy.deepcopy(json.loads(TEXT))
    place = found
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = to
    return found


@pytest.mark.parametrize(
    ("found", "why"),
    [
        ([], "no passport"),
        ({"x": 1}, "no passport"),
        (changed("passport", to=2), "version 2"),
        (changed("passport", to="1"), "version"),
        (changed("covariance", 1, 1, to=-1e-7), "must be positive"),
        (changed("covariance", 1, 1, to=0.0), "must be positive"),
        (changed("covariance", 1, 0, to=math.nan), "must be 2 numbers"),
        (changed("covariance", 1, to=[1.0]), "must be 2 numbers"),
        (changed("covariance", to="abc"), "3 rows"),
        (changed("covariance", to=[[1.0]]), "3 rows"),
        (changed("coefficients", "M_q", "value", to=math.inf), "must be a number"),
        (changed("coefficients", "M_q", "value", to=True), "must be a number"),
        (changed("coefficients", "M_q", "value", to=1e300), "must be a number"),
        (changed("coefficients", "M_q", "std", to=0.5), "not that of the covariance"),
        (changed("coefficients", "M_q", "valid", to=1), "must be a table"),
        (changed("coefficients", "M_q", to=None), "must be a table"),
        (changed("coefficients", to={"c" * 65: PLAIN["coefficients"]["M_q"]}), "must be a table"),
        (changed("coefficients", "N_dr", "file", to=0.0), "file = 0"),
        (changed("coefficients", to={"M\x1b[31m": PLAIN["coefficients"]["M_q"]}), r"'M\\x1b\[31m' must be a table"),
        (changed("coefficients", to={}), "1 to 200"),
        (changed("coefficients", to={f"c{i}": {} for i in range(201)}), "1 to 200"),
    ],
)
def test_what_cannot_be_is_refused_with_a_reason(found: Any, why: str) -> None:
    with pytest.raises(ParamError, match=why) as refused:
        model_of(found)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("key", ["vehicle", "configuration", "date", "utc_s", "coefficients", "covariance"])
def test_one_that_is_not_whole_is_refused(key: str) -> None:
    found = json.loads(TEXT)
    del found[key]
    with pytest.raises(ParamError, match=f"{key} is missing"):
        model_of(found)


@given(st.integers(0, len(TEXT)), st.integers(0, len(TEXT)), st.text('0123456789eE+-.,[]{}"NaInfty tru', max_size=6))
def test_however_a_text_is_spoiled_it_is_read_as_a_model_that_can_be_or_refused(begin: int, end: int, new: str) -> None:
    try:
        model = model_of(json.loads(TEXT[:begin] + new + TEXT[max(begin, end) :]))
    except ValueError:  # ParamError and json's
        return
    assert all(map(math.isfinite, (*model.file, *model.value, *model.std)))
    assert all(std > 0.0 for std in model.std)
    assert [len(row) for row in model.covariance] == list(range(1, len(model.names) + 1))


def test_what_moved_by_three_sigma_and_five_percent_is_told_once_for_each_group() -> None:
    model = MODEL._replace(valid=(True, True, True))
    [one] = moved(model, model.file, model.value, model.std)  # M_q by 2.9 %; Y_dr, of the rudder too, by 0.8 sigma
    assert moved_text(*one) == "rudder (N_dr) -23 %, 9 sigma"
    assert moved(model._replace(valid=(True, False, True)), model.file, model.value, model.std) == []
    assert moved(model, model.file, model.value, [0.1] * 3) == []
    assert moved(model, model.file, [math.nan] * 3, model.std) == []
    assert moved(model, [0.0] * 3, model.value, model.std) == []


def test_what_payload_has_changed_is_told_and_what_is_known_to_no_better_is_not() -> None:
    known = LearnedModel(
        ("buoyancy", "x_G", "M_w"),
        (1.0, 0.0, 0.1),
        (0.996, 0.0055, 0.2),
        (False,) * 3,
        ((9e-8,), (0.0, 1e-7), (0.0, 0.0, 1e-4)),
    )
    assert trimmed(known) == ["buoyancy -0.4 %, 13 sigma", "centre of gravity +6 mm forward, 17 sigma"]
    assert trimmed(known._replace(value=(0.9995, 0.0015, 0.2))) == []
    assert trimmed(known._replace(covariance=((1e-6,), (0.0, 4e-6), (0.0, 0.0, 1e-4)))) == []
