"""Flights over the kernel's CAN: with the plant in a process of its own, and through an outage of the interface."""

from __future__ import annotations

import contextlib
import gc
import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from sternplane.cli.main import main
from sternplane.logs.reading import read
from sternplane.logs.summary import summarise
from sternplane.sitl.flight import CONFIG, FlightRequest, fly, prepare

from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.storage.recorder import LogRecorder, LogWriter
from firmware_py.records.event_text import texts
from firmware_py.records.order import Mode
from firmware_py.run import over_can
from firmware_py.run.session import Session
from firmware_py.wire.dronecan.message_table import ARRAY_COMMAND
from firmware_py.wire.dronecan.transfer import Reassembler
from sim_bridge.scripted_operator import ScriptedOperator
from tests.contract.bus_contract import PATIENCE, doors
from tests.shared_flights import LEARNING_OFF

pytestmark = pytest.mark.vcan
BUS = "socketcan:vcan0"
COMMANDS = 0x0803F20A
"""ArrayCommand (1010) of node 10 at priority 8."""
MISSION = """
description = "Dive, pass a waypoint and turn to the next, in a current with eddies."
duration_s = 16.0
completes = "time"
[environment]
current_ned_m_s = [0.06, 0.08, 0.0]
turbulence_m_s = 0.03
[start]
u_m_s = 1.8
n_rpm = 492.0
[[orders]]
t_s = 0.5
arming = "arm"
[[orders]]
t_s = 0.6
mode = "mission"
[[waypoints]]
x_m = 20.0
y_m = 0.0
depth_m = 2.0
speed_m_s = 1.8
[[waypoints]]
x_m = 60.0
y_m = 60.0
depth_m = 4.0
speed_m_s = 1.8
"""
HOLD = """
description = "A straight run."
duration_s = 6.0
completes = "time"
[start]
depth_m = 5.0
u_m_s = 1.8
n_rpm = 492.0
[[orders]]
t_s = 0.2
arming = "arm"
mode = "hold"
speed_m_s = 1.8
"""


@pytest.fixture(autouse=True)
def interfaces():
    assert os.environ.get("VCAN_ACTIVE"), "no SocketCAN interfaces here; run these by: make test-vcan"


@contextlib.contextmanager
def dumped(can_id: int, path: Path) -> Iterator[None]:
    """Let candump write the frames with this id to a file."""
    with path.open("wb") as file:
        candump = subprocess.Popen(["candump", "-L", f"vcan0,{can_id:08X}:1FFFFFFF"], stdout=file)
    try:
        deadline = time.monotonic() + PATIENCE
        while f" {can_id:x} " not in Path("/proc/net/can/rcvlist_fil").read_text():
            assert candump.poll() is None
            assert time.monotonic() < deadline, "candump does not listen"
            time.sleep(0.01)
        yield
    finally:
        candump.terminate()
        candump.wait(timeout=10)


@contextlib.contextmanager
def plant(scenario: Path, dvl: Path) -> Iterator[None]:
    """Run `sternplane plant` in a process of its own, forked: in a user-mode Linux, imports take half a minute."""
    words = ["plant", "--scenario", str(scenario), "--bus", BUS, "--dvl", str(dvl)]
    process = multiprocessing.get_context("fork").Process(target=lambda: sys.exit(main(words)))
    gc.freeze()  # else the plant's collection before tick 0 would copy all that was imported: seconds
    process.start()
    try:
        yield
        process.join(PATIENCE)
        assert process.exitcode == 0
    finally:
        process.kill()
        process.join()


def until_frames_flow() -> None:
    """Return when vcan0 carries frames again: the kernel drops some for milliseconds after it is set up."""
    probe = (0x1F000005, b"")
    with doors(BUS) as (a, b):
        deadline = time.monotonic() + PATIENCE
        while probe not in b.drain(100, 0.01):
            assert time.monotonic() < deadline, "vcan0 carries nothing"
            a.send([probe])


def commanded_fins(path: Path) -> list[list[float]]:
    """The angles of every command to the fins that candump wrote, rad."""
    reassembler, found = Reassembler([ARRAY_COMMAND]), []
    for line in path.read_text().splitlines():
        can_id, data = line.split()[2].split("#")
        transfer = reassembler.accept(int(can_id, 16), bytes.fromhex(data), 0.0)
        if transfer is not None:
            found.append([command.command_value for command in ARRAY_COMMAND.decode(transfer.payload).commands])
    return found


def test_a_mission_flies_over_vcan0_as_it_does_in_one_process_and_candump_sees_the_fins(tmp_path):
    scenario = tmp_path / "mission.toml"
    scenario.write_text(MISSION)
    wish, dvl, losses = FlightRequest(scenario=str(scenario)), tmp_path / "dvl", LossWatch()
    flight = prepare(wish, {})
    with LogWriter(tmp_path / "log.mcap", flight.header()) as writer:
        operator, recorder = ScriptedOperator(flight.scenario), LogRecorder(writer)
        with dumped(COMMANDS, tmp_path / "dump"), plant(scenario, dvl):
            session = Session(operator, recorder, lambda: False, print, losses)
            wiring = over_can.Wiring(flight.io, BUS, str(dvl), "bus")
            over_can.run(flight.autopilot, flight.configuration, wiring, session)
        lost = losses.totals()
        writer.close({"losses": lost})
    assert fly(prepare(wish, {}), tmp_path / "virtual.mcap").completed
    log, virtual = read(tmp_path / "log.mcap"), read(tmp_path / "virtual.mcap")
    assert len(log.cycle_bytes) == 1600
    assert log.cycle_bytes == virtual.cycle_bytes
    assert log.columns["reference.waypoint"][-1] == 1
    assert lost["bus_not_sent"] == 0
    assert not any(lost.values()), lost
    fins = log.columns["applied.fins"]
    assert np.ptp(fins, axis=0).min() > 0.05
    commanded, applied = np.array(commanded_fins(tmp_path / "dump")), fins[::2]  # 50 times a second
    assert commanded.shape == applied.shape
    # Each is rounded to float32 and then to float16: by half a step of both at most.
    single, half = (np.spacing(abs(applied).astype(to)).astype(float) for to in (np.float32, np.float16))
    assert np.all(abs(commanded - applied) <= single / 2.0 + half / 2.0)


def test_an_interface_that_goes_down_and_up_in_flight_is_a_gap_that_the_vehicle_survives(tmp_path):
    scenario = tmp_path / "hold.toml"
    scenario.write_text(HOLD + LEARNING_OFF)
    down, up = 200, 225

    def watch(cycle):
        if cycle.tick.k == down:
            subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
        elif cycle.tick.k == up:
            subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
            until_frames_flow()

    flight = prepare(FlightRequest(scenario=str(scenario), bus=BUS), {})
    outcome = fly(flight, tmp_path / "log.mcap", watch)
    log = read(tmp_path / "log.mcap")
    assert outcome.completed, outcome.reason
    heard = log.columns["frame.ahrs.fresh"]
    assert heard[10 : down + 1].all()
    assert not heard[down + 1 : up + 1].any()
    assert heard[up + 1 :].all()  # and all is as before
    assert set(log.columns["mode.mode"][50:].tolist()) == {Mode.HOLD}
    lost = summarise(log)["losses"]
    assert (lost["bus_failed_drains"], lost["bus_overrun"]) == (1, 0)
    assert lost["bus_not_sent"] == 12 * 4  # in every second cycle, 3 frames to the fins and 1 to the propeller


def test_fin_drives_on_an_interface_of_their_own_are_lost_with_it_alone_and_started_up_again(tmp_path):
    scenario, io = tmp_path / "hold.toml", tmp_path / "io.toml"
    scenario.write_text(HOLD.replace("t_s = 0.2", "t_s = 0.8") + LEARNING_OFF)
    io.write_text((CONFIG / "io_canopen.toml").read_text().replace('bus = ""  ', 'bus = "socketcan:vcan4"  '))
    down, up, told = 200, 280, []

    def watch(cycle):
        told.extend(texts(cycle.events))
        if cycle.tick.k in (down, up):
            subprocess.run(["ip", "link", "set", "vcan4", "down" if cycle.tick.k == down else "up"], check=True)

    subprocess.run(["ip", "link", "add", "dev", "vcan4", "type", "vcan"], check=True)
    try:
        subprocess.run(["ip", "link", "set", "vcan4", "up"], check=True)
        flight = prepare(FlightRequest(scenario=str(scenario), bus=BUS, io=io), {})
        outcome = fly(flight, tmp_path / "log.mcap", watch)
    finally:
        subprocess.run(["ip", "link", "del", "vcan4"], check=True)
    log = read(tmp_path / "log.mcap")
    assert outcome.completed, outcome.reason
    silent = 10 + np.flatnonzero(~log.columns["frame.ahrs.fresh"][10:])
    # The kernel delivers frames late for milliseconds after an interface is set, on all of them.
    assert all(0 < k - down <= 10 or 0 < k - up <= 10 for k in silent), silent
    cycles = list(log.cycles)
    assert all(heard.ok for heard in cycles[down].frame.fins)
    assert not any(heard.fresh for cycle in cycles[down + 2 : up] for heard in cycle.frame.fins)
    assert all(heard.ok for heard in cycles[-1].frame.fins)
    assert "second bus: it is down, off or error-passive" in told
    assert "second bus is sound again" in told
    lost = summarise(log)["losses"]
    assert lost["bus_not_sent"] == lost["bus_failed_drains"] == 0
    assert (lost["stern_port_timeouts"], lost["second_bus_failed_drains"]) == (1, 1)
