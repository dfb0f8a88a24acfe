"""Who is who on the wires: the shipped files, and ids that are given twice."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path

import pytest

from firmware_py.adapters.io_params import IoParams
from firmware_py.params import ParamError, load

FILES = sorted((Path(__file__).resolve().parents[4] / "configs").glob("*/io_*.toml"))
TABLE = tomllib.loads(next(path for path in FILES if path.name == "io_sitl.toml").read_text())


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_every_shipped_file_can_be_read(path: Path) -> None:
    assert load(IoParams, tomllib.loads(path.read_text()), str(path)).can.node_id == 10


def test_the_example_for_the_sea_names_real_wires() -> None:
    path = next(path for path in FILES if path.name == "io_sea.toml")
    io = load(IoParams, tomllib.loads(path.read_text()), str(path))
    assert io.can.bus == "socketcan:can0"
    assert (io.dvl.port, io.dvl.baud) == ("/dev/ttyUSB0", 115200)


@pytest.mark.parametrize(
    ("place", "key", "node_id", "words"),
    [
        ("nodes", "ahrs", 10, "io.toml: nodes.ahrs = 10: is can.node_id already; every node needs an id of its own"),
        ("nodes", "battery", 125, "io.toml: nodes.battery = 125: is can.plant_id already"),
        ("can", "node_id", 21, "io.toml: nodes.servo_hub = 21: is can.node_id already"),
        ("can", "plant_id", 10, "io.toml: can.plant_id = 10: is can.node_id already"),
        ("nodes", "esc", 23, "io.toml: nodes: esc and ahrs have the same node id 23"),
    ],
)
def test_an_id_that_is_given_twice_is_refused(place: str, key: str, node_id: int, words: str) -> None:
    table = copy.deepcopy(TABLE)
    table[place][key] = node_id
    with pytest.raises(ParamError) as caught:
        load(IoParams, table, "io.toml")
    assert str(caught.value).startswith(words)
