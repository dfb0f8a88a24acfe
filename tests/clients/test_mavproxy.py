"""MAVProxy over TCP, the vehicle being ArduSub to it: what a person types, what it prints and keeps, what was flown."""

from __future__ import annotations

import contextlib
import json
import re
import socket
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from pymavlink import mavutil
from sternplane.logs.reading import Log

from firmware_py import app, config_files
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import FenceChange, MissionChange, Mode, ParameterChange, RallyChange

from .proxy import Proxy
from .vehicle import changes, flying, free_port, until

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "npsauv2"

ROUTE = """
0 1 0 16 0 0 0 0 36.8 -121.8 300 1
1 0 3 16 0 0 0 0 36.8004 -121.8 -8 1
2 0 3 16 0 0 0 0 36.802 -121.7998 -9 1
3 0 3 18 1 0 40 0 36.8024 -121.7998 -9 1
4 0 0 20 0 0 0 0 0 0 0 1
"""
"""The home first, as ArduPilot's stations have it."""
FENCE = """
0 0 0 5001 4 0 0 0 36.79 -121.81 0 1
1 0 0 5001 4 0 0 0 36.81 -121.81 0 1
2 0 0 5001 4 0 0 0 36.81 -121.79 0 1
3 0 0 5001 4 0 0 0 36.79 -121.79 0 1
4 0 0 5004 30 0 0 0 36.805 -121.8 0 1
"""
RALLY = """
0 0 3 5100 0 0 0 0 36.8002 -121.8002 0 1
"""
PLANS = {"route.txt": ROUTE, "fence.txt": FENCE, "rally.txt": RALLY}
pytestmark = pytest.mark.timeout(300)


class Flown(NamedTuple):
    said: dict[str, re.Match[str]]
    """By MAVProxy, by what was typed."""
    all_said: str
    heard: list[Any]
    """The messages in its tlog."""
    log: Log
    cycles: list[Cycle]
    place: Path
    folder: Path
    earlier: bytes


@pytest.fixture(scope="module")
def flown(place: Path, earlier: bytes) -> Flown:
    folder, port = place / "mavproxy", free_port(socket.SOCK_STREAM)
    folder.mkdir()
    for name, plan in PLANS.items():
        (folder / name).write_text("QGC WPL 110" + plan.replace(" ", "\t"))
    said: dict[str, re.Match[str]] = {}
    with flying(place, f"tcpin:127.0.0.1:{port}") as vehicle, contextlib.ExitStack() as ending:
        proxy = Proxy(f"tcp:127.0.0.1:{port}", folder)
        ending.callback(proxy.end)
        said["begin"] = proxy.says(r"Received (\d+) parameters \(ftp\)")

        def types(line: str, pattern: str) -> None:
            proxy.types(line)
            said[line] = proxy.says(pattern)

        types("param show CTL_Z_DELTA_SW", r"CTL_Z_DELTA_SW +([\d.]+)")
        proxy.types("param set CTL_Z_DELTA_SW 0.3")
        kept = vehicle.state / "parameters.toml"
        until(lambda: kept.exists() and "0.3" in kept.read_text(), "CTL_Z_DELTA_SW in parameters.toml")
        types("param set SAF_DEPTH_MAX 1e9", r"SAF_DEPTH_MAX stays.*")
        types("param fetch", r"Received (\d+) parameters \(ftp\)")
        types("param save all.parm", r"Saved (\d+) parameters")
        types("log list", r"Log 2  numLogs 2 lastLog 2 size (\d+)")
        by_log = folder / "by_log.mcap"
        types(f"log download 1 {by_log}", r"Downloading log 1")
        types("ftp list logs", r"(?s)earlier.mcap\s+(\d+).*flight.mcap\s+(\d+).*Total size")
        types(f"ftp get logs/earlier.mcap {folder / 'by_ftp.mcap'}", r"Wrote (\d+) bytes")
        until(lambda: by_log.exists() and by_log.read_bytes() == earlier, "the log by LOG_DATA")
        types("mode", r"Available modes: (.*)")
        types("mode GUIDED", r"AP: (GUIDED chosen.*)")
        types("fence load fence.txt", r"Sent all (\d+) fence items")
        proxy.says("Got MISSION_ACK: TYPE_FENCE: ACCEPTED")
        proxy.says("fence present")
        types("rally load rally.txt", r"Sent all (\d+) rally items")
        proxy.says("Got MISSION_ACK: TYPE_RALLY: ACCEPTED")
        types("wp load route.txt", r"Sent all (\d+) waypoints")
        proxy.says("Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
        types("wp list", r"(?s)Requesting (\d+) waypoints.*Saved waypoints")
        types("wp save saved.txt", r"Saved (\d+) waypoints to .*saved.txt")
        types("wp set 9", r"AP: (.*refused: the mission has no item 9)")
        types("wp set 2", r"DO_SET_MISSION_CURRENT: ACCEPTED")
        types("arm throttle", r"\bARMED\b")
        types("mode AUTO", r"Mode (\w+)")
        types("mode ALT_HOLD", r"Mode (\w+)")
        types("mode POSHOLD", r"Mode (\w+)")
        types("mode SURFACE", r"Mode (\w+)")
        types("disarm force", r"\bDISARMED\b")
        types("fence list", r"(?s)Requesting (\d+) fence items.*5004 0 36.805.*Saved fence items")
        types("fence clear", r"Got MISSION_ACK: TYPE_FENCE: ACCEPTED")
        proxy.says("fence removed")
        types("wp clear", r"Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
        ending.close()
        log = vehicle.end()
    heard = mavutil.mavlink_connection(str(proxy.tlog))
    return Flown(said, proxy.said, [*iter(heard.recv_msg, None)], log, list(log.cycles), place, folder, earlier)


def test_it_fetches_every_parameter_in_one_file_and_saves_them(flown: Flown) -> None:
    nothing = {**config_files.read_configuration(CONFIG), "mission": {"waypoints": []}}
    expected = {setting.name: setting for setting in app.parameter_store(nothing).settings}
    for typed in ("begin", "param fetch"):
        assert int(flown.said[typed][1]) == len(expected)
    saved = {name: float(value) for name, value in map(str.split, (flown.folder / "all.parm").read_text().splitlines())}
    assert saved.keys() == expected.keys()
    assert saved["CTL_Z_DELTA_SW"] == pytest.approx(0.3, abs=1e-6)
    assert saved["CTL_Z_POLE1"] == pytest.approx(expected["CTL_Z_POLE1"].value, abs=1e-6)


def test_what_it_sets_is_flown_with_and_kept_and_what_is_out_of_bounds_is_refused_by_a_sentence(flown: Flown) -> None:
    assert float(flown.said["param show CTL_Z_DELTA_SW"][1]) == pytest.approx(0.4)
    assert flown.said["param set SAF_DEPTH_MAX 1e9"][0].startswith("SAF_DEPTH_MAX stays 30: 1e+09 is not in [1, 6000]")
    assert changes(flown.log, ParameterChange) == [ParameterChange((("control.depth.delta_sw_rad", 0.3),))]
    kept = tomllib.loads((flown.place / "state" / "parameters.toml").read_text())
    assert kept == {"control": {"depth": {"delta_sw_rad": 0.3}}}


def test_logs_come_byte_for_byte_by_either_way(flown: Flown) -> None:
    sizes = flown.said["ftp list logs"].groups()
    assert int(sizes[0]) == len(flown.earlier)
    assert int(flown.said["log list"][1]) <= int(sizes[1])
    assert (flown.folder / "by_ftp.mcap").read_bytes() == flown.earlier
    assert (flown.folder / "by_log.mcap").read_bytes() == flown.earlier


def test_it_knows_the_modes_by_ardusubs_names_and_sets_them(flown: Flown) -> None:
    assert {"ALT_HOLD", "AUTO", "GUIDED", "POSHOLD", "SURFACE", "MANUAL"} <= set(flown.said["mode"][1].split(", "))
    assert re.fullmatch(r"GUIDED chosen by station 255/\d+; arming begins it", flown.said["mode GUIDED"][1])
    modes = [cycle.mode.mode for cycle in flown.cycles]
    entered = [mode for before, mode in zip([None, *modes], modes, strict=False) if mode is not before]
    assert entered == [*(Mode.DISARMED, Mode.GUIDED, Mode.MISSION, Mode.HOLD, Mode.LOITER, Mode.SURFACE, Mode.DISARMED)]
    for typed in ("mode AUTO", "mode ALT_HOLD", "mode POSHOLD", "mode SURFACE"):
        assert flown.said[typed][1] == typed.split()[1]


def test_a_mission_of_a_file_is_sent_saved_as_it_was_and_flown_from_the_item_that_is_set(flown: Flown) -> None:
    for typed in ("wp load route.txt", "wp list", "wp save saved.txt"):
        assert flown.said[typed][1] == "5"
    sent, saved = (_items(flown.folder / name) for name in ("route.txt", "saved.txt"))
    assert saved == sent
    mission, cleared = (change.mission for change in changes(flown.log, MissionChange))
    assert [waypoint.z for waypoint in mission.waypoints] == [8.0, 9.0]
    assert cleared.waypoints == ()
    flying = [cycle for cycle in flown.cycles if cycle.mode.mode is Mode.MISSION]
    assert {cycle.reference.item for cycle in flying} == {1}
    assert json.loads((flown.place / "state" / "mission.json").read_text()) == {"items": []}


def test_a_fence_and_rally_points_of_files_are_sent_and_the_fence_taken_away_again(flown: Flown) -> None:
    assert flown.said["fence load fence.txt"][1] == flown.said["fence list"][1] == "5"
    assert flown.said["rally load rally.txt"][1] == "1"
    fence, none = changes(flown.log, FenceChange)
    assert fence != none
    assert len(changes(flown.log, RallyChange)) == 1
    assert not re.search("fence breach", flown.all_said)


def _items(path: Path) -> list[list[float]]:
    """All but which item is the current one."""
    rows = [[*map(float, line.split())] for line in path.read_text().splitlines()[1:]]
    return [[*row[:1], *row[2:]] for row in rows]


def test_its_tlog_tells_the_same_flight(flown: Flown) -> None:
    vehicles = [message for message in flown.heard if message.get_srcSystem() == 1]
    beats = [message for message in vehicles if message.get_type() == "HEARTBEAT"]
    assert {beat.type for beat in beats} == {mavutil.mavlink.MAV_TYPE_SUBMARINE}
    assert list(dict.fromkeys(beat.custom_mode for beat in beats)) == [19, 4, 3, 2, 16, 9]
    cycles = {cycle.tick.t_ns // 1_000_000: cycle for cycle in flown.cycles}
    places = [message for message in vehicles if message.get_type() == "LOCAL_POSITION_NED"]
    assert len(places) > 20
    for message in places:
        eta = cycles[message.time_boot_ms].state.eta
        assert (message.x, message.y, message.z) == pytest.approx(eta[:3], abs=1e-4)
