"""Three ground stations of pymavlink's, each with a link, a thread and a task; all of them want all telemetry."""

from __future__ import annotations

import math
import os
import socket
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

from pymavlink import mavftp, mavutil  # type: ignore[import-untyped]

from firmware_py.mavlink.telemetry.streams import DEFAULT_STREAMS

mavlink = mavutil.mavlink
VEHICLE = (1, 1)
_INTERVAL_US = 50_000
"""Of every message that there is: more than a link carries."""
_BUFFER = 4 << 20
_PART = 239
"""Bytes in a message of MAVLink FTP, as QGroundControl asks for them."""
_IDLE_S = 4.0
"""The shortest timeout that pymavlink's FTP client accepts, s."""
GIVE_WAY = 5
"""Niceness: at sea stations do not take the vehicle's processor."""
COMES_S = 60.0
_PATIENCE_S = 2.0
"""After so long without an answer, s, a station repeats its message."""


class LoadStation(threading.Thread):
    """A station on a link of its own; `counts` is what it did, `problems` what went wrong."""

    def __init__(self, system: int, seconds: float) -> None:
        """`seconds` is how long the work takes, from the first heartbeat that is heard."""
        super().__init__(daemon=True)
        self.link = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=system)
        self.link.port.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        self.port: int = self.link.port.getsockname()[1]
        self.counts: Counter[str] = Counter()
        self.problems: list[str] = []
        self._seconds = seconds
        self._until = math.inf
        self._beaten = 0.0

    def run(self) -> None:
        """Connect, request all telemetry, and do the task until the time is over."""
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), GIVE_WAY)
        try:
            if self.link.wait_heartbeat(timeout=COMES_S) is None:
                raise TimeoutError("no heartbeat was heard")
            self._until = time.monotonic() + self._seconds
            for name in DEFAULT_STREAMS.keys() - {mavlink.MAVLINK_MSG_ID_HEARTBEAT}:
                self.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, name, _INTERVAL_US)
            self.work()
        except Exception as error:
            self.problems.append(f"{type(self).__name__}: {type(error).__name__}: {error}")

    def work(self) -> None:
        """Do the task."""
        raise NotImplementedError

    @property
    def left(self) -> float:
        """Return the time until the work ends, s."""
        return self._until - time.monotonic()

    def end(self) -> None:
        """Count what the link received, and close it."""
        self.counts["messages heard"] = self.link.mav_count
        self.counts["messages missed"] = self.link.mav_loss
        status = self.link.messages.get("SYS_STATUS")
        self.counts["not heard by the vehicle"] = status.errors_comm if status is not None else 0
        self.link.close()

    def command(self, number: int, *params: float) -> None:
        """Send a command until it is answered."""
        filled = (*params, *(0.0,) * (7 - len(params)))
        while self.left > 0.0:
            self.link.mav.command_long_send(*VEHICLE, number, 0, *filled)
            answer = self.receive("COMMAND_ACK", _PATIENCE_S)
            if answer is not None and answer.command == number:
                return
            self.counts["repeated"] += 1

    def receive(self, kind: str | list[str], seconds: float) -> Any:
        """Return the next message of that kind, None if none comes in time; a heartbeat goes out each second."""
        now = time.monotonic()
        if now - self._beaten >= 1.0:
            self._beaten = now
            self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)
        return self.link.recv_match(type=kind, blocking=True, timeout=seconds)


class Parameters(LoadStation):
    """Fetches the whole list again and again, and meanwhile sets values, twenty a second."""

    _EVERY_S = 0.05
    _SETS = (
        ("CTL_Z_INT_TIME", (9.0, 8.0)),
        ("GDN_LOOK_AHEAD", (16.0, 15.0)),
        ("GDN_CRUISE", (1.75, 1.5)),
        ("SAF_LEAK_TIME", (1.5, 1.0)),
        ("EST_DEP_TAU", (0.25, 0.5)),
        ("EST_HLT_NIS_TIME", (12.0, 10.0)),
        ("EST_COF_MEMORY", (50.0, 60.0)),
    )
    """Parameters of every part of the vehicle; each change makes its part anew."""

    def work(self) -> None:
        """See `LoadStation`."""
        self._missing: set[int] = set()
        self._heard = time.monotonic()
        self._asked: dict[str, tuple[float, float]] = {}
        due, turn = time.monotonic(), 0
        self.link.mav.param_request_list_send(*VEHICLE)
        while self.left > 0.0:
            message, now = self.receive("PARAM_VALUE", 0.01), time.monotonic()
            if message is not None:
                self._take(message, now)
            elif now - self._heard > _PATIENCE_S:
                self._again(now)
            if now >= due:
                due = now + self._EVERY_S
                name, values = self._SETS[turn % len(self._SETS)]
                self._set(name, values[turn // len(self._SETS) % 2], now)
                turn += 1

    def _take(self, message: Any, now: float) -> None:
        self._heard = now
        if not self.counts["parameters"]:
            self.counts["parameters"] = message.param_count
            self._missing = set(range(message.param_count))
        if self._asked.get(message.param_id, (None,))[0] == message.param_value:
            del self._asked[message.param_id]
            self.counts["parameters set"] += 1
        self._missing.discard(message.param_index)
        if not self._missing:
            self.counts["parameter lists fetched"] += 1
            self._missing = set(range(message.param_count))
            self.link.mav.param_request_list_send(*VEHICLE)

    def _again(self, now: float) -> None:
        self._heard = now
        self.counts["repeated"] += 1
        self.link.mav.param_request_list_send(*VEHICLE)

    def _set(self, name: str, value: float, now: float) -> None:
        """Set one value after the other; one that was not echoed is sent again."""
        if name in self._asked:
            value, sent = self._asked[name]
            if now - sent < _PATIENCE_S:
                return
            self.counts["repeated"] += 1
        self._asked[name] = value, now
        self.link.mav.param_set_send(*VEHICLE, name.encode(), value, mavlink.MAV_PARAM_TYPE_REAL32)


class Files(LoadStation):
    """Fetches the log of the flight that is going on, again and again, by pymavlink's own client."""

    def __init__(self, system: int, seconds: float, folder: Path) -> None:
        super().__init__(system, seconds)
        self._folder = folder
        self.fetched: list[Path] = []

    def work(self) -> None:
        """See `LoadStation`."""
        while self.left > _IDLE_S:
            client = mavftp.MAVFTP(self.link, *VEHICLE)
            client.ftp_settings.burst_read_size = _PART
            listed = client.cmd_list(["logs"]).directory_listing
            if not listed or not listed[0].size_b:
                continue
            to = self._folder / f"fetched-{len(self.fetched)}.mcap"
            client.cmd_get([f"logs/{listed[0].name}", str(to)])
            if client.process_ftp_reply("get", timeout=max(self.left, _IDLE_S)).error_code == 0 and to.exists():
                self.fetched.append(to)
                self.counts["logs fetched"] += 1
                self.counts["bytes of logs"] += to.stat().st_size


class Missions(LoadStation):
    """Uploads a long mission again and again."""

    def __init__(self, system: int, seconds: float, items: int) -> None:
        super().__init__(system, seconds)
        self._items = items

    def work(self) -> None:
        """See `LoadStation`."""
        self.command(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_HOME_POSITION)
        home = None
        while home is None and self.left > 0.0:
            home = self.receive("HOME_POSITION", _PATIENCE_S)
        while home is not None and self.left > 0.0:
            began = time.monotonic()
            result = self._upload(home.latitude, home.longitude)
            if result == mavlink.MAV_MISSION_ACCEPTED:
                self.counts["missions uploaded"] += 1
                self.counts["items of missions"] += self._items
                self.counts["ms of the longest upload"] = max(
                    self.counts["ms of the longest upload"], round(1e3 * (time.monotonic() - began))
                )
            elif result is not None:
                raise ValueError(f"the mission was refused: {result}")

    def _upload(self, latitude: int, longitude: int) -> int | None:
        """Upload; return the vehicle's MISSION_ACK, None if the time was over before."""
        last = None
        while self.left > 0.0:
            if last is None:
                self.link.mav.mission_count_send(*VEHICLE, self._items)
            else:
                self._item(last, latitude, longitude)
            while message := self.receive(["MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"], _PATIENCE_S):
                if message.get_type() == "MISSION_ACK":
                    result: int = message.type
                    return result
                last = message.seq
                self._item(last, latitude, longitude)
            self.counts["repeated"] += 1
        return None

    def _item(self, seq: int, latitude: int, longitude: int) -> None:
        """Send an item of a zigzag northwards, 5 m deep; item 0 is the home."""
        north, east = latitude + 900 * seq, longitude + 2000 * (seq % 2)
        frame, command = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, mavlink.MAV_CMD_NAV_WAYPOINT
        depth = -5.0 if seq else 0.0
        self.link.mav.mission_item_int_send(*VEHICLE, seq, frame, command, 0, 1, 0, 0, 0, 0, north, east, depth)
