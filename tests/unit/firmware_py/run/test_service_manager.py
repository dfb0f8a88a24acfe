"""What systemd hears: the socket is a real one."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from firmware_py.run.device_watch import DeviceWatch
from firmware_py.run.service_manager import ServiceManager
from firmware_py.tick import Tick

DT_NS = 10_000_000


def cycle(k: int) -> Any:
    return SimpleNamespace(tick=Tick(k, DT_NS, 0))


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return tmp_path / "notify"


@pytest.fixture
def systemd(place: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(place))
        listening.setblocking(False)
        yield listening


def heard(systemd: socket.socket) -> list[str]:
    found = []
    while True:
        try:
            found.append(systemd.recv(1000).decode())
        except BlockingIOError:
            return found


def test_it_is_ready_with_its_first_cycle_and_the_watchdog_is_fed_by_cycles_alone(
    place: Path, systemd: socket.socket
) -> None:
    manager = ServiceManager({"NOTIFY_SOCKET": str(place), "WATCHDOG_USEC": "3000000"})
    assert heard(systemd) == []
    for k in range(350):
        manager.cycled(cycle(k))
    manager.status("waiting for bus socketcan:can0")
    manager.stopping()
    fed = ["WATCHDOG=1"] * 4
    assert heard(systemd) == ["READY=1", *fed, "STATUS=waiting for bus socketcan:can0", "STOPPING=1"]
    manager.close()
    manager.cycled(cycle(1000))
    assert heard(systemd) == []


def test_the_watchdog_of_another_process_is_not_ours(place: Path, systemd: socket.socket) -> None:
    other = {"WATCHDOG_USEC": "1000000", "WATCHDOG_PID": str(os.getpid() + 1)}
    manager = ServiceManager({"NOTIFY_SOCKET": str(place), **other})
    for k in range(200):
        manager.cycled(cycle(k))
    assert heard(systemd) == ["READY=1"]
    manager.close()


def test_an_abstract_socket_is_found() -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(f"\0sternplane-test-{os.getpid()}")
        manager = ServiceManager({"NOTIFY_SOCKET": f"@sternplane-test-{os.getpid()}"})
        manager.cycled(cycle(0))
        assert listening.recv(100) == b"READY=1"
        manager.close()


@pytest.mark.parametrize("environment", [{}, {"NOTIFY_SOCKET": "/nowhere/notify"}, {"NOTIFY_SOCKET": "relative"}])
def test_without_anybody_to_tell_it_flies_all_the_same(environment: dict[str, str]) -> None:
    manager = ServiceManager({**environment, "WATCHDOG_USEC": "1"})
    manager.cycled(cycle(0))
    manager.status("x")
    manager.close()


def test_a_manager_that_no_longer_listens_ends_no_flight(place: Path, systemd: socket.socket) -> None:
    manager = ServiceManager({"NOTIFY_SOCKET": str(place)})
    for _ in range(10_000):  # its queue is full
        manager.status("x" * 500)
    systemd.close()
    manager.stopping()
    manager.close()


def test_what_is_missing_is_told_at_once_every_minute_and_when_it_is_there() -> None:
    told: list[str] = []
    shown: list[str] = []
    missing = {"bus can0": "it is down", "dvl": ""}
    watch = DeviceWatch(told.append, shown.append)
    for name in missing:
        watch.add(name, lambda name=name: missing[name])  # type: ignore[misc]
    for k in range(6050):
        watch.update(cycle(k))
    assert told == ["waiting for bus can0: it is down"] * 2
    assert shown == ["waiting for bus can0"]
    missing |= {"bus can0": "", "dvl": "port /dev/dvl is gone"}
    for k in range(6050, 6200):
        watch.update(cycle(k))
    assert told[2:] == ["waiting for dvl: port /dev/dvl is gone", "bus can0 is there"]
    missing["dvl"] = ""
    for k in range(6200, 6300):
        watch.update(cycle(k))
    assert told[4:] == ["dvl is there"]
    assert shown[1:] == ["waiting for dvl", "every device and link is there"]
