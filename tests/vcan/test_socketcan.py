"""The kernel's CAN: the contract of every bus, an interface that goes and comes, and what candump sees."""

from __future__ import annotations

import contextlib
import os
import select
import subprocess
import time
from collections.abc import Callable

import can
import pytest

from firmware_py.adapters.buses.awaited_bus import AwaitedBus
from firmware_py.adapters.buses.can_bus import BusError, open_bus
from firmware_py.adapters.buses.node_id_check import refuse_if_taken
from firmware_py.wire.dronecan.equipment_messages import ActuatorCommand, ArrayCommand
from firmware_py.wire.dronecan.message_table import ARRAY_COMMAND
from firmware_py.wire.dronecan.transfer import TransferSender
from tests.contract.bus_contract import BusContract, TwoProcesses, collect, doors
from tests.contract.node_contract import NodeContract

pytestmark = pytest.mark.vcan
SPEC = "socketcan:vcan0"


@pytest.fixture(autouse=True)
def interfaces():
    assert os.environ.get("VCAN_ACTIVE"), "no SocketCAN interfaces here; run these by: make test-vcan"


def ip(*words: str) -> None:
    subprocess.run(["ip", "link", *words], check=True)


class TestNodes(NodeContract):
    @pytest.fixture
    def spec(self):
        return SPEC


class TestSocketCan(BusContract, TwoProcesses):
    @pytest.fixture
    def spec(self):
        return SPEC

    @pytest.fixture
    def plain(self):
        with can.Bus(interface="socketcan", channel="vcan0") as bus:
            yield bus

    def test_an_interface_that_goes_down_is_silence_until_it_is_up_again(self, spec):
        with doors(spec) as (a, listener), self.peer("echo", spec):
            a.send([(1, b"before")])
            assert collect(a, 1) == [(2, b"before")]
            assert collect(listener, 2) == [(1, b"before"), (2, b"before")]
            ip("set", "vcan0", "down")
            try:
                a.send([(1, b"lost"), (1, b"lost too")])
                assert a.drain(9, 0.01) == []
                assert listener.drain(9) == []
                assert listener.drain(9, 0.01) == []
                assert not a.sound
                assert not listener.sound
                assert a.losses()["down"] == listener.losses()["down"] == 1
            finally:
                ip("set", "vcan0", "up")
            a.send([(1, b"after")])
            assert collect(a, 1) == [(2, b"after")]
            assert collect(listener, 2) == [(1, b"after"), (2, b"after")]
            assert a.losses() == {"not_sent": 2, "overrun": 0, "failed_drains": 0}
            assert a.sound
            assert listener.losses() == {"not_sent": 0, "overrun": 0, "failed_drains": 1}

    def test_an_interface_that_is_unplugged_is_silence_and_not_sound(self):
        ip("add", "dev", "vcan3", "type", "vcan")
        ip("set", "vcan3", "up")
        with doors("socketcan:vcan3", 1) as (a,):
            ip("del", "vcan3")
            assert a.drain(9) == []
            a.send([(1, b"lost")])
            assert (a.drain(9), a.sound) == ([], False)

    @pytest.mark.parametrize("standard", [False, True])
    def test_error_frames_are_counted_tell_the_state_of_the_bus_and_are_not_handed_on(self, spec, plain, standard):
        def report(identifier: int, second: int = 0) -> None:
            data = bytes((0, second, 0, 0, 0, 0, 0, 0))
            plain.send(can.Message(arbitration_id=identifier, data=data, is_error_frame=True, is_extended_id=False))

        states = []
        with contextlib.closing(open_bus(spec, standard=standard)) as a:
            for words in ((0x004, 0x20), (0x040,), (0x100,), (0x004, 0x10), (0x004, 0x40)):
                report(*words)
                assert a.drain(9, 0.05) == []
                states.append(a.sound)
            assert states == [False, False, True, False, True]
            report(0x040)
            assert (a.drain(9, 0.05), a.sound) == ([], False)
            plain.send(can.Message(arbitration_id=7, data=b"x"))
            assert collect(a, 1) == [(7, b"x")]
            assert a.sound
            counts = {"error_passive": 2, "error_bus_off": 2, "error_restarted": 1, "error_active_again": 1}
            assert a.losses() == {"not_sent": 0, "overrun": 0, "failed_drains": 0} | counts

    def test_remote_requests_are_not_delivered(self, spec, plain):
        with doors(spec, 1) as (a,):
            plain.send(can.Message(arbitration_id=5, is_remote_frame=True))
            plain.send(can.Message(arbitration_id=6, data=b"x"))
            assert collect(a, 1) == [(6, b"x")]

    def test_fd_frames_are_not_delivered(self, spec):
        with can.Bus(interface="socketcan", channel="vcan0", fd=True) as fd, doors(spec, 1) as (a,):
            fd.send(can.Message(arbitration_id=5, is_fd=True, data=bytes(20)))
            fd.send(can.Message(arbitration_id=6, data=b"x"))
            assert collect(a, 1) == [(6, b"x")]

    def test_what_the_kernel_drops_is_counted(self, spec):
        with doors(spec) as (a, b):
            b.send([(k, b"12345678") for k in range(20_000)])
            assert 0 < a.losses()["overrun"] <= 20_000 - len(a.drain(20_000))


def test_candump_sees_the_command_to_a_fin():
    """Node 10, priority 16, type 1010; fin 0, radians, float16 of 0.25 is 0x3400; then the tail of a first transfer."""
    with subprocess.Popen(["candump", "-L", "vcan0"], stdout=subprocess.PIPE, text=True) as candump:
        try:
            with doors(SPEC, 1) as (a,):
                while not select.select([candump.stdout], [], [], 0.05)[0]:
                    sender = TransferSender(10)
                    a.send(sender.send(ARRAY_COMMAND, ArrayCommand((ActuatorCommand(0, 1, 0.25),))))
                assert candump.stdout.readline().split()[1:3] == ["vcan0", "1003F20A#00010034C0"]
        finally:
            candump.kill()


def test_a_bus_with_our_ids_on_it_is_refused():
    with doors(SPEC) as (a, b):
        b.send(TransferSender(21).send(ARRAY_COMMAND, ArrayCommand(())))
        with pytest.raises(BusError, match=r"^socketcan:vcan0 is in use by node 21 \(our servo_hub\)"):
            refuse_if_taken(a, {21: "servo_hub"}, 0.1)


def said_of(spec: str) -> str:
    with pytest.raises(BusError) as failure:
        open_bus(spec)
    text = str(failure.value)
    assert text.startswith(f"bus {spec!r} cannot be opened: ")
    return text.partition("opened: ")[2]


@pytest.mark.parametrize("name", ["vcan7", "can0"])
def test_a_missing_interface_is_one_line_that_says_how_to_make_it(name, capfd):
    assert said_of(f"socketcan:{name}") == (
        f"there is no interface {name!r}; a virtual one is made by: "
        f"ip link add dev {name} type vcan; ip link set {name} up"
    )
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("name", "up"), [("vcan5", "up"), ("can5", "up type can bitrate 1000000")])
def test_an_interface_that_is_down_is_one_line_that_says_how_to_bring_it_up(name, up):
    ip("add", "dev", name, "type", "vcan")
    try:
        assert said_of(f"socketcan:{name}") == f"the interface is down; bring it up: ip link set {name} {up}"
    finally:
        ip("del", name)


def test_an_interface_without_can_is_called_so():
    assert said_of("socketcan:lo") == "'lo' is no CAN interface"


def test_a_bus_without_an_interface_is_not_all_of_them():
    assert said_of("socketcan:") == "which interface? write socketcan:IFACE"


@pytest.mark.parametrize("standard", [False, True])
def test_a_bus_whose_interface_is_made_taken_away_and_made_again_is_waited_for(standard):
    """As a USB adapter that is plugged in after the start, unplugged, and plugged in again."""
    bus = AwaitedBus("socketcan:vcan9", standard=standard)
    assert "there is no interface" in bus.missing
    for _ in range(2):
        ip("add", "dev", "vcan9", "type", "vcan")
        try:
            until(bus, lambda: "is down" in bus.missing)
            ip("set", "vcan9", "up")
            until(bus, lambda: bus.missing == "")
            with doors("socketcan:vcan9", 1) as (peer,):
                peer.send([(1, b"in")])
                assert collect(bus, 1) == [(1, b"in")]
                bus.send([(2, b"out")])
                assert collect(peer, 1) == [(2, b"out")]
        finally:
            ip("del", "vcan9")
        until(bus, lambda: bus.missing != "")
    bus.close()


def until(bus: AwaitedBus, holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 30.0
    while not holds():
        assert time.monotonic() < end, bus.missing
        bus.drain(9, 0.05)
