"""A flood of meaningless datagrams into one link."""

from __future__ import annotations

import math
import os
import random
import socket
import threading
import time
from collections import Counter

from pymavlink import mavutil  # type: ignore[import-untyped]

from sternplane.link_load.stations import COMES_S, GIVE_WAY

_BATCH_S = 1e-3
_KINDS = 1000
"""Datagrams that differ; to make each one anew would take longer than to send it."""


class Flood(threading.Thread):
    """Sends `rate` datagrams a second to whoever speaks first; like a `stations.LoadStation`, but for its work."""

    def __init__(self, seconds: float, rate: float) -> None:
        super().__init__(daemon=True)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(COMES_S)
        self.port: int = self._socket.getsockname()[1]
        self.counts: Counter[str] = Counter()
        self.problems: list[str] = []
        self._seconds, self._rate = seconds, rate

    def run(self) -> None:
        """Wait for the vehicle, then send until the time is over."""
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), GIVE_WAY)
        try:
            self._socket.connect(self._socket.recvfrom(2048)[1])
            self._send(_junk(random.Random(1)))
        except OSError as error:
            self.problems.append(f"Flood: {error}")

    def _send(self, junk: list[bytes]) -> None:
        began, sent = time.monotonic(), 0
        while (past := time.monotonic() - began) < self._seconds:
            for _ in range(math.ceil(past * self._rate) - sent):
                self._socket.send(junk[sent % _KINDS])
                sent += 1
            time.sleep(_BATCH_S)
        self.counts["datagrams sent"] = sent

    def end(self) -> None:
        """Close the socket."""
        self._socket.close()


def _junk(rng: random.Random) -> list[bytes]:
    """Return datagrams: a third noise, a third beginnings of frames at every place, a third with a wrong byte."""
    frame = mavutil.mavlink.MAVLink_param_set_message(1, 1, b"CTL_Z_INT_TIME", 9.0, 9).pack(mavutil.mavlink.MAVLink(0))
    broken = frame[:-1] + bytes((frame[-1] ^ 1,))
    kinds = (lambda: rng.randbytes(rng.randrange(1, 400)), lambda: b"\xfd" * rng.randrange(12, 400), lambda: broken * 8)
    return [kinds[i % len(kinds)]() for i in range(_KINDS)]
