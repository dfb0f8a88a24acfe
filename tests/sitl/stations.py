"""A vehicle in a process of its own, and a station that listens to it."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pymavlink import mavutil


@contextlib.contextmanager
def flight(folder: Path, state: Path, identity: str = "ardusub") -> Iterator[Any]:
    """A vehicle that flies in real time, and mavutil listening to it."""
    station = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255)
    port = station.port.getsockname()[1]
    words = [sys.executable, "-m", "sternplane.cli.main", "sitl", "--pace", "realtime", "--out", str(folder)]
    words += ["--gcs", f"udpout:127.0.0.1:{port}:{identity}", "--state", str(state)]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    try:
        assert station.wait_heartbeat(timeout=90) is not None
        yield station
    finally:
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        station.close()
    assert process.returncode == 1, said  # the mission was not completed
