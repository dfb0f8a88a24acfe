"""Plant and vehicle as two processes on a real bus between them: lockstep, and everything that can break it."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.reading import read
from sternplane.logs.replay import replay

from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from firmware_py.adapters.lockstep.lockstep_link import HELLO, VERSION, LockstepLink
from firmware_py.app import build
from firmware_py.wire.dronecan.message_table import TICK, TICK_DONE
from firmware_py.wire.dronecan.node_messages import LockstepTick, LockstepTickDone
from tests.command import called
from tests.shared_flights import Flights
from tests.sitl.conftest import Start
from tests.straight_run import under_way

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def bus(bus_spec: str) -> Iterator[CanBus]:
    opened = open_bus(bus_spec)
    yield opened
    opened.close()


def until_heard(bus: CanBus, source: int, seconds: float = 60.0) -> None:
    """Waits until a node is heard on the bus: its process is at work."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if any(can_id & 0x7F == source for can_id, _ in bus.drain(1000, 0.1)):
            return
    raise AssertionError(f"node {source} was not heard for {seconds:g} s")


def test_two_processes_give_the_cycles_that_one_gives_byte_for_byte(
    flown: Flights, dive: Path, tmp_path: Path, bus_spec: str
) -> None:
    result = called("sitl", "--scenario", dive, "--bus", bus_spec, "--out", "two", cwd=tmp_path)
    assert result.returncode == 0, result.stderr + result.stdout
    _, one = flown(dive.read_text())
    two = read(tmp_path / "two" / "log.mcap")
    assert len(one.cycle_bytes) == 1200
    assert two.cycle_bytes == one.cycle_bytes
    assert two.topics["/truth"].messages == one.topics["/truth"].messages
    assert two.end["losses"]
    assert two.end["losses"].items() <= one.end["losses"].items()


def test_a_run_in_real_time_in_two_processes_is_replayed_byte_for_byte(
    dive: Path, tmp_path: Path, bus_spec: str
) -> None:
    late = "[autopilot.safety]\nlate_max = 1000  # on a machine that tests share with others\n"
    dive.write_text(dive.read_text().replace("12.0", "4.0") + late)
    result = called("sitl", "--scenario", dive, "--bus", bus_spec, "--pace", "realtime", "--out", "run", cwd=tmp_path)
    assert result.returncode == 0, result.stderr + result.stdout
    log = read(tmp_path / "run" / "log.mcap")
    assert any(cycle.tick.late_ns > 0 for cycle in log.cycles)
    assert sum(cycle.frame.ahrs.fresh for cycle in log.cycles) > 200
    compared = replay(log, build)
    assert compared.equal, str(compared)


@pytest.mark.parametrize("killed", ["plant", "fly"])
def test_one_side_killed_in_lockstep_ends_the_other_with_its_name_and_a_readable_log(
    tmp_path: Path, bus_spec: str, bus: CanBus, start: Start, killed: str
) -> None:
    dvl = tmp_path / "dvl"
    plant = start("plant", "--bus", bus_spec, "--dvl", dvl, "--out", "plant")
    fly = start("fly", "--bus", bus_spec, "--pace", "bus", "--dvl", dvl, "--out", "vehicle")
    until_heard(bus, 22)  # the propeller's controller reports: they fly
    victim, other = (plant, fly) if killed == "plant" else (fly, plant)
    victim.kill()
    out, err = other.communicate(timeout=20)
    victim.communicate(timeout=20)
    assert other.returncode == 1, out + err
    assert f"the {'plant' if killed == 'plant' else 'vehicle'} has been silent for 4 s" in err
    log = read(tmp_path / "vehicle" / "log.mcap")
    assert log.complete == (killed == "plant")
    if killed == "plant":
        assert "silent" in log.end["reason"]
        assert log.end["losses"]["transfers_malformed"] == 0


def test_a_bus_on_which_our_nodes_speak_is_refused_with_who_was_heard(
    tmp_path: Path, bus_spec: str, bus: CanBus, start: Start
) -> None:
    first = start("plant", "--bus", bus_spec, "--dvl", tmp_path / "a", "--pace", "realtime")
    try:
        until_heard(bus, 22)
        second = start("plant", "--bus", bus_spec, "--dvl", tmp_path / "b")
        _, err = second.communicate(timeout=60)
        assert second.returncode == 2
        assert err.count("\n") == 1
        assert f"{bus_spec} is in use by" in err
        assert "org.sternplane.sim.esc" in err
    finally:
        first.send_signal(signal.SIGTERM)
        _, err = first.communicate(timeout=20)
    assert first.returncode == 0, err
    assert not os.path.lexists(tmp_path / "a")


@pytest.mark.parametrize(
    ("hello", "words"),
    [
        (LockstepTick(HELLO, 10_000_000, 0, VERSION + 1), ("version 2", "version 1")),
        (LockstepTick(HELLO, 20_000_000, 0, VERSION), ("20 ms", "10 ms")),
        (LockstepTick(17, 0, 0, VERSION), ("already flying",)),
    ],
)
def test_a_plant_of_another_kind_is_refused(
    bus_spec: str, bus: CanBus, start: Start, hello: LockstepTick, words: tuple[str, ...]
) -> None:
    link = LockstepLink(bus, 125, [10])
    fly = start("fly", "--bus", bus_spec, "--pace", "bus", "--dvl", "none")
    for _ in range(300):  # 30 s
        link.send_message(TICK, hello)
        link.receive_message(TICK_DONE, 0.1)
        if fly.returncode is not None:
            break
    _, err = fly.communicate(timeout=20)
    assert fly.returncode == 1, err
    assert all(word in err for word in words), err


def test_a_frame_that_is_lost_ends_the_run_and_says_so(
    tmp_path: Path, bus_spec: str, bus: CanBus, start: Start
) -> None:
    line = tmp_path / "dvl"
    master, slave = os.openpty()
    os.symlink(os.ttyname(slave), line)
    link = LockstepLink(bus, 125, [10])
    fly = start("fly", "--bus", bus_spec, "--pace", "bus", "--dvl", line)
    for _ in range(300):
        link.send_message(TICK, LockstepTick(HELLO, 10_000_000, 0, VERSION))
        done = link.receive_message(TICK_DONE, 0.1)
        if done is not None and done.k == HELLO:
            break
    link.send_message(TICK, LockstepTick(0, 0, 0, VERSION))
    assert link.receive_message(TICK_DONE, 10.0) == LockstepTickDone(0, 9)  # the time, two commands, five states
    link.send_message(TICK, LockstepTick(1, 10_000_000, 3, VERSION))  # three frames that nobody sent
    _, err = fly.communicate(timeout=20)
    assert fly.returncode == 1
    assert "0 frames came for tick 1, the plant sent 3" in err
    os.close(master)
    os.close(slave)


def test_a_plant_that_dies_in_real_time_is_the_supervisors_affair(
    tmp_path: Path, bus_spec: str, bus: CanBus, start: Start
) -> None:
    dvl = tmp_path / "dvl"
    plant = start("plant", "--bus", bus_spec, "--dvl", dvl, "--pace", "realtime")
    until_heard(bus, 22)
    fly = start("fly", "--bus", bus_spec, "--dvl", dvl, "--out", "vehicle")
    until_heard(bus, 10)
    plant.kill()
    plant.communicate(timeout=20)
    for _ in range(100):  # at 50 Hz, 2 s of commands after the plant's death
        until_heard(bus, 10)
    fly.send_signal(signal.SIGINT)
    out, err = fly.communicate(timeout=20)
    assert fly.returncode == 0, out + err
    log = read(tmp_path / "vehicle" / "log.mcap")
    assert log.complete
    assert not list(log.cycles)[-1].state.attitude_ok


def test_the_truth_of_a_plant_that_began_long_before_is_compared_with_the_vehicles_time(
    tmp_path: Path, bus_spec: str, bus: CanBus, start: Start
) -> None:
    dvl, water = tmp_path / "dvl", tmp_path / "water.toml"
    water.write_text(under_way(60.0, 8.0, eddies=0.5))
    words = ("--bus", bus_spec, "--dvl", dvl)
    plant = start("plant", *words, "--pace", "realtime", "--scenario", water, "--out", "run")
    for _ in range(100):  # a second at least
        until_heard(bus, 22)
    fly = start("fly", *words, "--out", "run")
    until_heard(bus, 10)
    for _ in range(500):  # some seconds
        until_heard(bus, 10)
    for process in (fly, plant):
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
    log = read(tmp_path / "run" / "log.mcap")
    c, truth = log.columns, log.truth
    r, true_r = c["frame.ahrs.value.r"], truth["nu.r"]
    heard = c["frame.ahrs.fresh"] & (c["t"] > 0.5)
    assert heard.sum() > 100
    assert np.std(r[heard] - true_r[heard]) < 0.4 * np.std(true_r[heard])  # by eddies
