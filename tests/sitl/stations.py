"""A vehicle in a process of its own, and a station that listens to it."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pymavlink import mavutil

from tests.command import Forked


def idle(duration: float) -> str:
    """The scenario of a vehicle that waits at the surface for whoever comes, s."""
    return f"""
description = "Waits at the surface for whoever comes."
duration_s = {duration}
completes = "time"
[autopilot.safety]
late_max = 1000  # on a machine that tests share with others
[autopilot.estimation.learning]
enabled = false
"""


@contextlib.contextmanager
def flight(folder: Path, state: Path, identity: str = "ardusub") -> Iterator[Any]:
    """A vehicle that flies in real time, and mavutil listening to it."""
    station = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255)
    port = station.port.getsockname()[1]
    words = ("--out", folder, "--gcs", f"udpout:127.0.0.1:{port}:{identity}", "--state", state)
    vehicle = Forked("sitl", "--pace", "realtime", *words, cwd=state.parent)
    try:
        assert station.wait_heartbeat(timeout=90) is not None, vehicle.stderr
        yield station
        vehicle.send_signal(signal.SIGINT)
        _, said = vehicle.communicate(timeout=60)
        assert vehicle.returncode == 1, said  # the mission was not completed
    finally:
        vehicle.close()
        station.close()
