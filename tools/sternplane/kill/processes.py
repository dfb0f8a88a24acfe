"""The processes of a trial, and what is heard of them."""

from __future__ import annotations

import contextlib
import math
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pymavlink import mavutil  # type: ignore[import-untyped]

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.installation import configs
from firmware_py.wire.dronecan.message_table import ARRAY_COMMAND, NODE_STATUS

mavlink = mavutil.mavlink
VEHICLE, PLANT = 10, 23
"""Node ids: the autopilot's; that of the plant's AHRS."""
COMMANDS_HZ = 50
CURRENT = (0.06, 0.08)
"""North and east, m/s."""
_COMES_S = 60.0
_MISSION = """
[[waypoints]]
x_m = 300.0
y_m = 40.0
depth_m = 6.0
speed_m_s = 1.8

[[waypoints]]
x_m = 0.0
y_m = 80.0
depth_m = 6.0
speed_m_s = 1.8
"""
SCENARIO = f"""
description = "Vehicle and plant that may be killed."
duration_s = 3600.0
completes = "time"

[autopilot.safety]
late_max = 1000
[autopilot.estimation.learning]
enabled = false

[environment]
current_ned_m_s = [{CURRENT[0]}, {CURRENT[1]}, 0.0]
bottom_depth_m = 40.0

[[orders]]
t_s = 1.0
arming = "arm"

[[orders]]
t_s = 2.0
mode = "mission"
{_MISSION}"""


class Clock(threading.Thread):
    """Listens to the bus: at which wall time each node's time was 0, by its NodeStatus of each full second."""

    def __init__(self, spec: str) -> None:
        super().__init__(daemon=True)
        self._bus = open_bus(spec)
        self._ended = False
        self._zero: dict[int, float] = {}
        self._commands: dict[int, int] = {}

    def run(self) -> None:
        """Listen until `end`."""
        while not self._ended:
            for can_id, data in self._bus.drain(1000, 0.05):
                source, now = can_id & 0x7F, time.time()
                if can_id >> 8 & 0xFFFF == ARRAY_COMMAND.data_type_id and data[-1] & 0x80:
                    self._commands[source] = self._commands.get(source, 0) + 1
                elif can_id >> 8 & 0xFFFF == NODE_STATUS.data_type_id and not can_id & 0x80:
                    zero = now - int.from_bytes(data[:4], "little")
                    self._zero[source] = min(self._zero.get(source, math.inf), zero)

    def forget(self, source: int) -> None:
        """Forget a node that is started again."""
        self._zero.pop(source, None)
        self._commands.pop(source, None)

    def heard(self, source: int) -> bool:
        """Return whether a node was heard since it was started."""
        return source in self._zero

    def commanded(self, source: int) -> float:
        """Return the time of a vehicle when it last commanded its fins, s."""
        return (self._commands.get(source, 0) - 1) / COMMANDS_HZ

    def zero(self, source: int) -> float:
        """Return the wall time at which a node's time was 0; wait for its first status.

        Raises:
            TimeoutError: it does not come.
        """
        end = time.monotonic() + _COMES_S
        while source not in self._zero:
            if time.monotonic() > end:
                raise TimeoutError(f"node {source} was not heard for {_COMES_S:g} s")
            time.sleep(0.01)
        return self._zero[source]

    def end(self) -> None:
        """Leave the bus; may be called twice."""
        if not self._ended:
            self._ended = True
            self.join()
            self._bus.close()


class Station(threading.Thread):
    """A ground station: hears the vehicle's time, and may send it on its mission, from its time `since`, s, on."""

    def __init__(self, *, commands: bool, since: float = 0.0) -> None:
        super().__init__(daemon=True)
        self.link = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255)
        self.address = f"udpout:127.0.0.1:{self.link.port.getsockname()[1]}"
        self.t = 0.0
        """The newest vehicle time that was heard, s."""
        self.armed = False
        self._commands, self._since, self._ended = commands, since, False

    def run(self) -> None:
        """Listen, and every second say what is wanted, until `end`."""
        said = 0.0
        while not self._ended:
            message = self.link.recv_match(blocking=True, timeout=0.05)
            if message is not None:
                self.t = max(self.t, getattr(message, "time_boot_ms", 0) * 1e-3)
                if message.get_type() == "HEARTBEAT":
                    self.armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
            if self.t and time.monotonic() - said > 1.0:
                said = time.monotonic()
                self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
                if self._commands and self.t >= self._since:
                    number = mavlink.MAV_CMD_MISSION_START if self.armed else mavlink.MAV_CMD_COMPONENT_ARM_DISARM
                    self.link.mav.command_long_send(1, 1, number, 0, 0 if self.armed else 1, 0, 0, 0, 0, 0, 0)
                    self._commands = not self.armed

    def until_heard(self, t: float = 0.0) -> None:
        """Wait until the vehicle's time is more than t, s.

        Raises:
            TimeoutError: it does not come.
        """
        end = time.monotonic() + _COMES_S
        while self.t <= t:
            if time.monotonic() > end:
                raise TimeoutError(f"the vehicle was not heard for {_COMES_S:g} s")
            time.sleep(0.005)

    def end(self) -> None:
        """Close the link."""
        self._ended = True
        self.join()
        self.link.close()


class Process:
    """The `sternplane` command in a process of its own, all of whose children end with it.

    Attributes:
        name: the first of its words.
    """

    def __init__(self, folder: Path, *words: str | Path) -> None:
        self.name = str(words[0])
        folder.mkdir(parents=True, exist_ok=True)
        self._said = folder / "said.txt"
        with self._said.open("wb") as said:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "sternplane.cli.main", *map(str, words)],
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=said,
            )

    @property
    def runs(self) -> bool:
        """True until it has ended."""
        return self._process.poll() is None

    @property
    def said(self) -> str:
        """Return what it has written."""
        return self._said.read_text(encoding="utf-8", errors="replace")

    def wait(self, longest: float) -> None:
        """Wait until it has ended by itself, at most so long, s of wall time."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(longest)

    @property
    def last_words(self) -> str:
        """Return the last line that it has written, of an error without our name."""
        lines = self.said.strip().splitlines()
        return lines[-1].removeprefix("sternplane: ") if lines else "it said nothing"

    def kill(self) -> float:
        """End it by SIGKILL; return the wall time."""
        now = time.time()
        self._process.kill()
        self._process.wait()
        return now

    def end(self) -> None:
        """End it as a person does; kill it if it does not end."""
        if self.runs:
            self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(20.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()


@contextlib.contextmanager
def ended(*parts: Any) -> Iterator[None]:
    """End these, whatever happens; lists of them as they are at the end."""
    try:
        yield
    finally:
        for part in parts:
            for one in part if isinstance(part, list) else (part,):
                one.end()


def configuration(folder: Path) -> Path:
    """Make a configuration with a mission, for a machine that is busy; return its folder."""
    made = folder / "config"
    shutil.copytree(configs() / "npsauv2", made)
    (made / "mission.toml").write_text(_MISSION, encoding="utf-8")
    state = made / "state"
    state.mkdir()
    changes = "[safety]\nlate_max = 1000\n[estimation.learning]\nenabled = false\n"
    (state / "parameters.toml").write_text(changes, encoding="utf-8")
    return made


def scenario(folder: Path, depth: float = 0.0) -> Path:
    """Write the scenario, which begins at a depth, m; return its file."""
    path = folder / "killed.toml"
    path.write_text(f"{SCENARIO}\n[start]\ndepth_m = {depth}\n", encoding="utf-8")
    return path


class OnBus:
    """Vehicles and plants of a trial that meet on a bus, with one scenario and one state folder.

    Attributes:
        processes: all that were started.
        clock: listens to the bus.

    Args:
        folder: of the trial; each process leaves its files in a folder of its name in it.
        bus: as the command line has it.
        seed: of the plants.
        depth: at which the plants begin, m.
    """

    def __init__(self, folder: Path, bus: str, seed: int, depth: float = 0.0) -> None:
        self.processes: list[Process] = []
        self.clock = Clock(bus)
        self._folder, self._seed = folder, seed
        self._scenario, self._config = scenario(folder, depth), configuration(folder)
        self._words = ("--bus", bus, "--dvl", folder / "dvl")

    def plant(self, name: str) -> Process:
        """Start a plant."""
        return self._start(name, "plant", "--scenario", self._scenario, "--pace", "realtime", "--seed", str(self._seed))

    def fly(self, name: str, station: Station) -> Process:
        """Start a vehicle that a station hears."""
        state = self._config / "state"
        return self._start(name, "fly", "--config", self._config, "--state", state, "--gcs", station.address)

    def _start(self, name: str, command: str, *words: str | Path) -> Process:
        folder = self._folder / name
        self.processes.append(Process(folder, command, *self._words, *words, "--out", folder))
        return self.processes[-1]
