"""kill -9 of `sitl`, `fly` and `plant`, once each at the surface and under water; `make kill` does it fifty times."""

from __future__ import annotations

import contextlib
import random
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import pytest
from sternplane.kill import fly_victim, plant_victim, sitl_victim

from tests.bus_numbers import free_number

TRIALS: Mapping[str, tuple[Callable[..., dict[str, Any]], dict[str, Any]]] = {
    "fly under water": (fly_victim.trial, {"rng": random.Random(1001), "depth": 2.5}),
    "fly at the surface": (fly_victim.trial, {"rng": random.Random(1000), "depth": 0.0}),
    "sitl under water": (sitl_victim.trial, {"rng": random.Random(1001), "depth": 2.5}),
    "sitl at the surface": (sitl_victim.trial, {"rng": random.Random(1000), "depth": 0.0}),
    "plant": (plant_victim.trial, {"rng": random.Random(1000)}),
}


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Future[dict[str, Any]]]:
    """All at once, each with a bus of its own: they wait for real time most of theirs."""
    with contextlib.ExitStack() as buses, ThreadPoolExecutor(len(TRIALS)) as pool:

        def begun(trial: Callable[..., dict[str, Any]], arguments: dict[str, Any]) -> Future[dict[str, Any]]:
            bus = "" if trial is sitl_victim.trial else f"udp:{buses.enter_context(free_number())}"
            return pool.submit(trial, tmp_path_factory.mktemp("killed"), bus, longest=3.0, **arguments)

        return {name: begun(*trial) for name, trial in TRIALS.items()}


@pytest.mark.parametrize("name", ["sitl at the surface", "fly at the surface"])
def test_the_start_after_a_kill_works_and_knows_how_well_it_knows_its_place(
    trials: Mapping[str, Future[dict[str, Any]]], name: str
) -> None:
    found = trials[name].result()
    assert found["wrong"] == [], found
    assert not found["came_up"]


@pytest.mark.parametrize("name", ["sitl under water", "fly under water"])
def test_a_vehicle_whose_program_is_killed_under_water_comes_up_when_that_starts_again(
    trials: Mapping[str, Future[dict[str, Any]]], name: str
) -> None:
    found = trials[name].result()
    assert found["wrong"] == [], found
    assert found["depth_m"] > 1.5
    assert found["came_up"]
    assert found["depth_at_end_m"] < 1.0


def test_the_next_plant_is_heard_after_a_kill(trials: Mapping[str, Future[dict[str, Any]]]) -> None:
    found = trials["plant"].result()
    assert found["wrong"] == [], found
