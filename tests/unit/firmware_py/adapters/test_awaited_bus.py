"""A bus that is not there yet, comes, goes and comes back."""

from __future__ import annotations

import errno
import os
import socket
import time
import uuid
from types import SimpleNamespace

import pytest

from firmware_py.adapters.buses import awaited_bus
from firmware_py.adapters.buses.awaited_bus import AwaitedBus
from firmware_py.adapters.buses.can_bus import BusAbsentError, BusError, CanBus, open_bus


class Plug:
    """Stands for the kernel: an interface that is there or not, and is another one each time it is plugged in."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._channel = uuid.uuid4().hex
        self.number = 0
        self.now = 0.0
        monkeypatch.setattr(awaited_bus, "open_bus", self.open)
        monkeypatch.setattr(awaited_bus, "socket", SimpleNamespace(if_nametoindex=self.index))
        monkeypatch.setattr(awaited_bus, "time", SimpleNamespace(monotonic=lambda: self.now, sleep=time.sleep))

    def index(self, name: str) -> int:
        if not self.number:
            raise OSError
        return self.number

    def open(self, spec: str, *, standard: bool) -> CanBus:
        if not self.number:
            raise BusAbsentError(f"there is no {spec}")
        return open_bus(f"virtual:{self._channel}{self.number}", standard=standard)

    def peer(self) -> CanBus:
        return open_bus(f"virtual:{self._channel}{self.number}")


@pytest.fixture
def plug(monkeypatch: pytest.MonkeyPatch) -> Plug:
    return Plug(monkeypatch)


def test_frames_flow_once_it_is_there_and_again_once_it_is_back(plug: Plug) -> None:
    bus = AwaitedBus("socketcan:can0")
    assert bus.missing == "there is no socketcan:can0"
    assert (bus.sound, bus.losses()) == (False, {"down": 1})
    bus.send([(1, b"lost")])
    assert bus.drain(9) == []
    for number in (3, 4):
        plug.number = number
        plug.now += 1.0
        bus.drain(9)
        assert bus.missing == ""
        assert (bus.sound, bus.losses().get("down")) == (True, None)
        peer = plug.peer()
        peer.send([(2, b"here")])
        assert bus.drain(9) == [(2, b"here")]
        bus.send([(1, b"there")])
        assert peer.drain(9) == [(1, b"there")]
        peer.close()
        plug.number = 0
        plug.now += 1.0
        assert bus.drain(9) == []
        assert bus.missing == "bus socketcan:can0: its interface is gone"
    assert bus.losses()["not_sent"] == 0
    bus.close()
    bus.close()


def test_an_interface_that_was_replugged_between_two_looks_is_opened_anew(plug: Plug) -> None:
    plug.number = 3
    bus = AwaitedBus("socketcan:can0")
    plug.number = 4
    for _ in range(2):  # found gone, and then there
        plug.now += 1.0
        bus.drain(9)
    peer = plug.peer()
    peer.send([(2, b"here")])
    assert bus.drain(9) == [(2, b"here")]


def test_it_is_looked_for_once_a_second_and_not_more_often(plug: Plug, monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[str] = []
    bus = AwaitedBus("socketcan:can0")
    monkeypatch.setattr(
        awaited_bus, "open_bus", lambda spec, **options: tried.append(spec) or plug.open(spec, **options)
    )
    for _ in range(300):
        plug.now += 0.01
        bus.drain(9)
    assert 2 <= len(tried) <= 3


def test_what_can_be_no_bus_is_an_error_at_once() -> None:
    with pytest.raises(BusError, match="not known"):
        AwaitedBus("can0")


def no_such_interface(*_words: object, **_options: object) -> None:
    raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))


def no_netlink(*_words: object) -> None:
    raise OSError(errno.EAFNOSUPPORT, os.strerror(errno.EAFNOSUPPORT))


def test_an_interface_is_looked_for_with_the_sockets_that_the_service_permits(monkeypatch: pytest.MonkeyPatch) -> None:
    """RestrictAddressFamilies= of sternplane.service leaves out netlink, by which all interfaces are listed."""
    monkeypatch.setattr(socket, "if_nameindex", no_netlink)
    monkeypatch.setattr(socket, "socket", no_such_interface)
    bus = AwaitedBus("socketcan:nosuch9")
    assert "there is no interface 'nosuch9'" in bus.missing
    assert bus.drain(9) == []
    with pytest.raises(BusError, match="'lo' is no CAN interface"):
        open_bus("socketcan:lo")
