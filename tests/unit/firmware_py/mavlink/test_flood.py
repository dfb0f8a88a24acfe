"""Floods on several links at once: what a tick looks at is bounded over all of them, and nobody is drowned out."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink import link as limits
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.node import Node
from firmware_py.records.order import Arming
from firmware_py.tick import Tick

from .planner import home, item
from .station import DT_NS, LinkedVehicle, node

LINKS = 3
LONGEST = 280
"""Bytes of a frame of MAVLink 2 at most."""
RNG = random.Random(7)
STATION = LinkedVehicle().stations[0]
ARM = STATION.pack(mavlink.MAVLink_command_long_message(1, 1, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, *[0] * 6))
BROKEN = ARM[:-1] + bytes((ARM[-1] ^ 1,))
FLOODS = {
    "noise": [RNG.randbytes(RNG.randrange(1, 2000)) for _ in range(16)],
    "beginnings": [b"\xfd" * 2000] * 16,
    "long frames that are broken": [(b"\xfd\xff\x00\x00" + RNG.randbytes(276)) * 7] * 16,
    "messages with a wrong byte": [BROKEN * 30] * 16,
    "messages": [ARM * 30] * 16,
}


class Watched:
    """A node, its parse attempts in the last tick by link, and the bytes that pymavlink decoded in it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.node: Node = node(identities=(Identity.ARDUSUB,) * LINKS)
        self.attempts = [0] * LINKS
        self.decoded = 0
        for i, link in enumerate(self.node.links):
            monkeypatch.setattr(link, "receive", self._counting(i, link.receive))
        decode = dialect.MAVLink.decode

        def counting(mav, frame: bytearray):
            self.decoded += len(frame)
            return decode(mav, frame)

        monkeypatch.setattr(dialect.MAVLink, "decode", counting)

    def _counting(self, i: int, receive: Callable[..., int]) -> Callable[..., int]:
        def counting(*args) -> int:
            self.attempts[i] = receive(*args)
            return self.attempts[i]

        return counting

    def receive(self, k: int, datagrams: Sequence[Sequence[bytes]]) -> None:
        self.attempts, self.decoded = [0] * LINKS, 0
        self.node.receive(Tick(k, DT_NS), datagrams)


@pytest.fixture
def watched(monkeypatch: pytest.MonkeyPatch) -> Watched:
    return Watched(monkeypatch)


@pytest.mark.parametrize("kind", FLOODS)
@pytest.mark.parametrize("links", range(1, LINKS + 1))
def test_what_a_tick_looks_at_is_bounded_over_all_links(kind: str, links: int, watched: Watched) -> None:
    said = [FLOODS[kind] if i < links else [] for i in range(LINKS)]
    for k in range(20):
        watched.receive(k, said)
        assert sum(watched.attempts) <= limits.MAX_PARSED_PER_TICK
        assert watched.decoded <= limits.MAX_PARSED_PER_TICK * LONGEST
        for i in range(links):
            assert watched.attempts[i] >= limits.MAX_PARSED_PER_TICK // links
    for i, link in enumerate(watched.node.links):
        assert (link.losses["flooding"] > 0) == (i < links)


@pytest.mark.parametrize("kind", FLOODS)
@pytest.mark.parametrize("quiet", range(LINKS))
def test_a_command_is_heard_beside_floods_on_all_other_links(kind: str, quiet: int, watched: Watched) -> None:
    said = [[ARM] if i == quiet else [datagram.replace(ARM, BROKEN) for datagram in FLOODS[kind]] for i in range(LINKS)]
    watched.receive(0, said)
    order = watched.node.order()
    assert (order.arming, order.asker.link) == (Arming.ARM, quiet)
    assert watched.node.links[quiet].lost == 0


def test_what_others_leave_is_for_who_has_much_to_say(watched: Watched) -> None:
    watched.receive(0, [[ARM], [ARM], [ARM * 40]])
    assert watched.attempts == [1, 1, limits.MAX_PARSED_PER_TICK - 2]
    watched.receive(1, [[], [ARM * 40], []])
    assert watched.attempts == [0, limits.MAX_PARSED_PER_TICK, 0]


def test_of_many_missions_in_one_tick_one_is_adopted_the_last() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    depths = range(1, 11)
    for depth in depths:
        station.send(mavlink.MAVLink_mission_count_message(1, 1, 2))
        for message in home(item(north=100.0, z=-float(depth))):
            station.send(message)
    vehicle.step()
    ((document,),) = [order.changes for order in vehicle.orders if order.changes]
    assert [waypoint.z for waypoint in document.mission.items] == [pytest.approx(depths[-1])]
    vehicle.step(10)
    assert [ack.type for ack in station.heard("MISSION_ACK")] == [mavlink.MAV_MISSION_ACCEPTED] * len(depths)
    assert not any(order.changes for order in vehicle.orders[1:])
