"""Missions, fence and rally points over real UDP that loses packets, and after a restart; pymavlink is the station.

Vehicle and station take turns, tick by tick, so that no other work of the machine can starve either.
"""

from __future__ import annotations

import contextlib
import random
import signal
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any, TypeAlias

from pymavlink import mavutil, mavwp
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from sternplane.logs.reading import read
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.records.cycle import Cycle
from firmware_py.run.ground_links import open_ground

SCENARIO = """
description = "Lies at the surface until it is ended."
duration_s = 300.0
completes = "time"
[autopilot.estimation.learning]
enabled = false
"""
MISSION, FENCE, RALLY = range(3)
COUNT = 60
PATIENCE = 30
"""Ticks after which the station says again what was not answered."""
LOADERS = (mavwp.MAVWPLoader, mavwp.MissionItemProtocol_Fence, mavwp.MissionItemProtocol_Rally)
Talk: TypeAlias = Generator[None, None, Any]
"""What the station does, a tick at each `yield`."""


class Lossy:
    """mavutil's link over which a share of the messages is lost, each way."""

    def __init__(self, station: Any, share: float) -> None:
        self.station, self.share = station, share
        self.chance = random.Random(5)

    def send(self, message: Any) -> None:
        if self.chance.random() >= self.share:
            self.station.mav.send(message)

    def recv(self, *kinds: str) -> Generator[None, None, Any]:
        """The next message of these kinds that comes through; None after a while."""
        for _ in range(PATIENCE):
            while (message := self.station.recv_match(type=[*kinds])) is not None:
                if self.chance.random() >= self.share:
                    return message
            yield
        return None


def flight(folder: Path, state: Path, talk: Callable[[Lossy], Talk], share: float = 0.0) -> None:
    """A vehicle that flies until the station has said what it has to say, and is ended as by a person."""
    folder.mkdir()
    scenario = folder / "idle.toml"
    scenario.write_text(SCENARIO)
    with contextlib.closing(mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255)) as station:
        says = talk(Lossy(station, share))

        ended = object()

        def turn(_: Cycle) -> None:
            if next(says, ended) is ended:
                signal.raise_signal(signal.SIGINT)

        ready = prepare(FlightRequest(scenario=str(scenario), state=state), {})
        link = f"udpout:127.0.0.1:{station.port.getsockname()[1]}:generic"
        with open_ground([link], ready.configuration, state=state) as stations:
            stations.save_changes_in(state, folder)
            assert fly(ready, folder / "log.mcap", turn, stations.merged_with).reason == "interrupted"


def upload(link: Lossy, loader: Any, kind: int) -> Talk:
    """The result."""
    items = loader.wpoints
    said = mavlink.MAVLink_mission_count_message(1, 1, len(items), kind)
    link.send(said)
    for _ in range(20 * len(items) + 100):
        m = yield from link.recv("MISSION_REQUEST_INT", "MISSION_ACK")
        if m is not None and m.mission_type != kind:
            continue
        if m is not None and m.get_type() == "MISSION_ACK":
            return m.type
        if m is not None:
            said = items[m.seq]
        link.send(said)
    raise AssertionError("no MISSION_ACK")


def download(link: Lossy, kind: int) -> Talk:
    """mavwp's list of what the vehicle has."""
    loader, count = LOADERS[kind](1, 1), -1
    asked = mavlink.MAVLink_mission_request_list_message(1, 1, kind)
    link.send(asked)
    for _ in range(20 * COUNT + 100):
        m = yield from link.recv("MISSION_COUNT", "MISSION_ITEM_INT")
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


def test_plans_that_came_over_a_lossy_link_are_there_after_a_restart(tmp_path: Path) -> None:
    state, sent = tmp_path / "state", plans()

    def first(link: Lossy) -> Talk:
        for kind, loader in enumerate(sent):
            assert (yield from upload(link, loader, kind)) == mavlink.MAV_MISSION_ACCEPTED
        assert content((yield from download(link, MISSION))) == content(sent[MISSION])

    def second(link: Lossy) -> Talk:
        for kind, loader in enumerate(sent):
            assert content((yield from download(link, kind))) == content(loader)
        while (m := (yield from link.recv("MISSION_CURRENT"))) is None:
            pass
        assert m.total == COUNT

    flight(tmp_path / "first", state, first, share=0.1)
    assert {"fence.json", "mission.json", "rally.json"} <= {path.name for path in state.iterdir()}
    flight(tmp_path / "second", state, second)
    configuration = read(tmp_path / "second" / "log.mcap").header["configuration"]
    assert len(configuration["mission"]["waypoints"]) == COUNT
    assert configuration["fence"]["within"][0][2] == 5000.0
    assert len(configuration["rally"]["points"]) == 3
