"""A vehicle for stations: `sternplane sitl` in real time and in a process of its own, waiting for what they ask."""

from __future__ import annotations

import contextlib
import signal
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple, TypeVar

from sternplane.logs.reading import Log, read

from tests.command import Forked

T = TypeVar("T")
SURFACE = 300.0
"""Of the lake above mean sea level, m: there a depth cannot be taken for an altitude."""
DEPTH = 8.0
"""Where the vehicle waits, m."""
SCENARIO = f"""
description = "Waits in a lake, {DEPTH:g} m deep, for whoever comes."
duration_s = 600.0
completes = "time"
[environment]
bottom_depth_m = 40.0
[start]
depth_m = {DEPTH}
u_m_s = 1.8
n_rpm = 492.0
[autopilot.mavlink.telemetry]
surface_altitude_m = {SURFACE}
[autopilot.safety]
late_max = 1000  # on a machine that tests share with others
[autopilot.estimation.learning]
enabled = false
"""

T = TypeVar("T")


class Vehicle(NamedTuple):
    """Where it keeps what: `place` is the folder in which it was started."""

    place: Path
    process: Forked

    @property
    def state(self) -> Path:
        """What stations change is kept there."""
        return self.place / "state"

    @property
    def file(self) -> Path:
        """The log of this flight."""
        return self.place / "runs" / "flight" / "log.mcap"

    def end(self) -> Log:
        """End the flight as Ctrl-C does, and read its log."""
        self.process.send_signal(signal.SIGINT)
        _, said = self.process.communicate(timeout=60)
        assert self.process.returncode == 1, said  # the scenario was not completed
        return read(self.file)


@contextlib.contextmanager
def flying(place: Path, *links: str) -> Iterator[Vehicle]:
    """A vehicle on these links, for as long as the context lasts."""
    scenario = place / "waits.toml"
    scenario.write_text(SCENARIO)
    words = ["sitl", "--scenario", scenario, "--pace", "realtime", "--out", "runs/flight", "--state", place / "state"]
    process = Forked(*words, *(word for link in links for word in ("--gcs", link)), cwd=place)
    try:
        yield Vehicle(place, process)
    except Exception as error:
        if process.returncode is not None:
            raise AssertionError(f"the vehicle had ended:\n{process.stderr}") from error
        raise
    finally:
        process.close()


def free_port(kind: socket.SocketKind = socket.SOCK_DGRAM) -> int:
    """A port of loopback that nobody has."""
    with socket.socket(socket.AF_INET, kind) as at:
        at.bind(("127.0.0.1", 0))
        return int(at.getsockname()[1])


def until(found: Callable[[], T | None], what: str, seconds: float = 30.0) -> T:
    """What is looked for, once it is there."""
    end = time.monotonic() + seconds
    while True:
        if it := found():
            return it
        assert time.monotonic() < end, f"{what}: not within {seconds:g} s"
        time.sleep(0.02)


def changes(log: Log, kind: type[T]) -> list[T]:
    """What was adopted of that kind, in its order."""
    return [change for changes in log.changes.values() for change in changes if isinstance(change, kind)]
