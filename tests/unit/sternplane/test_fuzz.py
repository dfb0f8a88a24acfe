"""The fuzzer: its packets are what they should be, the same for a seed, and what is broken it finds."""

from __future__ import annotations

import dataclasses
import math
import random
from collections import Counter

import pytest
from pymavlink.dialects.v20 import all as mavlink
from sternplane.fuzz import pool
from sternplane.fuzz.flight import PACKETS, Job, flown
from sternplane.fuzz.grammar import Grammar, with_checksum
from sternplane.fuzz.packets import PacketKind, Packets, station_frames
from sternplane.fuzz.rules import Broken, Peer, check_order
from sternplane.fuzz.sessions import sessions
from sternplane.fuzz.vehicle import open_vehicle
from sternplane.sitl.flight import FlightRequest, prepare

from firmware_py.mavlink import link
from firmware_py.mavlink.base import signing
from firmware_py.mavlink.telemetry.time_sync import TimeSync
from firmware_py.records.fence import Place
from firmware_py.records.order import NO_ORDER, Order, ParameterChange, RallyChange, Setpoint, Sticks

TALKS = sessions(("GDN_CRUISE", "SAF_LEAK_TIME"))
FEW = 12_000


def drawn(seed: int, n: int) -> list[tuple[PacketKind, bytes]]:
    packets = Packets(random.Random(seed), TALKS)
    return [packets.next() for _ in range(n)]


def heard(frame: bytes) -> list:
    peer = mavlink.MAVLink(None)
    peer.robust_parsing = True
    return [m for m in peer.parse_buffer(frame) or [] if m.get_type() != "BAD_DATA"]


def test_packets_are_the_same_for_a_seed_and_others_for_another() -> None:
    assert drawn(5, 1000) == drawn(5, 1000)
    assert drawn(5, 100) != drawn(6, 100)


def test_every_kind_comes_as_often_and_every_message_id_with_a_right_checksum() -> None:
    packets = drawn(1, 8000)
    counts = Counter(kind for kind, _ in packets)
    assert all(1800 < counts[kind] < 2200 for kind in PacketKind)
    names = {m.get_msgId() for kind, packet in packets if kind is PacketKind.EXTREME for m in heard(packet)}
    assert names == set(mavlink.mavlink_map)


def test_a_float_is_extreme_in_every_way_sooner_or_later() -> None:
    grammar = Grammar(random.Random(1), TALKS)
    kind = mavlink.mavlink_map[mavlink.MAVLINK_MSG_ID_MANUAL_SETPOINT]
    seen = {repr(value) for _ in range(2000) for value in kind.unpacker.unpack(grammar.payload(kind.id))}
    assert {"nan", "inf", "-inf", "-0.0", "3.4028234663852886e+38", "4294967295", "0"} <= seen


def test_a_changed_frame_can_be_given_the_checksum_that_makes_it_whole() -> None:
    (arm,) = station_frames([[mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)]])[0]
    changed = bytearray(arm)
    changed[10:14] = b"\x00\x00\xc0\x7f"
    assert heard(bytes(changed)) == []
    assert math.isnan(heard(with_checksum(changed))[0].param1)


def test_the_conversations_have_all_that_the_vehicle_hears() -> None:
    configuration = prepare(FlightRequest("demo"), {}).configuration
    known = {message.get_msgId() for talk in TALKS for message in talk}
    for one in open_vehicle(configuration, False, random.Random(1)).node.links:
        assert one.handlers.keys() <= known


def test_a_sound_vehicle_breaks_no_rule_and_does_what_stations_ask() -> None:
    found = flown(Job(3, 0, FEW))
    assert found.failure is None, found.failure
    assert sum(found.counts[kind.value] for kind in PacketKind) == FEW
    assert found.counts["orders"] > 0
    assert found.counts["changes of parameters"] > 0
    assert found.counts["dropped: too much for a tick, or to wait"] > 0
    assert found.counts["cycles replayed"] == len(found.cost_ns)


def test_a_signed_vehicle_breaks_no_rule_and_heeds_the_owner_of_the_key_alone() -> None:
    found = flown(Job(3, 1, FEW))
    assert found.failure is None, found.failure
    assert sum(found.counts[kind.value] for kind in PacketKind) == FEW
    assert found.counts["sent by the owner of the key"] > 20
    assert found.counts["refused: signature"] > FEW // 4


def test_a_service_that_raises_is_found_and_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    ping = TimeSync._ping

    def broken(self, tick, message) -> None:
        if message.seq != 1:  # which is what the conversations say
            raise KeyError("seeded")
        ping(self, tick, message)

    monkeypatch.setattr(TimeSync, "_ping", broken)
    first_time, again = flown(Job(1, 2, FEW)), flown(Job(1, 2, FEW))
    found = first_time.failure
    assert found is not None
    assert "KeyError: 'seeded'" in found.text
    assert (again.failure, again.counts) == (found, first_time.counts)
    first, behind = found.packets
    assert 2 * PACKETS <= first < behind <= 2 * PACKETS + FEW
    assert any("040000" in datagram for datagram in found.received)  # PING's id


def test_a_number_that_is_none_in_an_order_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    sticks = link.sticks

    def broken(params, message) -> Sticks:
        return sticks(params, message) if message.x >= 0 else Sticks(math.nan, 0.0, 0.0)

    monkeypatch.setattr(link, "sticks", broken)
    found = flown(Job(1, 0, FEW)).failure
    assert found is not None
    assert found.text.startswith("order: sticks")


def test_a_key_that_lets_the_unsigned_in_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    heeded = signing.UNSIGNED_ACCEPTED | {mavlink.MAVLINK_MSG_ID_COMMAND_LONG}
    monkeypatch.setattr(signing, "UNSIGNED_ACCEPTED", heeded)
    found = flown(Job(1, 1, FEW)).failure
    assert found is not None
    assert found.text.startswith("signed:")


@pytest.mark.parametrize(
    "order",
    [
        dataclasses.replace(NO_ORDER, setpoint=Setpoint(math.inf, 0.0, 0.0)),
        dataclasses.replace(NO_ORDER, sticks=Sticks(0.0, math.nan, 0.0)),
        dataclasses.replace(NO_ORDER, t_sticks=math.nan),
        dataclasses.replace(NO_ORDER, jump=2**40),
        dataclasses.replace(NO_ORDER, changes=(RallyChange((Place(math.nan, 0.0),)),)),
        dataclasses.replace(NO_ORDER, changes=(ParameterChange(()),)),
    ],
)
def test_an_order_that_cannot_be_is_seen(order: Order) -> None:
    assert check_order(NO_ORDER) == []
    with pytest.raises(Broken, match=r"^order: "):
        check_order(order)


def test_what_is_no_message_may_not_be_sent() -> None:
    ((beat,),) = station_frames([[mavlink.MAVLink_heartbeat_message(12, 3, 0, 0, 3, 3)]])
    assert Peer().count_messages(beat * 3) == 3
    for datagram in (beat[:-1], beat + b"\x00", beat * 100):
        with pytest.raises(Broken, match=r"^sent: "):
            Peer().count_messages(datagram)


def test_flights_take_exactly_so_many_packets() -> None:
    jobs = [*pool.jobs(9, 2 * PACKETS + 7)]
    assert [(job.flight, job.packets) for job in jobs] == [(0, PACKETS), (1, PACKETS), (2, 7)]
