"""kill -9 of `sitl`, `fly` and `plant`, once each; `python -m sternplane.kill` does it fifty times."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sternplane.kill import fly_victim, plant_victim, sitl_victim

BUS = "udp:4"


@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "trial", [sitl_victim.trial, fly_victim.trial, plant_victim.trial], ids=["sitl", "fly", "plant"]
)
def test_the_start_after_a_kill_works_and_knows_how_well_it_knows_its_place(
    tmp_path: Path, trial: Callable[..., dict[str, Any]]
) -> None:
    found = trial(tmp_path, BUS, random.Random(1000), longest=3.0)
    assert found["wrong"] == [], found
