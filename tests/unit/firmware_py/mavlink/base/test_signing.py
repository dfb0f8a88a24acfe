"""Signed links: pymavlink's own signing is the other side, and an attacker who has heard it all."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.signing import STATE_FILE, TICKS_PER_S, UNSIGNED_ACCEPTED, Signing
from firmware_py.mavlink.node import Node
from firmware_py.records.order import NO_ORDER, Arming
from tests.unit.firmware_py.mavlink import station
from tests.unit.firmware_py.mavlink.station import DT_NS, cycle, parse, receive

KEY, OTHER = bytes(range(32)), bytes(32)
NOW = 370_000_000 * TICKS_PER_S
ARM = mavlink.MAV_CMD_COMPONENT_ARM_DISARM


class Peer:
    """A station of pymavlink's that signs."""

    def __init__(self, key: bytes | None = KEY, now: int = NOW, link: int = 7, system: int = 255) -> None:
        self.mav = mavlink.MAVLink(None, system, 190)
        if key is not None:
            self.mav.signing.secret_key = key
            self.mav.signing.sign_outgoing = True
            self.mav.signing.timestamp = now
            self.mav.signing.link_id = link

    def arm(self, arm: int = 1) -> bytes:
        return self.pack(mavlink.MAVLink_command_long_message(1, 1, ARM, 0, arm, 0, 0, 0, 0, 0, 0))

    def pack(self, message) -> bytes:
        return message.pack(self.mav)


def node(kept: bytes = b"", links: int = 1, key: bytes = KEY, now: int = NOW, stream: bool = False) -> Node:
    configurations = [LinkConfiguration(Identity.ARDUSUB, stream=stream)] * links
    return station.node(configurations=configurations, signing=Signing(key, now, kept))


def hears(vehicle: Node, *datagrams: bytes, link: int = 0) -> bool:
    """Whether the vehicle is asked to arm by what it hears; it forgets that it was."""
    receive(vehicle, cycle().tick, *datagrams, link=link)
    order = vehicle.order()
    vehicle.report(dataclasses.replace(cycle(), order=order))
    return order.arming is Arming.ARM


def test_what_is_signed_with_the_key_is_heard_in_order() -> None:
    vehicle, peer = node(), Peer()
    assert hears(vehicle, peer.arm())
    assert hears(vehicle, peer.arm())
    assert vehicle.links[0].codec.refused == 0


def test_unsigned_and_wrongly_signed_commands_are_refused_and_counted() -> None:
    vehicle = node()
    for refused, peer in enumerate((Peer(None), Peer(OTHER), Peer(None)), 1):
        assert not hears(vehicle, peer.arm())
        assert vehicle.links[0].codec.refused == refused
        assert vehicle.links[0].codec.malformed == 0
    assert vehicle.links[0].lost == 3


def test_a_refused_message_in_front_does_not_hide_the_good_one_behind_it() -> None:
    assert hears(node(), Peer(None).arm() + Peer().arm())


def test_what_was_heard_is_not_heard_again_on_this_link_or_another() -> None:
    vehicle, peer = node(links=2), Peer()
    first, second = peer.arm(), peer.arm()
    assert hears(vehicle, first)
    assert not hears(vehicle, first)
    assert not hears(vehicle, first, link=1)
    assert hears(vehicle, second, link=1)
    assert vehicle.links[0].codec.refused == vehicle.links[1].codec.refused == 1


def test_what_was_heard_before_a_restart_is_not_heard_after_it() -> None:
    vehicle, peer = node(), Peer()
    heard, unheard = peer.arm(), peer.arm()
    assert hears(vehicle, heard)
    ((name, kept),) = vehicle.files_to_save()
    assert name == STATE_FILE
    assert vehicle.files_to_save() == []  # not for each message
    again = node(kept)
    assert not hears(again, heard)
    assert not hears(again, unheard)  # it may have been heard after what is kept was written
    assert hears(again, Peer(now=NOW + 60 * TICKS_PER_S).arm())


def test_a_clock_that_fell_back_does_not_bring_back_the_past() -> None:
    vehicle, peer = node(), Peer()
    heard = peer.arm()
    assert hears(vehicle, heard)
    ((_, kept),) = vehicle.files_to_save()
    assert not hears(node(kept, now=0), heard)


def test_what_is_kept_goes_on_while_messages_do() -> None:
    vehicle = node()
    written = []
    for second in range(0, 60, 2):
        assert hears(vehicle, Peer(now=NOW + second * TICKS_PER_S).arm())
        written += vehicle.files_to_save()
        assert int(written[-1][1]) >= NOW + second * TICKS_PER_S
    assert 4 <= len(written) <= 8


@pytest.mark.parametrize("kept", [b"", b"no number", b"-5", b"9" * 30, "\u0665".encode()])
def test_kept_nonsense_is_nothing(kept: bytes) -> None:
    assert hears(node(kept), Peer().arm())


def test_a_stream_that_begins_long_ago_is_old() -> None:
    assert not hears(node(), Peer(now=NOW - 120 * TICKS_PER_S).arm())
    assert hears(node(), Peer(now=NOW - 30 * TICKS_PER_S).arm())


def test_a_forger_cannot_shut_out_the_true_station() -> None:
    vehicle, peer = node(), Peer()
    assert hears(vehicle, peer.arm())
    forged = bytearray(peer.arm())
    forged[-12:-6] = b"\xff" * 6  # far in the future, and so wrongly signed
    assert not hears(vehicle, bytes(forged))
    for system in range(1, 200):
        assert not hears(vehicle, Peer(OTHER, system=system).arm())
    assert hears(vehicle, peer.arm())


@given(st.integers(0, 57), st.integers(1, 255))
def test_one_wrong_byte_anywhere_is_no_command(at: int, flip: int) -> None:
    broken = bytearray(Peer().arm())
    broken[at % len(broken)] ^= flip
    assert not hears(node(), bytes(broken))


@settings(max_examples=30)
@given(st.data())
def test_no_unsigned_message_but_the_listed_reaches_anybody(data) -> None:
    vehicle = node()
    for kind in mavlink.mavlink_map.values():
        payload = data.draw(st.binary(min_size=1, max_size=40))[: kind.unpacker.size] or b"\x01"
        header = bytes([len(payload), 0, 0, 0, 255, 190]) + kind.id.to_bytes(3, "little")
        crc = mavlink.x25crc(bytearray(header + payload + bytes([kind.crc_extra]))).crc
        receive(vehicle, cycle().tick, b"\xfd" + header + payload + crc.to_bytes(2, "little"))
        assert vehicle.order() is NO_ORDER
    listed = sum(name in mavlink.mavlink_map for name in UNSIGNED_ACCEPTED)
    assert vehicle.links[0].codec.refused == len(mavlink.mavlink_map) - listed


def test_all_that_the_vehicle_says_is_signed_with_time_going_on() -> None:
    vehicle = node()
    peer = Peer()
    peer.mav.signing.timestamp = NOW
    frames = [vehicle.report(cycle(k))[0] for k in range(500)]
    for frame in frames:
        parse(frame)  # a station without a key can read it
        peer.mav.parse_buffer(frame)
    assert peer.mav.signing.goodsig_count > 300
    assert peer.mav.signing.badsig_count == 0
    stamps = list(peer.mav.signing.stream_timestamps.values())
    assert len(stamps) == 1
    assert NOW + 490 * DT_NS // 10_000 <= stamps[0] <= NOW + 500 * DT_NS // 10_000


def test_links_of_one_vehicle_sign_as_different_links() -> None:
    vehicle = node(links=2)
    frames = vehicle.report(cycle(4))
    assert [frame[-13] for frame in frames] == [0, 1]


def test_refusals_are_told_now_and_then_in_a_sentence_with_their_number() -> None:
    vehicle = node()
    said = []
    for k in range(2500):
        receive(vehicle, cycle(k).tick, Peer(None).arm())
        said += [m for m in parse(vehicle.report(cycle(k))[0]) if m.get_type() in ("STATUSTEXT", "SYS_STATUS")]
    texts = [m.text for m in said if m.get_type() == "STATUSTEXT" and m.chunk_seq == 0]
    assert len(texts) == 3
    assert "refused" in texts[0]
    assert [m.errors_comm for m in said if m.get_type() == "SYS_STATUS"][-1] > 2400


def test_a_station_cannot_change_the_key() -> None:
    vehicle = node()
    setup = mavlink.MAVLink_setup_signing_message(1, 1, list(OTHER), NOW)
    receive(vehicle, cycle().tick, Peer().pack(setup))
    assert not hears(vehicle, Peer(OTHER).arm())
    assert hears(vehicle, Peer(now=NOW + TICKS_PER_S).arm())


def test_only_a_heartbeat_signed_with_the_key_says_that_a_station_is_there() -> None:
    vehicle = node()
    beat = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3)
    for peer, heard in ((Peer(key=None), False), (Peer(key=OTHER), False), (Peer(), True)):
        receive(vehicle, cycle().tick, peer.pack(beat))
        assert (vehicle.order().t_station == cycle().tick.t) is heard
