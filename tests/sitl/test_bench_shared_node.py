"""The bench tools beside a simulated vehicle of which one node has several roles."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sternplane.hardware import fins_sweep, sweep

from .bench_plant import SITL, Plant, checked, started, tool

PERIPH = SITL.with_name("io_periph.toml")
HERE = ("fin stern_port", "fin stern_starboard", "fin rudder_upper", "fin rudder_lower", "pressure", "fix", "n")


@pytest.fixture(scope="module")
def plant(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Plant]:
    with started(tmp_path_factory.mktemp("periph"), "--io", PERIPH) as found:
        yield found


def said_of(found: dict[str, Any], role: str) -> list[str]:
    """The sentences about a role."""
    return [text for text in found["missing"] if role in text.partition(": ")[0].split(", ")]


def test_every_role_of_the_node_is_heard(plant: Plant) -> None:
    found = checked(plant, "--dvl", plant.dvl, file=PERIPH)
    assert found["passed"]
    at_node = {one["role"] for one in found["roles"] if one["device"].startswith(f"node 21 on {plant.bus}")}
    assert at_node == {*HERE}
    assert found["nodes"]["21"] == "org.sternplane.sim.node21"


def test_a_node_that_is_not_there_is_missed_once_for_all_of_its_roles(plant: Plant) -> None:
    file = plant.folder / "other.toml"
    file.write_text(PERIPH.read_text().replace("= 21", "= 44"))
    found = checked(plant, "--dvl", plant.dvl, file=file, status=1)
    [text] = said_of(found, "pressure")
    assert [*text.partition(": ")[0].split(", ")] == [*HERE]
    assert f"nothing heard of node 44 on {plant.bus}" in text
    assert all(key in text for key in ("[nodes] pressure", "[nodes] fix", "[nodes] esc", "[[fins]] node"))
    assert "gnss.Fix2 comes from node 21 (org.sternplane.sim.node21): is that it?" in text


def test_a_role_that_is_at_another_node_too_is_found_there(plant: Plant) -> None:
    file = plant.folder / "part.toml"
    file.write_text(PERIPH.read_text().replace("fix = 21", "fix = 26"))
    [text] = said_of(checked(plant, "--dvl", plant.dvl, file=file, status=1), "fix")
    assert "Fix2 comes from node 21" in text
    assert text.endswith("is it this one too? Then write its id at [nodes] fix.")


def test_the_monitor_shows_it_as_one_node_with_all_of_its_messages(plant: Plant) -> None:
    words = ("can", "monitor", "--bus", plant.bus, "--seconds", "1.5", "--node", "21", "--json")
    [node] = json.loads(tool(plant, *words))["nodes"]
    sends = " ".join(one["type"] for one in node["messages"])
    for kind in ("actuator.Status", "esc.Status", "air_data.StaticPressure", "gnss.Fix2", "NodeStatus"):
        assert kind in sends


def test_its_fins_are_swept_while_its_propeller_rests(plant: Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fins_sweep, "_LISTEN_S", 0.6)
    monkeypatch.setattr(sweep, "SHARES", (1.0,))
    chosen = ("--fin", "rudder_lower", "--travel", "30", "--yes", "--json")
    found = json.loads(tool(plant, "fins", "--sweep", "--io", PERIPH, "--bus", plant.bus, *chosen))
    assert [(one["fin"], one["result"]) for one in found["fins"]] == [("rudder_lower", "well")]
    [n] = [one for one in checked(plant, "--dvl", plant.dvl, file=PERIPH)["roles"] if one["role"] == "n"]
    assert n["value"] == pytest.approx(0.0, abs=0.05)


def test_a_node_that_says_it_does_not_work_is_told_once_with_its_roles(tmp_path: Path) -> None:
    with started(tmp_path, "--io", PERIPH, "--fault", "critical:esc@0") as plant:
        found = checked(plant, "--dvl", plant.dvl, file=PERIPH, status=1)
    assert {one["state"] for one in found["roles"] if one["role"] in HERE} == {"says that it does not work"}
    assert said_of(found, "n") == [
        f"{', '.join(HERE)}: node 21 (org.sternplane.sim.node21) says in its NodeStatus: critical"
    ]
