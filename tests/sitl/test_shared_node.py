"""Flights with one simulated node that steers, drives, tells depth and position, and with a node for each of these."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.losses import losses
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.installation import configs
from firmware_py.app import build
from firmware_py.records.event import EventKind
from firmware_py.records.event_text import texts
from tests.straight_run import hold, under_way

PERIPH = configs() / "npsauv2" / "io_periph.toml"
ROLES = {"esc": 22, "pressure": 24, "fix": 26}
LISTED = "node servo_hub, esc, pressure, fix"


def flight(folder: Path, *faults: str, io: Path = PERIPH, name: str = "log", seconds: float = 12.0) -> Log:
    scenario = folder / f"{name}.toml"
    scenario.write_text(under_way(seconds, 8.0, hold(8.0), faults=faults))
    fly(prepare(FlightRequest(str(scenario), io=io), {}), folder / f"{name}.mcap")
    return read(folder / f"{name}.mcap")


def told(log: Log) -> list[tuple[float, str]]:
    kinds = (EventKind.NODE_FAULT, EventKind.NODE_GOOD, EventKind.NODE_RESTARTED)
    return [(round(t, 1), texts((one,))[0]) for t, events in log.events for one in events if one.kind in kinds]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return flight(tmp_path_factory.mktemp("sound"))


def test_the_vehicle_goes_exactly_as_with_a_node_for_each_role(tmp_path: Path, sound: Log) -> None:
    text = PERIPH.read_text()
    for role, node_id in ROLES.items():
        text = text.replace(f"{role} = 21", f"{role} = {node_id}")
    apart = tmp_path / "io_apart.toml"
    apart.write_text(text)
    alone = flight(tmp_path, io=apart)
    assert "shared_nodes" not in alone.header["configuration"]
    assert len(sound.header["configuration"]["shared_nodes"]) == 1
    assert all(np.array_equal(sound.truth[name], alone.truth[name], equal_nan=True) for name in alone.truth)
    assert all(np.array_equal(sound.columns[name], alone.columns[name], equal_nan=True) for name in alone.columns)
    assert told(sound) == told(alone) == []


def test_a_node_that_says_it_does_not_work_is_told_once_and_its_fins_are_not_believed(tmp_path: Path) -> None:
    log = flight(tmp_path, "critical:esc@4+3")
    assert told(log) == [
        (4.0, f"{LISTED}: it reports that it does not work"),
        (7.0, f"{LISTED} is sound again"),
    ]
    c = log.columns
    during = (c["t"] > 4.1) & (c["t"] < 6.9)
    for name in ("pressure", "n", "fix"):
        assert not c[f"frame.{name}.ok"][during].any()
    assert not c["frame.fins.ok"][during].any()
    assert c["frame.ahrs.ok"][during].all()
    assert replay(log, build).differing == 0


def test_a_second_speaker_and_a_restart_are_told_once(tmp_path: Path) -> None:
    off = [f"off:{role}@9+1.5" for role in ("servo_hub", *ROLES)]
    log = flight(tmp_path, "duplicate:pressure=5000@2+1", *off, seconds=16.0)
    second, gone, restart = told(log)
    assert second[1] == f"{LISTED}: two senders under one node id"
    assert 2.0 < second[0] < 2.5
    assert gone[1] == f"{LISTED} is sound again"
    assert restart[1] == f"{LISTED} has restarted"
    assert {name for name, n in losses(log).items() if n and "restarts" in name} == {"node21_restarts"}


def test_a_speed_controller_that_fails_leaves_the_rest_of_its_node_alone(tmp_path: Path) -> None:
    log = flight(tmp_path, "off:esc@4")
    c, t = log.columns, log.columns["t"]
    assert not c["frame.n.fresh"][t > 4.1].any()
    assert log.truth["n"][-1] == pytest.approx(0.0, abs=0.5)
    for name in ("pressure", "fix"):
        assert c[f"frame.{name}.fresh"][t > 4.1].any()
    assert c["frame.fins.fresh"][t > 4.1].any(axis=0).all()
    assert told(log) == []
