"""The `canopen` library on a virtual bus: its node as our drive, its master against our simulated drive."""

from __future__ import annotations

import collections
import random
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import can
import canopen
import pytest
from canopen.objectdictionary import (
    INTEGER8,
    INTEGER16,
    INTEGER32,
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED32,
    ObjectDictionary,
    ODArray,
    ODRecord,
    ODVariable,
)
from canopen.profiles.p402 import BaseNode402, State402

from firmware_py.wire.canopen import cia402, configuration, frames, sdo
from firmware_py.wire.canopen.cia402 import Mode, State, Wanted
from firmware_py.wire.canopen.configuration import Configuration
from firmware_py.wire.canopen.frames import NmtCommand, NmtState

from .canopen_drive import Drive

NODE = 5
WAIT = 5.0
SEED = 1000


def dictionary() -> ObjectDictionary:
    """Return the objects of a drive, as its maker's file would list them."""
    found = ObjectDictionary()

    def variable(name: str, index: int, kind: int, sub: int = 0, value: int | None = 0) -> ODVariable:
        one = ODVariable(name, index, sub)
        one.data_type, one.access_type, one.default = kind, "rw", value
        return one

    for name, index, kind, value in (
        ("device type", 0x1000, UNSIGNED32, 402 | 2 << 16),
        ("producer heartbeat time", 0x1017, UNSIGNED16, 0),
        ("reaction to a lost master", 0x6007, INTEGER16, 0),
        ("controlword", 0x6040, UNSIGNED16, 0),
        ("statusword", 0x6041, UNSIGNED16, 0),
        ("mode", 0x6060, INTEGER8, 0),
        ("mode display", 0x6061, INTEGER8, 0),
        ("position", 0x6064, INTEGER32, 0),
        ("target position", 0x607A, INTEGER32, 0),
        ("supported modes", 0x6502, UNSIGNED32, 1 | 1 << 7),
    ):
        found.add_object(variable(name, index, kind, value=value))
    watched = ODArray("consumer heartbeat time", 0x1016)
    watched.add_member(variable("entries", 0x1016, UNSIGNED8, 0, 1))
    watched.add_member(variable("master", 0x1016, UNSIGNED32, 1))
    found.add_object(watched)
    interpolation = ODRecord("interpolation time", 0x60C2)
    interpolation.add_member(variable("value", 0x60C2, UNSIGNED8, 1))
    interpolation.add_member(variable("exponent", 0x60C2, INTEGER8, 2))
    found.add_object(interpolation)
    for parameters, identifier in ((0x1400, 0x200), (0x1800, 0x180)):
        record = ODRecord(f"parameters {parameters:04X}", parameters)
        record.add_member(variable("entries", parameters, UNSIGNED8, 0, 5))
        record.add_member(variable("COB-ID", parameters, UNSIGNED32, 1, 1 << 31 | identifier + NODE))
        record.add_member(variable("type", parameters, UNSIGNED8, 2, 255))
        record.add_member(variable("inhibit time", parameters, UNSIGNED16, 3))
        record.add_member(variable("event timer", parameters, UNSIGNED16, 5))
        found.add_object(record)
        mapping = ODRecord(f"mapping {parameters:04X}", parameters + 0x200)
        mapping.add_member(variable("entries", parameters + 0x200, UNSIGNED8, 0, 0))
        for k in range(1, 9):
            mapping.add_member(variable(f"object {k}", parameters + 0x200, UNSIGNED32, k))
        found.add_object(mapping)
    return found


class Wire:
    """Our end of the bus: what comes is decoded."""

    def __init__(self, channel: str) -> None:
        self.bus = can.Bus(channel, interface="virtual")

    def send(self, frame: frames.Frame) -> None:
        identifier, data = frame
        self.bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))

    def receive(self, timeout: float = WAIT) -> frames.Message | None:
        heard = self.bus.recv(timeout)
        return None if heard is None else frames.decode(heard.arbitration_id, bytes(heard.data))

    def expect(self, kind: type) -> Any:
        """Return the next message of a kind."""
        end = time.monotonic() + WAIT
        while time.monotonic() < end:
            message = self.receive(0.1)
            if isinstance(message, kind):
                return message
        raise AssertionError(f"no {kind.__name__} within {WAIT:g} s")

    def configure(self, steps: list[configuration.Step]) -> Configuration:
        """Start a node up."""
        started, end = Configuration(NODE, steps), time.monotonic() + WAIT
        while not started.done and not started.failure and time.monotonic() < end:
            frame = started.poll(time.monotonic())
            if frame is not None:
                self.send(frame)
            message = self.receive(0.01)
            if isinstance(message, frames.SdoAnswer):
                started.accept(message)
        return started


def until(true: Callable[[], bool]) -> None:
    """Wait for another thread."""
    end = time.monotonic() + WAIT
    while not true():
        assert time.monotonic() < end
        time.sleep(0.002)


@pytest.fixture
def network(request: pytest.FixtureRequest) -> Iterator[canopen.Network]:
    found = canopen.Network(can.Bus(request.node.name, interface="virtual"))
    found.NOTIFIER_CYCLE = 0.02  # so long it takes to end
    found.connect()
    yield found
    found.disconnect()


@pytest.fixture
def wire(request: pytest.FixtureRequest) -> Iterator[Wire]:
    found = Wire(request.node.name)
    yield found
    found.bus.shutdown()


@pytest.mark.parametrize("mode", Mode)
def test_the_judge_as_a_drive(network: canopen.Network, wire: Wire, mode: Mode) -> None:
    drive = canopen.LocalNode(NODE, dictionary())
    network.add_node(drive)
    drive.nmt.send_command(0)
    assert wire.expect(frames.Heartbeat) == frames.Heartbeat(NODE, NmtState.BOOT_UP)
    started = wire.configure(configuration.drive(NODE, mode, 0.02, 0.05, master=9, patience=0.5))
    assert started.done, started.failure
    until(lambda: drive.nmt.state == "OPERATIONAL")

    assert drive.sdo[0x6060].raw == mode
    assert drive.sdo[0x1016][1].raw == 9 << 16 | 500
    assert drive.sdo[0x6007].raw == 3
    assert wire.expect(frames.Heartbeat) == frames.Heartbeat(NODE, NmtState.OPERATIONAL)  # with the period we have set

    drive.rpdo.read()
    drive.tpdo.read()
    received, sent = drive.rpdo[1], drive.tpdo[1]
    assert (received.cob_id, sent.cob_id) == (0x200 + NODE, 0x180 + NODE)
    assert received.enabled
    assert sent.enabled
    assert not sent.rtr_allowed
    assert received.trans_type == sent.trans_type == (1 if mode is Mode.CYCLIC_SYNCHRONOUS_POSITION else 255)
    assert [one.index for one in received] == [0x6040, 0x607A]
    assert [one.index for one in sent] == [0x6041, 0x6064]

    source = random.Random(SEED)
    arrived: list[tuple[int, int]] = []
    received.add_callback(lambda pdo: arrived.append((pdo[0x6040].raw, pdo[0x607A].raw)))
    commands = [(source.randrange(65536), source.randrange(-(2**31), 2**31)) for _ in range(200)]
    for word, target in commands:
        wire.send(frames.encode(cia402.command(cia402.Command(NODE, word, target))))
    until(lambda: len(arrived) == len(commands))
    assert arrived == commands

    for _ in range(200):
        word, position = source.randrange(65536), source.randrange(-(2**31), 2**31)
        sent[0x6041].raw, sent[0x6064].raw = word, position
        sent.transmit()
        feedback = cia402.decode_feedback(wire.expect(frames.Tpdo))
        assert feedback == (NODE, word, position)


def test_the_judges_emergencies_and_orders_are_read(network: canopen.Network, wire: Wire) -> None:
    drive = canopen.LocalNode(NODE, dictionary())
    network.add_node(drive)
    source = random.Random(SEED)
    for _ in range(100):
        code, register, detail = source.randrange(65536), source.randrange(256), source.randbytes(5)
        drive.emcy.send(code, register, detail)
        assert wire.expect(frames.Emergency) == (NODE, code, register, detail)
    drive.emcy.reset()
    assert wire.expect(frames.Emergency).over
    network.sync.transmit()
    assert wire.expect(frames.Sync) == frames.Sync()
    network.sync.transmit(17)
    assert wire.expect(frames.Sync) == frames.Sync(17)
    for command in NmtCommand:
        network.nmt.send_command(command)
        assert wire.expect(frames.Nmt) == frames.Nmt(command, 0)


def test_the_judge_obeys_our_orders(network: canopen.Network, wire: Wire) -> None:
    drive = canopen.LocalNode(NODE, dictionary())
    network.add_node(drive)
    states = {
        NmtCommand.START: "OPERATIONAL",
        NmtCommand.STOP: "STOPPED",
        NmtCommand.PRE_OPERATIONAL: "PRE-OPERATIONAL",
        NmtCommand.RESET_NODE: "INITIALISING",
    }
    for command, state in states.items():
        for node in (0, NODE):
            wire.send(frames.encode(frames.Nmt(command, node)))
            until(lambda expected=state: drive.nmt.state == expected)
    wire.send(frames.encode(frames.Nmt(NmtCommand.START, NODE + 1)))
    time.sleep(0.02)
    assert drive.nmt.state == "INITIALISING"


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        (sdo.Read(0x1000, 0), sdo.ReadDone(0x1000, 0, b"\x92\x01\x02\x00")),
        (sdo.Read(0x6060, 0), sdo.ReadDone(0x6060, 0, b"\x00")),
        (sdo.Read(0x1800, 2), sdo.ReadDone(0x1800, 2, b"\xff")),
        (sdo.Read(0x5555, 0), sdo.Abort(0x5555, 0, sdo.NO_OBJECT)),
        (sdo.Read(0x1800, 9), sdo.Abort(0x1800, 9, sdo.NO_SUBINDEX)),
        (sdo.Write(0x6060, 0, b"\x08"), sdo.WriteDone(0x6060, 0)),
        (sdo.Write(0x607A, 0, b"\x01\x02\x03\x04"), sdo.WriteDone(0x607A, 0)),
        (sdo.Write(0x6060, 0, b"\x08\x00"), sdo.Abort(0x6060, 0, sdo.WRONG_LENGTH)),
    ],
)
def test_the_judge_answers_our_requests(
    network: canopen.Network, wire: Wire, asked: sdo.Request, answer: sdo.Answer
) -> None:
    drive = canopen.LocalNode(NODE, dictionary())
    network.add_node(drive)
    wire.send(frames.encode(sdo.request(NODE, asked)))
    assert sdo.decode_answer(wire.expect(frames.SdoAnswer)) == answer
    if isinstance(answer, sdo.WriteDone) and isinstance(asked, sdo.Write):
        assert drive.get_data(asked.object, asked.subindex) == asked.data


class Served:
    """Our simulated drive on the bus, in a thread of its own."""

    def __init__(self, wire: Wire) -> None:
        self.drive, self._wire, self._end = Drive(NODE), wire, threading.Event()
        self.pending = collections.deque([self.drive.boot()])
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        due = 0.0
        while not self._end.is_set():
            heard = self._wire.bus.recv(0.005)
            answers = self.drive.handle(heard.arbitration_id, bytes(heard.data)) if heard else []
            if time.monotonic() >= due:  # however much is asked
                answers, due = answers + self.drive.feedback(), time.monotonic() + 0.01
            while self.pending:
                self._wire.send(self.pending.popleft())
            for frame in answers:
                self._wire.send(frame)

    def close(self) -> None:
        self._end.set()
        self._thread.join(WAIT)


@pytest.fixture
def served(wire: Wire) -> Iterator[Served]:
    found = Served(wire)
    yield found
    found.close()


def test_the_judge_as_a_master(network: canopen.Network, served: Served) -> None:
    master = BaseNode402(NODE, dictionary())
    # Its patience is that of a bench: a busy machine may need more.
    master.TIMEOUT_SWITCH_STATE_FINAL = master.TIMEOUT_SWITCH_STATE_SINGLE = master.TIMEOUT_CHECK_TPDO = WAIT
    master.TIMEOUT_SWITCH_OP_MODE = WAIT
    network.add_node(master)
    master.nmt.state = "PRE-OPERATIONAL"
    for pdo, objects in ((master.rpdo[1], (0x6040, 0x607A)), (master.tpdo[1], (0x6041, 0x6064))):
        pdo.cob_id = pdo.predefined_cob_id
        pdo.trans_type, pdo.enabled = 255, True
        pdo.clear()
        for one in objects:
            pdo.add_variable(one)
        pdo.save()
    master.setup_402_state_machine()
    assert [one.index for one in master.tpdo[1]] == [0x6041, 0x6064]
    master.op_mode = "CYCLIC SYNCHRONOUS POSITION"
    assert master.op_mode == "CYCLIC SYNCHRONOUS POSITION"
    master.nmt.state = "OPERATIONAL"
    until(lambda: served.drive.nmt is NmtState.OPERATIONAL)
    until(lambda: master.state == "SWITCH ON DISABLED")

    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "QUICK STOP ACTIVE", "SWITCH ON DISABLED"):
        master.state = state
        until(lambda expected=state: served.drive.state.value.upper() == expected)
        assert master.state == state
    master.state = "OPERATION ENABLED"
    for target in (1234, -(2**31), 2**31 - 1):
        master.rpdo[1][0x607A].raw = target
        master.rpdo[1].transmit()
        until(lambda expected=target: master.tpdo_values[0x6064] == expected)
    assert master.sdo[0x6064].raw == 2**31 - 1

    served.pending.append(served.drive.fail(0x4310))
    until(lambda: bool(master.emcy.active))
    assert (master.emcy.active[0].code, master.emcy.active[0].register) == (0x4310, 1)
    until(lambda: master.state == "FAULT")
    master.state = "OPERATION ENABLED"
    assert served.drive.state is State.ENABLED


def test_the_judge_hears_our_heartbeats(network: canopen.Network, wire: Wire) -> None:
    master = canopen.RemoteNode(NODE, dictionary())
    network.add_node(master)
    for state, name in (
        (NmtState.OPERATIONAL, "OPERATIONAL"),
        (NmtState.STOPPED, "STOPPED"),
        (NmtState.PRE_OPERATIONAL, "PRE-OPERATIONAL"),
    ):
        wire.send(frames.encode(frames.Heartbeat(NODE, state)))
        until(lambda expected=name: master.nmt.state == expected)


def test_the_judge_aborts_as_we_do(network: canopen.Network, served: Served) -> None:
    master = canopen.RemoteNode(NODE, dictionary())
    network.add_node(master)
    with pytest.raises(canopen.SdoAbortedError) as refused:
        master.sdo.download(0x6041, 0, b"\1\0")
    assert refused.value.code == sdo.READ_ONLY
    with pytest.raises(canopen.SdoAbortedError) as refused:
        master.sdo.upload(0x5000, 0)
    assert refused.value.code == sdo.NO_OBJECT
    assert {*sdo.ABORT_CODES} < {*canopen.SdoAbortedError.CODES}


def test_our_master_and_the_judges_words_agree() -> None:
    """Every transition that we order has the code that the judge orders it with."""
    names, compared = {state: state.value.upper() for state in State}, 0
    for (begin, end), word in State402.TRANSITIONTABLE.items():
        wanted = {
            "READY TO SWITCH ON": None,
            "SWITCHED ON": Wanted.STANDBY,
            "OPERATION ENABLED": Wanted.ENABLED,
            "QUICK STOP ACTIVE": Wanted.QUICK_STOP,
            "SWITCH ON DISABLED": Wanted.OFF,
        }.get(end)
        state = next((state for state, name in names.items() if name == begin), None)
        if wanted is None or state is None or (begin, end) == ("QUICK STOP ACTIVE", "OPERATION ENABLED"):
            continue
        ours = cia402.controlword(state, wanted, reset=True)
        assert ours == word, (begin, end)
        compared += 1
    assert compared == 10
    for name, (mask, bits) in State402.SW_MASK.items():
        for rest in range(0x10000):
            if rest & mask == bits:
                found = cia402.state(rest)
                assert found is not None
                assert names[found] == name
