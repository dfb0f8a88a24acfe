"""The buses of one machine: python-can's virtual one, and ours over UDP multicast, with a stranger on it."""

from __future__ import annotations

import contextlib
import json
import os
import select
import socket
import subprocess
import sys
import time
from pathlib import Path

import can
import pytest
from dronecan.dsdl.common import crc16_from_bytes

from firmware_py.adapters.buses import multicast_bus
from firmware_py.adapters.buses.can_bus import BusError, open_bus
from firmware_py.adapters.buses.node_id_check import heard_nodes, refuse_if_taken
from firmware_py.wire.dronecan.equipment_messages import ActuatorCommand, ArrayCommand
from firmware_py.wire.dronecan.message_table import ARRAY_COMMAND
from firmware_py.wire.dronecan.transfer import TransferSender
from sim_bridge.devices.node import DeviceNode
from tests.bus_numbers import free_number

from .bus_contract import PATIENCE, BusContract, TwoProcesses, collect, doors

PORT = 57732
EXTENDED = 1 << 31


@pytest.fixture
def number():
    with free_number() as number:
        yield number


class TestVirtual(BusContract):
    @pytest.fixture
    def spec(self):
        return "virtual:contract"

    @pytest.fixture
    def plain(self, spec):
        with can.Bus(interface="virtual", channel="contract") as bus:
            yield bus


class TestPythonCan(BusContract):
    @pytest.fixture
    def spec(self):
        return "python-can:virtual:contract-of-python-can"

    @pytest.fixture
    def plain(self, spec):
        with can.Bus(interface="virtual", channel="contract-of-python-can") as bus:
            yield bus


class TestUdp(BusContract, TwoProcesses):
    @pytest.fixture
    def spec(self, number):
        return f"udp:{number}"

    @pytest.fixture
    def plain(self, number):
        with can.Bus(interface="sternplane_mcast", channel=number) as bus:
            yield bus


def datagram(identifier: int, data: bytes, flags: int = 0, magic: int = 0x2934, crc: int | None = None) -> bytes:
    """As wire.md has it; the checksum is pydronecan's."""
    body = flags.to_bytes(2, "little") + identifier.to_bytes(4, "little") + data
    checksum = crc16_from_bytes(body) if crc is None else crc
    return magic.to_bytes(2, "little") + checksum.to_bytes(2, "little") + body


@pytest.fixture
def raw(number):
    """A bare socket that sends to the group, and one that hears it."""
    group = f"239.65.82.{number}"
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ears,
    ):
        out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        out.connect((group, PORT))
        ears.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        ears.bind((group, PORT))
        membership = socket.inet_aton(group) + socket.inet_aton("127.0.0.1")
        ears.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        ears.settimeout(PATIENCE)
        yield out, ears


@pytest.mark.parametrize("data", [b"", b"\x00", b"12345678"])
def test_a_frame_is_the_datagram_that_others_know(number, raw, data):
    out, ears = raw
    with doors(f"udp:{number}", 1) as (a,):
        a.send([(0x1FFFFFFF, data), (0, data)])
        assert ears.recv(100) == datagram(0x1FFFFFFF | EXTENDED, data)
        assert ears.recv(100) == datagram(EXTENDED, data)
        out.send(datagram(0x155 | EXTENDED, data))
        assert collect(a, 1) == [(0x155, data)]


GARBAGE = {
    "nothing": b"",
    "a byte": b"\x34",
    "a header cut short": datagram(EXTENDED | 1, b"")[:9],
    "wrong magic": datagram(EXTENDED | 1, b"abc", magic=0x2935),
    "wrong checksum": datagram(EXTENDED | 1, b"abc", crc=0x1234),
    "nine bytes in a classic frame": datagram(EXTENDED | 1, bytes(9)),
    "65 bytes in an FD frame": datagram(EXTENDED | 1, bytes(65), flags=1),
    "a whole packet": datagram(EXTENDED | 1, bytes(9000)),
    "a standard id of 12 bits": datagram(0x800, b"abc"),
    "an id with unknown flags": datagram(EXTENDED | 1 << 30, b"abc"),
}


@pytest.mark.parametrize("garbage", GARBAGE.values(), ids=GARBAGE)
def test_a_datagram_that_is_no_frame_is_counted_and_dropped(number, raw, garbage):
    out, _ = raw
    bus = multicast_bus.McastBus(number)
    with bus, doors(f"udp:{number}", 1) as (a,):
        out.send(garbage)
        out.send(datagram(EXTENDED | 2, b"good"))
        assert collect(a, 1) == [(2, b"good")]
        message = bus.recv(PATIENCE)
        assert (message.arbitration_id, bytes(message.data), bus.bad) == (2, b"good", 1)


def test_fd_frames_are_ignored_and_not_bad(number, raw):
    out, _ = raw
    with multicast_bus.McastBus(number) as bus:
        out.send(datagram(EXTENDED | 1, bytes(64), flags=1))
        out.send(datagram(EXTENDED | 1, bytes(3), flags=1))
        out.send(datagram(EXTENDED | 2, b"classic"))
        assert bus.recv(PATIENCE).arbitration_id == 2
        assert bus.bad == 0


def test_a_flood_costs_no_more_than_the_limit_and_what_the_kernel_drops_is_counted(number, raw):
    out, _ = raw
    with doors(f"udp:{number}", 1) as (a,):
        for k in range(20_000):
            out.send(datagram(EXTENDED | k, b"12345678"))
        assert [can_id for can_id, _ in a.drain(100)] == list(range(100))
        rest = a.drain(20_000)
        assert 0 < a.losses()["overrun"] <= 20_000 - 100 - len(rest)


def test_no_frame_leaves_the_machine(number, raw):
    _, ears = raw
    ears.setsockopt(socket.IPPROTO_IP, 12, 1)  # IP_RECVTTL, which the socket module does not name
    with doors(f"udp:{number}", 1) as (a,):
        a.send([(1, b"x")])
        _, control, _, source = ears.recvmsg(100, socket.CMSG_SPACE(4))
    assert [int.from_bytes(value, "little") for _, kind, value in control if kind == socket.IP_TTL] == [0]
    assert source[0] == "127.0.0.1"


def test_a_sender_on_another_machine_is_not_heard(number, raw, monkeypatch):
    """A sender on 127.0.0.5 is of this machine, unless no address but 127.0.0.1 is."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other, doors(f"udp:{number}", 1) as (a,):
        other.bind(("127.0.0.5", 0))
        other.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        monkeypatch.setattr(multicast_bus, "is_local", lambda address: address == "127.0.0.1")
        other.sendto(datagram(EXTENDED | 5, b"far"), (multicast_bus.group(number), PORT))
        raw[0].send(datagram(EXTENDED | 5, b"near"))
        assert collect(a, 1) == [(5, b"near")]
        monkeypatch.undo()
        other.sendto(datagram(EXTENDED | 5, b"near too"), (multicast_bus.group(number), PORT))
        assert collect(a, 1) == [(5, b"near too")]


def test_an_address_that_this_machine_does_not_have_is_not_local():
    assert multicast_bus.is_local("127.0.0.5")
    assert not multicast_bus.is_local("198.51.100.7")


def test_buses_of_other_numbers_are_other_buses(raw, number):
    other = (number + 1) % 10
    with doors(f"udp:{number}", 1) as (a,), doors(f"udp:{other}", 1) as (b,):
        raw[0].send(datagram(EXTENDED | 1, b"not to b"))
        assert collect(a, 1) == [(1, b"not to b")]
        assert (1, b"not to b") not in b.drain(99)


def test_python_can_refuses_what_the_bus_cannot_carry(number):
    with can.Bus(interface="sternplane_mcast", channel=str(number)) as bus:
        for flag in ("is_fd", "is_remote_frame", "is_error_frame"):
            with pytest.raises(can.CanOperationError, match="classic data frames alone"):
                bus.send(can.Message(arbitration_id=1, **{flag: True}))


def test_python_cans_filters_and_waits_work(number, raw):
    filters = [{"can_id": 0x100, "can_mask": 0x1FFFFF00, "extended": True}]
    with can.Bus(interface="sternplane_mcast", channel=number, can_filters=filters) as bus:
        for identifier in (0x200, 0x1AA, 0x300, 0x1BB):
            raw[0].send(datagram(EXTENDED | identifier, b""))
        assert [bus.recv(PATIENCE).arbitration_id for _ in range(2)] == [0x1AA, 0x1BB]
        assert bus.recv(0.001) is None
        assert select.select([bus], [], [], 0)[0] == []


@pytest.mark.parametrize("spec", ["udp", "udp:10", "udp:-1", "udp:", "udp:x", "udp:1.0", "udp: 1"])
def test_a_bus_number_out_of_range_is_one_line_that_says_what_is_right(spec):
    with pytest.raises(BusError) as failure:
        open_bus(spec)
    assert str(failure.value).startswith(f"bus {spec!r} cannot be opened: there is no bus")
    assert "a number from 0 to 9" in str(failure.value)


@pytest.mark.parametrize("spec", ["", "virtuel", "UDP:1"])
def test_a_bus_that_nobody_knows_is_one_line_that_says_which_are_known(spec):
    with pytest.raises(BusError) as failure:
        open_bus(spec)
    known = "virtual, udp:N, socketcan:IFACE, python-can:INTERFACE:CHANNEL@BITRATE"
    assert str(failure.value) == f"bus {spec!r} is not known; write one of: {known}"


@pytest.mark.parametrize("spec", ["can0", "vcan1", "slcan0"])
def test_the_name_of_an_interface_alone_is_told_how_to_be_written(spec):
    with pytest.raises(BusError, match=f"^bus '{spec}' is not known; write socketcan:{spec} for the interface"):
        open_bus(spec)


def test_the_channel_tells_virtual_buses_apart_unless_the_name_does():
    with contextlib.ExitStack() as stack:
        pairs = [("virtual", "one"), ("virtual:one", "two"), ("virtual", "two")]
        a, b, c = (stack.enter_context(contextlib.closing(open_bus(*pair))) for pair in pairs)
        a.send([(1, b"x")])
        assert (a.name, b.name, c.name) == ("virtual:one", "virtual:one", "virtual:two")
        assert (b.drain(9), c.drain(9)) == ([(1, b"x")], [])


@pytest.mark.parametrize("interface", ["", "nosuch0", "a-name-that-is-too-long"])
def test_a_kernel_interface_that_is_not_there_is_one_line(interface, capfd):
    with pytest.raises(BusError) as failure:
        open_bus(f"socketcan:{interface}")
    assert str(failure.value).startswith(f"bus 'socketcan:{interface}' cannot be opened: ")
    assert "\n" not in str(failure.value)
    assert capfd.readouterr() == ("", "")


class Stranger:
    """pydronecan in another process."""

    def __init__(self, number: int) -> None:
        command = [sys.executable, str(Path(__file__).with_name("foreign_node.py")), str(number)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._output = b""

    def __enter__(self) -> Stranger:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.stdin.close()
        self.process.wait(PATIENCE)
        self.process.stdout.close()

    def said(self) -> list[dict[str, object]]:
        """All that it has said so far."""
        while select.select([self.process.stdout], [], [], 0)[0]:
            self._output += os.read(self.process.stdout.fileno(), 65536)
        return [json.loads(line) for line in self._output.split(b"\n")[:-1]]


def test_pydronecan_and_we_are_nodes_of_one_bus(number):
    fins = ArrayCommand((ActuatorCommand(0, 1, 0.25), ActuatorCommand(1, 1, -0.125)))
    wanted = [
        {"node": 21, "name": "org.sternplane.sim.servo_hub"},
        {"commanded_by": 10, "fins": [0.25, -0.125]},
    ]
    with doors(f"udp:{number}") as (ours, autopilots), Stranger(number) as stranger:
        hub, autopilot = DeviceNode(21, "servo_hub", ours), TransferSender(10)
        sources: set[int] = set()
        deadline = time.monotonic() + 2 * PATIENCE
        while not (100 in sources and all(line in stranger.said() for line in wanted)):
            assert time.monotonic() < deadline, (sources, stranger.said())
            hub.publish_status(time.monotonic())
            autopilots.send(autopilot.send(ARRAY_COMMAND, fins))
            for can_id, data in ours.drain(100, 0.2):
                sources.add(can_id & 0x7F)
                hub.accept_request(can_id, data, time.monotonic())
        assert heard_nodes(autopilots)[100] == "org.example.stranger"
        with pytest.raises(BusError) as failure:
            refuse_if_taken(autopilots, {10: "autopilot", 100: "servo_hub"})
        assert str(failure.value).startswith(f"udp:{number} is in use by node 100 (org.example.stranger); ")


def status(node_id: int) -> tuple[int, bytes]:
    """A frame of NodeStatus; 0 is a node that has no id yet."""
    return 16 << 24 | 341 << 8 | node_id, bytes(7) + b"\xc0"


def test_a_bus_with_others_on_it_is_not_taken_as_long_as_they_are_not_we(number):
    with doors(f"udp:{number}") as (a, b):
        b.send([status(50), status(0)])
        refuse_if_taken(a, {10: "autopilot", 21: "servo_hub"}, 0.1)
        b.send([status(21)])
        with pytest.raises(BusError, match=r"in use by node 21 \(our servo_hub\); end that run, or"):
            refuse_if_taken(a, {10: "autopilot", 21: "servo_hub"}, 0.1)
