"""A flight in real time, watched and commanded by peers that nobody here wrote: mavutil, and pydronecan's node."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from pymavlink import mavutil
from sternplane.logs.reading import read

from firmware_py.records.order import Arming, Mode
from tests.bus_numbers import free_number
from tests.command import Forked
from tests.sitl.stations import idle

ROOT = Path(__file__).resolve().parents[2]
NODES = {
    10: "org.sternplane.autopilot",
    21: "org.sternplane.sim.servo_hub",
    22: "org.sternplane.sim.esc",
    23: "org.sternplane.sim.ahrs",
    24: "org.sternplane.sim.pressure",
    25: "org.sternplane.sim.altimeter",
    26: "org.sternplane.sim.fix",
    27: "org.sternplane.sim.battery",
}


class Flight(NamedTuple):
    folder: Path
    bus_number: int
    station: Any
    """mavutil's link to the vehicle."""


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Flight]:
    """A vehicle and its plant, in two processes and in real time; the vehicle talks to a station."""
    place = tmp_path_factory.mktemp("watched")
    scenario = place / "idle.toml"
    scenario.write_text(idle(300.0))
    folder = place / "run"
    station = mavutil.mavlink_connection("udpin:127.0.0.1:0")
    link = f"udpout:127.0.0.1:{station.port.getsockname()[1]}"
    with free_number() as number, contextlib.closing(station):
        arguments = ["--scenario", scenario, "--bus", f"udp:{number}", "--pace", "realtime", "--out", folder]
        with contextlib.closing(Forked("sitl", *arguments, "--gcs", link, cwd=place)):
            yield Flight(folder, number, station)


def test_mavutil_hears_a_submarine_arms_it_and_sets_its_mode(flight: Flight) -> None:
    station = flight.station

    def heard(kind: str, wanted=lambda message: True, seconds: float = 30.0):
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            message = station.recv_match(type=kind, blocking=True, timeout=1.0)
            if message is not None and wanted(message):
                return message
        raise AssertionError(f"no {kind} as it should be within {seconds:g} s")

    armed_bit = mavutil.mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    beat = heard("HEARTBEAT")
    assert beat.type == mavutil.mavlink.MAV_TYPE_SUBMARINE
    assert not beat.base_mode & armed_bit
    assert abs(heard("ATTITUDE").roll) < 0.1
    assert abs(heard("GLOBAL_POSITION_INT").relative_alt) < 1000

    ahrs = mavutil.mavlink.MAV_SYS_STATUS_AHRS
    heard("SYS_STATUS", lambda m: m.onboard_control_sensors_health & ahrs)  # before that, arming is refused
    station.target_system, station.target_component = beat.get_srcSystem(), beat.get_srcComponent()
    station.arducopter_arm()
    answer = heard("COMMAND_ACK", lambda m: m.command == mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM)
    assert answer.result == mavutil.mavlink.MAV_RESULT_ACCEPTED
    heard("HEARTBEAT", lambda m: m.base_mode & armed_bit)
    station.set_mode("ALT_HOLD")  # ArduSub's name of depth hold
    heard("HEARTBEAT", lambda m: m.custom_mode == 2)
    station.arducopter_disarm()
    heard("HEARTBEAT", lambda m: not m.base_mode & armed_bit)

    log = read(flight.folder / "log.mcap")  # still being written: what has reached the disk
    modes = [cycle.mode.mode for cycle in log.cycles]
    orders = [cycle.order.arming for cycle in log.cycles]
    assert Mode.MANUAL in modes
    assert Arming.ARM in orders


def test_pydronecans_node_monitor_lists_every_node_with_its_name(flight: Flight) -> None:
    script = ROOT / "tests" / "contract" / "foreign_node.py"
    names: dict[int, str] = {}
    words = [sys.executable, script, str(flight.bus_number)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as monitor:
        deadline = time.monotonic() + 60.0
        for line in monitor.stdout:  # the commands that it hears come as well, so it is never silent for long
            said = json.loads(line)
            if "node" in said:
                names[said["node"]] = said["name"]
            if NODES.items() <= names.items() or time.monotonic() > deadline:
                break
        monitor.stdin.close()  # it ends by itself then, and with it the process that its driver runs in
    assert NODES.items() <= names.items(), names
