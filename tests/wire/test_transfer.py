"""Frames are pydronecan's; what is lost, twice, out of order, interleaved or foreign is dropped and counted."""

from __future__ import annotations

import dataclasses
import random
import tracemalloc

import pytest
from dronecan.transport import Frame, Transfer, TransferError
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan import node_messages as nodes
from firmware_py.wire.dronecan.message_table import BY_ID, TransferKind
from firmware_py.wire.dronecan.transfer import (
    TIMEOUT,
    Dropped,
    Reassembler,
    TransferSender,
    anonymous,
    can_id,
    frames_of,
)

FIX2, GET_NODE_INFO_RESPONSE = m.FIX2, m.GET_NODE_INFO_RESPONSE
PRESSURE = eq.StaticPressure(101325.0, 4.0)
FLAT = eq.AhrsSolution(1, (0.0, 0.0, 0.0, 1.0), (), (0.0, 0.0, 0.0), (), (0.0, 0.0, 0.0))
FIX = FIX2.decode(bytes(50))
ALL = tuple(BY_ID.values())


def dropped(reassembler):
    """The counters that are not 0."""
    return {name: count for name, count in dataclasses.asdict(reassembler.dropped).items() if count}


def accept_all(reassembler, frames, t=0.0):
    return [done for identifier, data in frames if (done := reassembler.accept(identifier, data, t)) is not None]


def theirs(kind, payload, transfer_id, source, destination=None, priority=16):
    """pydronecan's transfer of a payload."""
    transfer = Transfer(
        transfer_id,
        source,
        destination,
        transfer_priority=priority,
        service_not_message=kind.kind is not TransferKind.MESSAGE,
        request_not_response=kind.kind is TransferKind.REQUEST,
    )
    transfer.payload = bytearray(payload)
    transfer.data_type_id, transfer.data_type_crc = kind.data_type_id, kind.crc_seed
    return transfer


@given(payload=st.binary(max_size=7), discriminator=st.integers(0, 0x3FFF), transfer_id=st.integers(0, 31))
def test_a_message_of_a_node_without_an_id_is_heard_as_pydronecan_sends_it(payload, discriminator, transfer_id):
    transfer = theirs(m.ALLOCATION, payload, transfer_id, 0, priority=30)
    transfer.discriminator = discriminator
    [frame] = transfer.to_frames()
    heard = anonymous(m.ALLOCATION, frame.message_id, bytes(frame.bytes), 1.5)
    assert heard == (m.ALLOCATION, 0, transfer_id, 30, payload, 1.5)
    assert anonymous(m.ALLOCATION, frame.message_id | 5, bytes(frame.bytes), 1.5) is None
    assert anonymous(m.ALLOCATION, frame.message_id ^ 0x300, bytes(frame.bytes), 1.5) is None
    for tail in (0x80, 0x40, 0x20, 0xE0):
        assert anonymous(m.ALLOCATION, frame.message_id, payload + bytes((tail,)), 1.5) is None
    assert anonymous(m.ALLOCATION, frame.message_id, b"", 1.5) is None


@given(
    payload=st.binary(max_size=200),
    kind=st.sampled_from(ALL),
    transfer_id=st.integers(0, 31),
    source=st.integers(1, 127),
    destination=st.integers(1, 127),
    priority=st.integers(0, 31),
)
def test_frames_are_those_of_pydronecan(peer, payload, kind, transfer_id, source, destination, priority):
    service = kind.kind is not TransferKind.MESSAGE
    transfer = theirs(kind, payload, transfer_id, source, destination if service else None, priority)
    expected = [(f.message_id, bytes(f.bytes)) for f in transfer.to_frames()]
    identifier = can_id(kind, source, priority, destination)
    assert frames_of(identifier, payload, transfer_id, kind.crc_seed) == expected


@pytest.mark.parametrize("length", [0, 1, 6, 7, 8, 11, 12, 13, 14, 62, 221, 222])
def test_every_length_arrives(length):
    payload = bytes(i * 37 & 0xFF for i in range(length))
    reassembler = Reassembler([FIX2])
    frames = frames_of(can_id(FIX2, 42, 3), payload, 9, FIX2.crc_seed)
    assert len(frames) == (1 if length < 8 else -(-(length + 2) // 7))
    (transfer,) = accept_all(reassembler, frames, t=1.5)
    assert transfer == (FIX2, 42, 9, 3, payload, 1.5)
    assert reassembler.dropped == Dropped()


def test_pydronecan_reads_our_frames_and_we_read_its(peer):
    status = eq.ActuatorStatus(3, 0.25, float("nan"), float("nan"), 127)
    fix = FIX._replace(covariance=(1.0, 2.0, 3.0), pdop=1.5)
    for kind, record in ((m.ACTUATOR_STATUS, status), (FIX2, fix), (m.AHRS_SOLUTION, FLAT)):
        ours = TransferSender(11).send(kind, record, priority=5)
        transfer = Transfer()
        transfer.from_frames([Frame(identifier, data) for identifier, data in ours])
        assert (transfer.source_node_id, transfer.transfer_priority) == (11, 5)
        assert repr(peer.record(kind, transfer.payload)) == repr(record)
        back = Transfer(4, 99, payload=peer.make(kind, record)).to_frames()
        (done,) = accept_all(Reassembler([kind]), [(f.message_id, bytes(f.bytes)) for f in back])
        assert (done.source, done.transfer_id) == (99, 4)
        assert repr(kind.decode(done.payload)) == repr(record)


def test_a_service_goes_there_and_back(peer):
    client, server = TransferSender(5), TransferSender(9)
    at_server = Reassembler([m.GET_NODE_INFO], node_id=9)
    at_client = Reassembler([GET_NODE_INFO_RESPONSE], node_id=5)
    for expected_id in range(3):
        frames = client.send(m.GET_NODE_INFO, nodes.GetNodeInfoRequest(), 20, destination=9)
        assert [
            (f.message_id, bytes(f.bytes)) for f in theirs(m.GET_NODE_INFO, b"", expected_id, 5, 9, 20).to_frames()
        ] == frames
        (request,) = accept_all(at_server, frames)
        info = nodes.GetNodeInfoResponse(
            nodes.NodeStatus(7),
            nodes.SoftwareVersion(1, 2),
            nodes.HardwareVersion(3),
            b"org.sternplane.fins",
        )
        answer = server.respond(request, GET_NODE_INFO_RESPONSE, info)
        transfer = Transfer()
        transfer.from_frames([Frame(identifier, data) for identifier, data in answer])
        assert (transfer.dest_node_id, transfer.transfer_id, str(transfer.payload.name)) == (
            5,
            expected_id,
            "org.sternplane.fins",
        )
        assert accept_all(at_server, answer) == []
        (response,) = accept_all(at_client, answer)
        assert (response.source, response.transfer_id) == (9, expected_id)
        assert GET_NODE_INFO_RESPONSE.decode(response.payload) == info
    assert dropped(at_client) == {}
    assert set(dropped(at_server)) == {"foreign"}


def test_a_sender_counts_per_type_and_destination_modulo_32():
    sender = TransferSender(1)
    ids = [sender.send(m.STATIC_PRESSURE, PRESSURE)[0][1][-1] & 31 for _ in range(34)]
    assert ids == [*range(32), 0, 1]
    assert sender.send(m.NODE_STATUS, nodes.NodeStatus(0))[0][1][-1] == 0xC0
    ask = [sender.send(m.GET_NODE_INFO, nodes.GetNodeInfoRequest(), destination=d)[0][1][-1] & 31 for d in (2, 3, 2)]
    assert ask == [0, 0, 1]


def test_a_sender_refuses_what_has_no_address():
    with pytest.raises(ValueError, match="127"):
        TransferSender(0)
    with pytest.raises(ValueError, match="destination 0"):
        TransferSender(1).send(m.GET_NODE_INFO, nodes.GetNodeInfoRequest())
    with pytest.raises(ValueError, match="priority 32"):
        TransferSender(1).send(m.STATIC_PRESSURE, PRESSURE, priority=32)
    with pytest.raises(ValueError, match="destination 0"):
        Reassembler([m.GET_NODE_INFO])


def long_frames(source, count=1):
    """Transfers of 5 frames."""
    sender = TransferSender(source)
    return [sender.send(m.AHRS_SOLUTION, FLAT) for _ in range(count)]


@pytest.mark.parametrize("lost", range(5))
def test_a_lost_frame_loses_its_transfer_and_no_other(lost):
    first, second, third = long_frames(7, 3)
    reassembler = Reassembler([m.AHRS_SOLUTION])
    done = accept_all(reassembler, first + second[:lost] + second[lost + 1 :] + third)
    assert [transfer.transfer_id for transfer in done] == [0, 2]
    assert dropped(reassembler)


def test_each_loss_is_counted_as_what_it_is():
    def counted(frames):
        reassembler = Reassembler([m.AHRS_SOLUTION])
        assert [t.transfer_id for t in accept_all(reassembler, frames + long_frames(7, 2)[1])] == [1]
        return dropped(reassembler)

    (one,) = long_frames(7)
    flipped = [*one[:2], (one[2][0], bytes((one[2][1][0] ^ 1,)) + one[2][1][1:]), *one[3:]]
    assert counted(one[1:]) == {"lost_start": 4}
    assert counted(one[:-1]) == {"unfinished": 1}
    assert counted([one[0], *one[2:]]) == {"wrong_toggle": 1, "bad_crc": 1}
    assert counted([one[0], *one[3:]]) == {"bad_crc": 1}
    assert counted(flipped) == {"bad_crc": 1}


def test_a_frame_twice_does_no_harm():
    (frames,) = long_frames(7)
    doubled = [frames[0], *[frame for frame in frames[1:-1] for _ in (0, 1)], frames[-1], frames[-1]]
    reassembler = Reassembler([m.AHRS_SOLUTION, m.STATIC_PRESSURE])
    assert len(accept_all(reassembler, doubled)) == 1
    assert dropped(reassembler) == {"wrong_toggle": 3, "lost_start": 1}
    single = TransferSender(7).send(m.STATIC_PRESSURE, PRESSURE)
    assert len(accept_all(reassembler, single * 3)) == 1
    assert reassembler.dropped.duplicate == 2
    assert len(accept_all(reassembler, single, t=TIMEOUT + 0.1)) == 1


@pytest.mark.parametrize("kind", [m.AHRS_SOLUTION, m.STATIC_PRESSURE])
def test_another_transfer_arrives_after_a_round_of_ids_was_lost(kind):
    sender, reassembler = TransferSender(7), Reassembler([kind])
    values = {m.AHRS_SOLUTION: (FLAT, FLAT._replace(timestamp=2))}.get(kind, (PRESSURE, eq.StaticPressure(9e4, 4.0)))
    first, *_, last = [sender.send(kind, values[i == 32]) for i in range(33)]
    done = accept_all(reassembler, first + first + last)
    assert [(one.transfer_id, kind.decode(one.payload)) for one in done] == [(0, values[0]), (0, values[1])]
    assert reassembler.dropped.duplicate == 1


def test_frames_out_of_order_give_no_transfer():
    (frames,) = long_frames(7)
    for i in range(1, 4):
        swapped = [*frames[:i], frames[i + 1], frames[i], *frames[i + 2 :]]
        assert accept_all(Reassembler([m.AHRS_SOLUTION]), swapped) == []


@given(st.randoms(use_true_random=False))
def test_interleaved_sources_and_types_all_arrive(rng):
    queues = []
    for source in (3, 4, 120):
        sender = TransferSender(source)
        for kind, record in (
            (m.AHRS_SOLUTION, FLAT),
            (FIX2, FIX),
            (m.STATIC_PRESSURE, PRESSURE),
        ):
            queues.append([frame for _ in range(3) for frame in sender.send(kind, record)])
    wanted = Reassembler([m.AHRS_SOLUTION, FIX2, m.STATIC_PRESSURE])
    mixed = []
    while queues:
        queue = rng.choice(queues)
        mixed.append(queue.pop(0))
        queues = [q for q in queues if q]
    done = accept_all(wanted, mixed)
    assert sorted((t.source, t.kind.data_type_id, t.transfer_id) for t in done) == sorted(
        (source, kind, i) for source in (3, 4, 120) for kind in (1000, 1028, 1063) for i in range(3)
    )
    assert wanted.dropped == Dropped()


def test_foreign_frames_are_counted_and_forgotten():
    reassembler = Reassembler([m.STATIC_PRESSURE, GET_NODE_INFO_RESPONSE], node_id=5)
    (identifier, data), *_ = TransferSender(7).send(m.STATIC_PRESSURE, PRESSURE)
    elsewhere = frames_of(can_id(GET_NODE_INFO_RESPONSE, 7, destination=6), b"", 0, 0)[0]
    foreign = [
        (identifier + (1 << 8), data),  # another type
        (identifier & ~0x7F, data),  # anonymous
        (identifier | 1 << 29, data),
        (-1, data),
        (identifier, b""),
        (identifier, data + bytes(8)),
        elsewhere,
    ]
    assert accept_all(reassembler, foreign) == []
    assert dropped(reassembler) == {"foreign": len(foreign)}


def test_a_transfer_that_takes_too_long_is_given_up():
    (frames,) = long_frames(7)
    reassembler = Reassembler([m.AHRS_SOLUTION])
    assert accept_all(reassembler, frames[:2], t=10.0) == []
    assert accept_all(reassembler, frames[2:], t=10.1 + TIMEOUT) == []
    assert dropped(reassembler) == {"timed_out": 1, "lost_start": 3}
    assert len(accept_all(reassembler, frames, t=20.0)) == 1


def test_a_transfer_longer_than_its_type_is_cut_off():
    frames = frames_of(can_id(m.AHRS_SOLUTION, 7), bytes(100), 0, m.AHRS_SOLUTION.crc_seed)
    reassembler = Reassembler([m.AHRS_SOLUTION])
    assert accept_all(reassembler, frames) == []
    assert reassembler.dropped.too_long == 1


def test_open_transfers_are_bounded_and_the_oldest_gives_way():
    reassembler = Reassembler([m.AHRS_SOLUTION], most_open=8)
    transfers = {source: long_frames(source)[0] for source in range(1, 11)}
    for frames in transfers.values():
        accept_all(reassembler, frames[:1])
    assert dropped(reassembler) == {"crowded_out": 2}
    done = [source for source, frames in transfers.items() if accept_all(reassembler, frames[1:])]
    assert done == list(range(3, 11))


def test_random_frames_never_raise_and_never_fill_the_memory():
    rng = random.Random(1)
    reassembler = Reassembler(ALL, node_id=5, most_open=16)
    ports = [can_id(kind, 1, 0, 5) & ~0x7F for kind in ALL]
    arrived = 0
    tracemalloc.start()
    for i in range(60_000):
        identifier = (
            rng.getrandbits(29) if i % 3 == 0 else rng.choice(ports) | rng.getrandbits(7) | rng.getrandbits(5) << 24
        )
        data = rng.randbytes(rng.choice((0, 1, 3, 8, 8, 8, 8, 9)))
        t = rng.choice((0.01 * i, 0.0, -1.0, float("nan"), float("inf")))
        transfer = reassembler.accept(identifier, data, t)
        if transfer is not None:
            arrived += 1
            assert len(transfer.payload) <= transfer.kind.max_bytes + 7
    del transfer, data
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert arrived > 100
    assert kept < 300 * len(ALL) * 127  # bytes: some hundred for each type and source, however many frames arrive


@given(payload=st.binary(min_size=8, max_size=60), position=st.integers(0, 10**6), bit=st.integers(0, 7))
def test_one_flipped_bit_never_passes_as_the_same_transfer(peer, payload, position, bit):
    """What pydronecan's check of a whole transfer refuses, we do not deliver."""
    frames = frames_of(can_id(FIX2, 9), payload, 3, FIX2.crc_seed)
    i = position % len(frames)
    identifier, data = frames[i]
    at = position // len(frames) % len(data)
    frames[i] = (identifier, data[:at] + bytes((data[at] ^ 1 << bit,)) + data[at + 1 :])
    done = accept_all(Reassembler([FIX2]), frames)
    try:
        Transfer().from_frames([Frame(*frame) for frame in frames])
    except (TransferError, ValueError, IndexError):
        assert all(transfer.payload != payload for transfer in done)
    assert all(transfer.payload == payload for transfer in done if len(transfer.payload) > 7)
