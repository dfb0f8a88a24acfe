"""Missions, fence and rally points over real UDP that loses packets, and after a restart; pymavlink is the station."""

from __future__ import annotations

import contextlib
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavwp
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.sitl.stations import flight
from tools.log import read

MISSION, FENCE, RALLY = range(3)
COUNT = 60
LOADERS = (mavwp.MAVWPLoader, mavwp.MissionItemProtocol_Fence, mavwp.MissionItemProtocol_Rally)


class Lossy:
    """mavutil's link over which every tenth message is lost, each way."""

    def __init__(self, station: Any, share: float) -> None:
        self.station, self.share = station, share
        self.chance = random.Random(5)

    def send(self, message: Any) -> None:
        if self.chance.random() >= self.share:
            self.station.mav.send(message)

    def recv(self, *kinds: str) -> Any:
        """The next message of these kinds that comes through; None after a while."""
        while True:
            message = self.station.recv_match(type=[*kinds], blocking=True, timeout=0.3)
            if message is None or self.chance.random() >= self.share:
                return message


@contextlib.contextmanager
def lossy_flight(folder: Path, state: Path, share: float = 0.0) -> Iterator[Lossy]:
    """A vehicle in real time with its station."""
    with flight(folder, state, "generic") as station:
        yield Lossy(station, share)


def upload(link: Lossy, loader: Any, kind: int) -> int:
    """The result."""
    items = loader.wpoints
    said = mavlink.MAVLink_mission_count_message(1, 1, len(items), kind)
    link.send(said)
    for _ in range(20 * len(items) + 100):
        m = link.recv("MISSION_REQUEST_INT", "MISSION_ACK")
        if m is not None and m.mission_type != kind:
            continue
        if m is not None and m.get_type() == "MISSION_ACK":
            return m.type
        if m is not None:
            said = items[m.seq]
        link.send(said)
    raise AssertionError("no MISSION_ACK")


def download(link: Lossy, kind: int) -> Any:
    """mavwp's list of what the vehicle has."""
    loader, count = LOADERS[kind](1, 1), -1
    asked = mavlink.MAVLink_mission_request_list_message(1, 1, kind)
    link.send(asked)
    for _ in range(20 * COUNT + 100):
        m = link.recv("MISSION_COUNT", "MISSION_ITEM_INT")
        if m is not None and m.mission_type != kind:
            continue
        if m is not None and m.get_type() == "MISSION_COUNT":
            count = m.count
        elif m is not None and m.seq == loader.count():
            loader.add(m)
        if loader.count() == count:
            link.send(mavlink.MAVLink_mission_ack_message(1, 1, 0, kind))
            return loader
        if count >= 0:
            asked = mavlink.MAVLink_mission_request_int_message(1, 1, loader.count(), kind)
        link.send(asked)
    raise AssertionError(f"{loader.count()} of {count} items came")


def item(seq: int, command: int, kind: int, *params: float, z: float = 0.0) -> Any:
    filled = (*params, *(0.0,) * (4 - len(params)))
    x, y = round((36.8 + seq * 1e-5) * 1e7), round((-121.8 + (seq * 37 % 101) * 1e-5) * 1e7)
    return mavlink.MAVLink_mission_item_int_message(1, 1, seq, 3, command, 0, 1, *filled, x, y, z, kind)


def plans() -> list[Any]:
    loaders = [cls(1, 1) for cls in LOADERS]
    for i in range(COUNT):
        loaders[MISSION].add(item(i, mavlink.MAV_CMD_NAV_WAYPOINT, MISSION, z=-1.0 - i % 20))
    loaders[FENCE].add(item(0, mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, FENCE, 5000.0))
    for i in range(3):
        loaders[RALLY].add(item(i, mavlink.MAV_CMD_NAV_RALLY_POINT, RALLY))
    return loaders


def content(loader: Any) -> list[tuple[Any, ...]]:
    return [(m.seq, m.frame, m.command, m.param1, m.x, m.y, m.z, m.mission_type) for m in loader.wpoints]


@pytest.mark.timeout(300)
def test_plans_that_came_over_a_lossy_link_are_there_after_a_restart(tmp_path: Path) -> None:
    state, sent = tmp_path / "state", plans()
    with lossy_flight(tmp_path / "first", state, share=0.1) as link:
        for kind, loader in enumerate(sent):
            assert upload(link, loader, kind) == mavlink.MAV_MISSION_ACCEPTED
        assert content(download(link, MISSION)) == content(sent[MISSION])
    assert {"fence.json", "mission.json", "rally.json"} <= {path.name for path in state.iterdir()}

    with lossy_flight(tmp_path / "second", state) as link:
        for kind, loader in enumerate(sent):
            assert content(download(link, kind)) == content(loader)
        m = link.recv("MISSION_CURRENT")
        assert m.total == COUNT
    configuration = read(tmp_path / "second" / "log.mcap").header["configuration"]
    assert len(configuration["mission"]["waypoints"]) == COUNT
    assert configuration["fence"]["within"][0][2] == 5000.0
    assert len(configuration["rally"]["points"]) == 3
