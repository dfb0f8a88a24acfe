"""Noise, floods and broken frames: never an error, never an order, and no more work than a tick allows."""

from __future__ import annotations

import collections

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink import link as limits
from firmware_py.mavlink.base.codec import Codec
from firmware_py.mavlink.telemetry.streams import DEFAULT_STREAMS
from firmware_py.records.event import Event, EventKind, Severity
from firmware_py.records.order import NO_ORDER, Arming
from tests.unit.firmware_py.mavlink.station import LinkedVehicle, cycle, node, parse, receive

ARM = mavlink.MAV_CMD_COMPONENT_ARM_DISARM
noise = st.one_of(
    st.binary(max_size=400),
    st.lists(st.sampled_from([0xFD, 0xFE, 0x00, 0x01, 0x09, 0xFF]), max_size=400).map(bytes),
)


def arm(again: int = 0) -> bytes:
    station = LinkedVehicle().stations[0]
    return station.pack(mavlink.MAVLink_command_long_message(1, 1, ARM, again, 1, 0, 0, 0, 0, 0, 0))


def order_after(*datagrams: bytes):
    vehicle = node()
    receive(vehicle, cycle().tick, *datagrams)
    return vehicle.order()


@settings(max_examples=300)
@given(st.lists(noise, max_size=5))
def test_noise_orders_nothing(datagrams: list[bytes]) -> None:
    assert order_after(*datagrams) is NO_ORDER


@given(st.integers(0, len(arm()) - 1))
def test_a_command_cut_short_is_no_command(length: int) -> None:
    assert order_after(arm()[:length]) is NO_ORDER


@given(st.integers(0, len(arm()) - 1), st.integers(1, 255))
def test_a_command_with_one_wrong_byte_is_no_command(at: int, flip: int) -> None:
    broken = bytearray(arm())
    broken[at] ^= flip
    assert order_after(bytes(broken)) is NO_ORDER


def test_a_frame_goes_not_on_in_the_next_datagram() -> None:
    whole = arm()
    assert order_after(whole[:20], whole[20:]) is NO_ORDER
    assert order_after(whole[:20], whole).arming is Arming.ARM


@given(noise)
def test_a_good_frame_is_found_behind_noise(before: bytes) -> None:
    before = bytes(byte for byte in before if byte not in (0xFD, 0xFE))
    assert order_after(before + arm() + before).arming is Arming.ARM


def test_commands_in_mavlink_1_and_signed_ones_are_heard() -> None:
    station = LinkedVehicle().stations[0]
    message = mavlink.MAVLink_command_long_message(1, 1, ARM, 0, 1, 0, 0, 0, 0, 0, 0)
    assert order_after(message.pack(station.mav, force_mavlink1=True)).arming is Arming.ARM
    station.mav.signing.secret_key = bytes(32)
    station.mav.signing.sign_outgoing = True
    assert order_after(message.pack(station.mav)).arming is Arming.ARM


def test_a_frame_with_a_flag_that_is_not_known_is_not_understood() -> None:
    frame = bytearray(arm())
    frame[2] |= 0x02
    frame[-2:] = mavlink.x25crc(frame[1:-2] + bytes([mavlink.MAVLink_command_long_message.crc_extra])).crc.to_bytes(
        2, "little"
    )
    assert order_after(bytes(frame)) is NO_ORDER


def test_a_frame_of_an_unknown_id_is_no_message_and_is_counted() -> None:
    codec = Codec(1)
    unknown = b"\xfd\x02\x00\x00\x00\xff\xbe\xef\xcd\xab\x01\x02\x00\x00"
    messages, looked = codec.parse(unknown + arm(), 32)
    assert [message.get_type() for message in messages] == ["COMMAND_LONG"]
    assert (looked, codec.unknown, codec.malformed) == (2, 1, 0)


@settings(max_examples=20)
@given(st.data())
def test_any_message_with_any_content_is_survived(data) -> None:
    vehicle = node()
    for kind in mavlink.mavlink_map.values():
        payload = data.draw(st.binary(min_size=1, max_size=64))[: kind.unpacker.size] or b"\x01"
        header = bytes([len(payload), 0, 0, 0, 255, 190]) + kind.id.to_bytes(3, "little")
        crc = mavlink.x25crc(bytearray(header + payload + bytes([kind.crc_extra]))).crc
        receive(vehicle, cycle().tick, b"\xfd" + header + payload + crc.to_bytes(2, "little"))
    assert vehicle.links[0].codec.malformed == 0
    for k in range(100):
        parse(vehicle.report(cycle(k))[0])


def test_no_more_is_looked_at_in_a_tick_than_its_share() -> None:
    codec = Codec(1)
    messages, looked = codec.parse(b"\xfd" * 5000, 32)
    assert (messages, looked, codec.dropped) == ([], 32, 1)
    messages, looked = codec.parse(arm() * 40, 32)
    assert (len(messages), looked, codec.dropped) == (32, 32, 2)


@pytest.mark.parametrize("flood", [b"\xfd" * 1000, arm(), b"\x00"])
def test_a_flood_is_cut_and_counted(flood: bytes) -> None:
    vehicle = node()
    (link,) = vehicle.links
    receive(vehicle, cycle().tick, *[flood] * 100)
    assert link.losses["flooding"] >= 100 - limits.MAX_PARSED_PER_TICK
    assert link.lost == sum(link.losses.values())


def test_a_flood_of_questions_fills_no_tick_beyond_its_share() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    names = collections.Counter()
    for _ in range(200):
        for _ in range(40):
            station.command(mavlink.MAV_CMD_DO_PARACHUTE)
        vehicle.step()
        assert len(station.messages) <= limits.MAX_SENT_PER_TICK
        names.update(message.get_type() for message in station.messages)
        station.messages.clear()
    assert (names["HEARTBEAT"], names["ATTITUDE"]) == (2, 20)
    vehicle.step(limits.MAX_WAITING)
    answered = names["COMMAND_ACK"] + len(station.heard("COMMAND_ACK"))
    losses = vehicle.node.links[0].losses
    assert losses["flooding"] == 200 * (40 - limits.MAX_PARSED_PER_TICK)
    assert losses["queue_full"] == 200 * limits.MAX_PARSED_PER_TICK - answered
    vehicle.step(100)
    assert "COMMAND_ACK" not in {message.get_type() for message in station.messages}


def test_services_are_heard_however_much_is_streamed() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    names = DEFAULT_STREAMS.keys() - {mavlink.MAVLINK_MSG_ID_HEARTBEAT}
    for name in names:
        station.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, name, 20000)
        vehicle.step()
    vehicle.step(50)
    station.messages.clear()
    for number in range(10):
        head = bytes((number, 0, 0, 3, 1, 0, 0, 0, 0, 0, 0, 0))  # list the folder of that name
        station.send(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, (head + b"/").ljust(251, b"\0")))
        vehicle.step(3)
        assert len(station.heard("FILE_TRANSFER_PROTOCOL")) == 1
    vehicle.step(50)
    told = collections.Counter(message.get_type() for message in station.messages)
    assert min(told[name] for name in ("ATTITUDE", "VFR_HUD", "SYS_STATUS", "ODOMETRY")) >= 3


def test_every_datagram_fits_into_an_ethernet_frame() -> None:
    vehicle = node()
    for k in range(300):
        text = f"{'a sentence that goes on and on ' * 20}{k}"
        events = (Event(EventKind.CHANGE_FAILED, Severity.WARNING, names=(text,)),) if k % 7 == 0 else ()
        assert len(vehicle.report(cycle(k, events=events))[0]) <= 1400
