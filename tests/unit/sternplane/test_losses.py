"""What was lost, in words: each count under the name of its source."""

from __future__ import annotations

import pytest
from sternplane.logs import losses


@pytest.mark.parametrize(
    ("counts", "source", "text"),
    [
        ({"bus_babbled": 15000}, "CAN bus", "15000 frames of no use, from a babbling node"),
        ({"ahrs_restarts": 1}, "AHRS, restarts", "1 time"),
        ({"ahrs_restarts": 2}, "AHRS, restarts", "2 times"),
        ({"ahrs_missed": 500}, "AHRS", "500 of 2000 messages lost (25 %)"),
    ],
)
def test_a_count_is_told_under_its_source(counts: dict[str, int], source: str, text: str) -> None:
    told = losses.told(counts, {"ahrs": 1500})
    assert [(loss.source, loss.text) for loss in told] == [(source, text)]
