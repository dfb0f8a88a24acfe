"""One node on python-can's virtual bus."""

from __future__ import annotations

import errno
import itertools

import can
import pytest
from can.interfaces import virtual
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.buses.can_bus import CanBus, NodeIds, open_bus
from firmware_py.adapters.buses.multicast_bus import McastBus
from firmware_py.adapters.buses.virtual_bus import VirtualFrameBus
from firmware_py.params import ParamError, load

_channels = itertools.count()
FRAMES = st.lists(st.tuples(st.integers(0, 2**29 - 1), st.binary(max_size=8)), max_size=30)


class Pair:
    """Two nodes of ours on one bus, and one of python-can's."""

    def __enter__(self) -> Pair:
        channel = f"pair-{next(_channels)}"
        self.a, self.b = open_bus("virtual", channel), open_bus("virtual", channel)
        self.plain = can.Bus(interface="virtual", channel=channel)
        return self

    def __exit__(self, *_: object) -> None:
        self.a.close()
        self.b.close()
        self.plain.shutdown()


@pytest.fixture
def pair():
    with Pair() as pair:
        yield pair


@given(FRAMES, st.integers(1, 40))
def test_frames_arrive_whole_and_in_order_at_most_so_many_at_once_and_not_at_the_sender(frames, limit):
    with Pair() as pair:
        pair.a.send(frames)
        heard: list[tuple[int, bytes]] = []
        while portion := pair.b.drain(limit):
            assert len(portion) == min(limit, len(frames) - len(heard))
            heard += portion
        assert heard == frames
        assert all(type(data) is bytes for _, data in heard)
        assert pair.a.drain(100) == []
        assert pair.a.losses() == pair.b.losses() == {"not_sent": 0, "overrun": 0, "failed_drains": 0}


def test_python_cans_own_bus_hears_us_and_we_hear_it(pair):
    pair.a.send([(0x1ABCDEF, b"123")])
    message = pair.plain.recv(0)
    assert (message.arbitration_id, message.data, message.dlc) == (0x1ABCDEF, b"123", 3)
    assert message.is_extended_id
    assert (message.is_fd, message.is_remote_frame, message.is_error_frame) == (False, False, False)
    pair.plain.send(can.Message(arbitration_id=7, data=b"\x01"))
    assert pair.a.drain(9) == [(7, b"\x01")]
    assert pair.b.drain(9) == [(0x1ABCDEF, b"123"), (7, b"\x01")]


@pytest.mark.parametrize("flag", ["is_remote_frame", "is_error_frame", "is_fd"])
def test_what_is_not_an_extended_data_frame_is_skipped_and_costs_its_share_of_the_limit(pair, flag):
    pair.plain.send(can.Message(arbitration_id=1, is_extended_id=False))
    pair.plain.send(can.Message(arbitration_id=2, **{flag: True}))
    pair.plain.send(can.Message(arbitration_id=3))
    assert pair.a.drain(2) == []
    assert pair.a.drain(2) == [(3, b"")]


def test_a_frame_that_the_kernel_does_not_take_costs_that_frame_alone(monkeypatch):
    taken = []

    class Kernel:
        def send(self, datagram):
            taken.append(datagram)
            if len(taken) == 2:
                raise OSError(errno.ENOBUFS, "no buffer")

    with McastBus(9) as bus:
        monkeypatch.setattr(bus, "_sender", Kernel())
        node = CanBus(bus)
        node.send([(1, b""), (2, b""), (3, b"")])
        assert len(taken) == 3
        assert node.losses()["not_sent"] == 1
        monkeypatch.undo()


def test_a_bus_that_fails_is_silent_and_is_counted(pair):
    class Failing(VirtualFrameBus):
        def send_frames(self, frames):
            return super().send_frames(frames[:1]) + len(frames[1:])

        def receive_frames(self, frames, limit):
            raise OSError(errno.ENETDOWN, "network is down")

    node = CanBus(Failing(pair.plain.channel_id))
    node.send([(1, b""), (2, b""), (3, b"")])
    assert pair.a.drain(9) == [(1, b"")]
    assert node.drain(10) == []
    assert node.losses() == {"not_sent": 2, "overrun": 0, "failed_drains": 1}
    node.close()


def test_python_cans_own_receive_call_reads_our_frames(pair):
    with VirtualFrameBus(pair.plain.channel_id) as bus:
        pair.a.send([(0x1ABCDEF, b"123")])
        pair.plain.send(can.Message(arbitration_id=7, data=b"x"))
        first, second = bus.recv(0), bus.recv(0)
        assert (first.arbitration_id, bytes(first.data), first.is_extended_id) == (0x1ABCDEF, b"123", True)
        assert (second.arbitration_id, bytes(second.data)) == (7, b"x")
        assert bus.recv(0) is None


def test_leaving_twice_is_leaving_and_the_others_stay(pair):
    pair.a.close()
    pair.a.close()
    pair.b.send([(1, b"x")])
    assert pair.plain.recv(0).data == b"x"
    assert pair.a.drain(5) == []


def test_when_the_last_has_left_nothing_collects_frames():
    with Pair() as pair:
        channel = pair.plain.channel_id
        assert len(virtual.channels[channel]) == 3
    assert channel not in virtual.channels


IDS = {"servo_hub": 1, "esc": 2, "ahrs": 3, "pressure": 4, "altimeter": 5, "fix": 6, "battery": 127}


def test_roles_may_have_one_id():
    assert load(NodeIds, IDS | {"fix": 2}, "io.toml").by_name == {**IDS, "fix": 2, "hardpoint": 28}


@pytest.mark.parametrize("wrong", [0, 128, 1.5, "3"])
def test_a_node_id_out_of_range_is_refused(wrong):
    with pytest.raises(ParamError, match="esc"):
        load(NodeIds, IDS | {"esc": wrong}, "io.toml")
