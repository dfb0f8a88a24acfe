"""kill -9 of `sitl`, `fly` and `plant`, once each; `python -m sternplane.kill` does it fifty times."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from sternplane.kill import fly_victim, plant_victim, sitl_victim

BUS = "udp:4"


@pytest.mark.timeout(300)
@pytest.mark.parametrize("victim", [sitl_victim, fly_victim], ids=["sitl", "fly"])
def test_the_start_after_a_kill_works_and_knows_how_well_it_knows_its_place(tmp_path: Path, victim: Any) -> None:
    found = victim.trial(tmp_path, BUS, random.Random(1000), longest=3.0, depth=0.0)
    assert found["wrong"] == [], found
    assert not found["came_up"]


@pytest.mark.timeout(300)
@pytest.mark.parametrize("victim", [sitl_victim, fly_victim], ids=["sitl", "fly"])
def test_a_vehicle_whose_program_is_killed_under_water_comes_up_when_that_starts_again(
    tmp_path: Path, victim: Any
) -> None:
    found = victim.trial(tmp_path, BUS, random.Random(1001), longest=3.0, depth=3.0)
    assert found["wrong"] == [], found
    assert found["depth_m"] > 1.5
    assert found["came_up"]
    assert found["depth_at_end_m"] < 1.0


@pytest.mark.timeout(300)
def test_the_next_plant_is_heard_after_a_kill(tmp_path: Path) -> None:
    found = plant_victim.trial(tmp_path, BUS, random.Random(1000), longest=3.0)
    assert found["wrong"] == [], found
