"""JSON as it is saved in flight."""

from __future__ import annotations

import gc
import json
import math
from collections.abc import Callable, Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.drivers.dronecan.own_node import KeptNodeIds
from firmware_py.estimation.navigation.navigation import KeptNavigation
from firmware_py.json_text import json_text
from firmware_py.records.passport import LearnedModel
from firmware_py.run import kept_navigation, kept_passport
from firmware_py.run.moment import Moment

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
)
NOW = Moment(1.8e9, "boot", 1000.0)
NAVIGATION = KeptNavigation(1.0, 2.0, 0.5, 101325.0)
LEARNED = LearnedModel(("M_q", "N_r"), (-0.1, -0.2), (-0.1, -0.2), (True, True), ((1e-4,), (0.0, 1e-4)))


@given(st.dictionaries(st.text(), values, max_size=4))
def test_what_is_written_is_read_as_it_was(document: dict[str, object]) -> None:
    assert json.loads(json_text(document)) == document


def test_two_levels_have_a_line_for_each_entry() -> None:
    document = {"date": "today", "none": [], "table": {"a": {"b": [1, 2.5]}}, "rows": [[1], [2, 3]]}
    assert json_text(document).splitlines() == [
        "{",
        ' "date": "today",',
        ' "none": [],',
        ' "table": {',
        '  "a": {"b": [1, 2.5]}',
        " },",
        ' "rows": [',
        "  [1],",
        "  [2, 3]",
        " ]",
        "}",
    ]


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_is_refused(number: float) -> None:
    for value in (number, [number], {"a": [[[number]]]}):
        with pytest.raises(ValueError, match="not JSON compliant"):
            json_text({"value": value})


@pytest.fixture
def collector_off() -> Iterator[None]:
    """As in flight."""
    gc.disable()
    gc.collect()
    yield
    gc.enable()


@pytest.mark.usefixtures("collector_off")
@pytest.mark.parametrize(
    "save",
    [
        lambda: kept_navigation.encode(NAVIGATION, 1.5, 5.0, NOW),
        lambda: kept_passport.encode(LEARNED, {"name": "boat", "fins": [["rudder", "stern", 0.0]]}, "hash", NOW),
        lambda: KeptNodeIds({b"1": 125}).changed(),
    ],
    ids=["navigation", "passport", "node ids"],
)
def test_to_save_leaves_nothing_that_only_the_collector_frees(save: Callable[[], object]) -> None:
    for _ in range(10):
        save()
    assert gc.collect() == 0
