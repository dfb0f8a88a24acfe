"""What a babbling bus makes of the monitor: it stays bounded, ends on time, and says what it left out."""

from __future__ import annotations

import contextlib
import itertools
import json
import random
from pathlib import Path
from types import SimpleNamespace

import pytest
from sternplane.hardware import can_monitor
from sternplane.hardware.traffic import Traffic

from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.transfer import Frame, TransferSender
from tests.command import called

MOST = 64


class Storm:
    """A bus: as many frames with random ids as are asked for, and a pressure of node 24 at every drain."""

    name = "storm"

    def __init__(self) -> None:
        self._random, self._sender, self.sent = random.Random(1), TransferSender(24), 0

    def drain(self, limit: int, _seconds: float = 0.0) -> list[Frame]:
        chance = self._random
        frames = [(chance.getrandbits(29), chance.randbytes(7) + b"\xc0") for _ in range(limit - 1)]
        self.sent += limit
        return [*frames, *self._sender.send(m.STATIC_PRESSURE, eq.StaticPressure(2e5, 0.0))]

    def send(self, frames: list[Frame]) -> None:
        pass

    def losses(self) -> dict[str, int]:
        return {}


def test_of_each_node_a_bounded_number_of_kinds_is_kept_and_the_steady_ones_among_them() -> None:
    storm, traffic = Storm(), Traffic()
    for k in range(40):
        for can_id, data in storm.drain(1024):
            traffic.hear(can_id, data, 0.1 * k)
    kept = [len(traffic.of_node(node)) for node in range(128)]
    assert max(kept) == MOST
    assert sum(traffic.left_out.values()) > 5_000
    assert traffic.rate(24, m.STATIC_PRESSURE.data_type_id, -1, 4.0) == pytest.approx(10.0, abs=0.5)


def test_what_was_left_out_stands_in_table_and_json(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    drains = itertools.count()  # by the clock of the test: how many a slow machine does in a time is another matter
    monkeypatch.setattr(can_monitor, "shared_bus", lambda *_, **__: contextlib.nullcontext(Storm()))
    monkeypatch.setattr(can_monitor, "time", SimpleNamespace(monotonic=lambda: 0.02 * next(drains)))
    done = called("can", "monitor", "--seconds", "0.4", "--node", "24", cwd=tmp_path)
    assert "StaticPressure" in done.stdout
    [row] = [line for line in done.stdout.splitlines() if "left out" in line]
    assert int(row.split()[2]) > 0
    found = json.loads(called("can", "monitor", "--seconds", "0.4", "--json", cwd=tmp_path).stdout)
    assert len(found["nodes"]) == 127
    assert all(node["left_out"] for node in found["nodes"])
    assert max(len(node["messages"]) for node in found["nodes"]) <= MOST
    assert next(drains) < 50
