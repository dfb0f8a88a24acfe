"""The other process of the bus tests: `bus_peer.py talk|listen|echo SPEC`."""

from __future__ import annotations

import json
import sys
import time

from firmware_py.adapters.buses.can_bus import CanBus, open_bus

COUNT, RATE, BURST = 4000, 4000, 40


def numbered() -> list[tuple[int, bytes]]:
    return [(0x10000000 | k, k.to_bytes(4, "big") * (k % 3)) for k in range(COUNT)]


def talk(bus: CanBus) -> None:
    """Says its frames at their rate when it has heard something."""
    while not bus.drain(1, 1.0):
        pass
    begin = time.monotonic()
    frames = numbered()
    for k in range(0, COUNT, BURST):
        time.sleep(max(0.0, begin + k / RATE - time.monotonic()))
        bus.send(frames[k : k + BURST])
    sys.stdin.read()


def listen(bus: CanBus) -> None:
    """Hears as many frames and reports."""
    frames: list[tuple[int, bytes]] = []
    deadline = time.monotonic() + 20.0
    while len(frames) < COUNT and time.monotonic() < deadline:
        frames += bus.drain(1000, 0.1)
    print(json.dumps({"frames": len(frames), "as_sent": frames == numbered(), "losses": bus.losses()}), flush=True)


def echo(bus: CanBus) -> None:
    """Says what it hears, one id higher."""
    while True:
        bus.send([(can_id + 1, data) for can_id, data in bus.drain(100, 1.0)])


if __name__ == "__main__":
    door = open_bus(sys.argv[2])
    print("ready", flush=True)
    {"talk": talk, "listen": listen, "echo": echo}[sys.argv[1]](door)
