"""Dynamixel packets: the maker's examples, and its own library as a writer of packets and as a host of our servos."""

from __future__ import annotations

import importlib.resources
import math
import os
import random
import re
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from dynamixel_sdk import (
    COMM_SUCCESS,
    GroupSyncRead,
    GroupSyncWrite,
    PortHandler,
    Protocol2PacketHandler,
)
from hypothesis import assume, given
from hypothesis import strategies as st

from firmware_py.wire.serial import dynamixel, dynamixel_x
from firmware_py.wire.serial.dynamixel import Instruction, Status
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

from .dynamixel_servos import MODEL, Servos

# Examples of the maker's page on the protocol.
PING = bytes.fromhex("fffffd00 01 0300 01 194e")
PONG = bytes.fromhex("fffffd00 01 0700 55 00 060426 655d")
READ = bytes.fromhex("fffffd00 01 0700 02 84000400 1d15")
ANSWER = bytes.fromhex("fffffd00 01 0800 55 00 a6000000 8cc0")
WRITE = bytes.fromhex("fffffd00 01 0900 03 7400 00020000 ca89")
SYNC_READ = bytes.fromhex("fffffd00 fe 0900 82 84000400 0102 cefa")
SYNC_WRITE = bytes.fromhex("fffffd00 fe 1100 83 74000400 01 96000000 02 aa000000 8287")
FAST = bytes.fromhex("fffffd00 fe 1900 55 00 03 a6000000 8408 00 07 1f080000 16ca 00 04 ff030000 d19e")
PATTERN = b"\xff\xff\xfd"
servos = st.integers(0, 252)


class Line:
    """A port of the judge's whose other end are simulated servos."""

    def __init__(self, servos: Any) -> None:
        self.servos, self.sent, self._waiting = servos, b"", b""
        self.is_using = False

    def clearPort(self) -> None:
        self._waiting = b""

    def writePort(self, packet: list[int]) -> int:
        self.sent = bytes(packet)
        self._waiting += self.servos.feed(self.sent)
        return len(packet)

    def readPort(self, length: int) -> bytes:
        taken, self._waiting = self._waiting[:length], self._waiting[length:]
        return taken

    def setPacketTimeout(self, length: int) -> None: ...

    def setPacketTimeoutMillis(self, time: float) -> None: ...

    def isPacketTimeout(self) -> bool:
        return not self._waiting


def test_crc_has_the_catalogued_check_value() -> None:
    assert dynamixel.crc16(b"123456789") == 0xFEE8


def test_the_examples_of_the_maker_are_written() -> None:
    assert dynamixel.ping(1) == PING
    assert dynamixel.status(Status(1, 0, bytes.fromhex("060426"))) == PONG
    assert dynamixel_x.read(1, dynamixel_x.PRESENT_POSITION) == READ
    assert dynamixel_x.write(1, dynamixel_x.GOAL_POSITION, 512) == WRITE
    assert dynamixel_x.read_positions((1, 2)) == SYNC_READ
    goals = [(1, dynamixel_x.angle(150)), (2, dynamixel_x.angle(170))]
    assert dynamixel_x.write_positions(goals) == SYNC_WRITE


def test_the_examples_of_the_maker_are_read() -> None:
    assert dynamixel.decode(PONG) == Status(1, 0, b"\x06\x04\x26")
    assert Servos((1,)).feed(PING) == PONG
    assert dynamixel.decode_instruction(PING) == Instruction(1, dynamixel.PING, b"")
    assert dynamixel.decode(PING) is dynamixel.decode_instruction(PONG) is None
    answer = dynamixel.decode(ANSWER)
    assert answer is not None
    assert dynamixel_x.number(answer, dynamixel_x.PRESENT_POSITION) == 166
    assert dynamixel_x.positions(answer) == ((1, dynamixel_x.angle(166), True),)


def test_the_makers_fast_answer_is_read_and_its_inner_crcs_are_ours() -> None:
    answer = dynamixel.decode(FAST)
    assert answer is not None
    one_by_one = dynamixel.split(answer, 4)
    assert [(one.id, int.from_bytes(one.parameters, "little")) for one in one_by_one] == [
        (3, 166),
        (7, 2079),
        (4, 1023),
    ]
    assert dynamixel.fast_status(one_by_one) == FAST
    assert [one.servo for one in dynamixel_x.positions(answer)] == [3, 7, 4]


@given(servos, st.integers(0, 255), st.binary(max_size=60))
def test_what_is_written_is_read(servo: int, error: int, content: bytes) -> None:
    answer = Status(servo, error, content)
    assert dynamixel.decode(dynamixel.status(answer)) == answer
    assert [*dynamixel.statuses().feed(dynamixel.status(answer))] == [answer]


stuffed = st.lists(st.sampled_from([b"\xff\xff\xfd", b"\xfd", b"\xff", b"\x00\x01"]), max_size=12).map(b"".join)


@given(servos, stuffed)
def test_what_looks_like_a_beginning_is_stuffed(servo: int, content: bytes) -> None:
    answer, asked = Status(servo, 0, content), Instruction(servo, 3, b"\x40\x00" + content)
    assert dynamixel.decode(dynamixel.status(answer)) == answer
    packet = dynamixel.instruction(servo, 3, asked.parameters)
    assert dynamixel.decode_instruction(packet) == asked
    assert not re.search(rb"\xff\xff\xfd(?!\xfd)", packet[4:-2])


@given(servos, stuffed)
def test_the_judge_stuffs_as_we_do(servo: int, content: bytes) -> None:
    """Its functions are asked by themselves: what this version of it sends is not stuffed, their result is dropped."""
    parameters = b"\x40\x00" + content
    ours = dynamixel.write(servo, 64, content)
    plain = [0xFF, 0xFF, 0xFD, 0, servo, len(parameters) + 3, 0, dynamixel.WRITE, *parameters, *ours[-2:]]
    theirs = bytes(Protocol2PacketHandler().addStuffing([*plain]))
    assert theirs == ours
    if ours.count(b"\xff\xff\xfd") == 2:  # behind the first one, it removes what has not been stuffed
        back = Protocol2PacketHandler().removeStuffing([*ours])
        assert back[: len(plain)] == plain


@given(servos, st.integers(0, 600), st.integers(0, 2**32 - 1), st.sampled_from([0, 0x80, 0x87, 4]))
def test_the_judge_as_a_host_understands_our_servos(servo: int, address: int, value: int, error: int) -> None:
    assume(PATTERN not in value.to_bytes(4, "little"))
    line, handler = Line(Servos((servo,))), Protocol2PacketHandler()
    line.servos.errors[servo] = error
    assert handler.ping(line, servo) == (MODEL, COMM_SUCCESS, error)
    assert handler.write4ByteTxRx(line, servo, address, value) == (COMM_SUCCESS, error)
    assert line.sent == dynamixel.write(servo, address, value.to_bytes(4, "little"))
    assert handler.read4ByteTxRx(line, servo, address) == (value, COMM_SUCCESS, error)
    assert line.sent == dynamixel.read(servo, address, 4)


positions = st.dictionaries(servos, st.integers(-(2**31), 2**31 - 1), min_size=1, max_size=12)


@given(positions)
def test_sync_writes_and_reads_are_the_judges(goals: dict[int, int]) -> None:
    data = [(servo, position.to_bytes(4, "little", signed=True)) for servo, position in goals.items()]
    assume(PATTERN not in b"".join(bytes((servo,)) + content for servo, content in data))
    line, handler = Line(Servos(tuple(goals))), Protocol2PacketHandler()
    goal, present = dynamixel_x.GOAL_POSITION, dynamixel_x.PRESENT_POSITION
    group = GroupSyncWrite(line, handler, *goal)
    for servo, content in data:
        group.addParam(servo, [*content])
    assert group.txPacket() == COMM_SUCCESS
    ours = dynamixel.sync_write(*goal, data)
    assert line.sent == ours
    for servo, content in data:
        assert line.servos.tables[servo][116:120] == content
        line.servos.tables[servo][132:136] = content
    for fast in (False, True):
        reader = GroupSyncRead(line, handler, *present)
        for servo in goals:
            reader.addParam(servo)
        assert (reader.fastSyncRead if fast else reader.txRxPacket)() == COMM_SUCCESS
        assert line.sent == dynamixel_x.read_positions([*goals], fast)
        for servo, position in goals.items():
            assert reader.getData(servo, *present) == position % 2**32


def test_positions_come_back_to_half_a_count() -> None:
    source = random.Random(5)
    host, table = dynamixel.statuses(), Servos((1, 2, 3, 4))
    for fast in (False, True):
        goals = [(servo, source.uniform(-math.pi, math.pi)) for servo in (1, 2, 3, 4)]
        assert table.feed(dynamixel_x.write_positions(goals)) == b""
        for servo in table.tables.values():
            servo[132:136] = servo[116:120]
        answers = host.feed(table.feed(dynamixel_x.read_positions((1, 2, 3, 4), fast)))
        found = [position for answer in answers for position in dynamixel_x.positions(answer)]
        assert [position.servo for position in found] == [1, 2, 3, 4]
        for position, (_, goal) in zip(found, goals, strict=True):
            assert position.angle == pytest.approx(goal, abs=math.pi / 4096 * 1.001)
            assert position.usable


def test_a_servo_with_a_fault_is_not_used() -> None:
    table = Servos((1, 2))
    table.errors = {2: 0x80}
    for fast in (False, True):
        answers = dynamixel.statuses().feed(table.feed(dynamixel_x.read_positions((1, 2), fast)))
        found = [position for answer in answers for position in dynamixel_x.positions(answer)]
        assert [position.usable for position in found] == [True, False]
    assert Status(1, 0x80).alert
    assert not Status(1, 0x80).refused
    assert Status(1, 0x87).refused == "the address cannot be read or written now"
    assert Status(1, 0x20).refused == "error 32"
    assert dynamixel_x.HardwareError(0b100101) == (
        dynamixel_x.HardwareError.OVERLOAD
        | dynamixel_x.HardwareError.OVERHEATING
        | dynamixel_x.HardwareError.INPUT_VOLTAGE
    )


def test_the_addresses_are_those_of_the_makers_tables() -> None:
    tables = importlib.resources.files("dynamixel_easy_sdk").joinpath("control_table")
    models = [row.split("\t") for row in tables.joinpath("dynamixel.model").read_text().splitlines()[1:] if row]
    xw430_t200 = 1280  # the kit's list leaves it out; ROBOTIS tools and its e-manual have it
    assert {xw430_t200, *(int(number) for number, _ in models)} >= dynamixel_x.MODELS
    items = {key: value for key, value in vars(dynamixel_x).items() if isinstance(value, dynamixel_x.Item)}
    for number, name in models:
        if int(number) not in dynamixel_x.MODELS:
            continue
        text = tables.joinpath(name.strip()).read_text()
        rows = [row.split("\t") for row in text.partition("[control table]")[2].splitlines()[2:] if row]
        table = {what.upper().replace(" ", "_"): (int(address), int(length)) for address, length, what in rows}
        table |= {"PRESENT_CURRENT": table["PRESENT_LOAD"]} if "PRESENT_LOAD" in table else {}
        assert {key: (*value,) for key, value in items.items()}.items() <= table.items(), name
        assert "value_of_zero_radian_position\t2048" in text
        assert float(re.search(r"Present Velocity\t(\S+)\trad/s", text)[1]) == pytest.approx(
            dynamixel_x.VELOCITY_STEP, rel=1e-3
        ), name
    assert not dynamixel_x.MODELS & {350, 2000, 51201}  # XL-320, PRO: other tables


@pytest.fixture
def terminal() -> Iterator[tuple[str, Servos]]:
    """Return the name of a pseudo-terminal at whose other end servos listen, and these."""
    ours, theirs = os.openpty()
    table = Servos((1, 2))

    def listen() -> None:
        while True:
            try:
                os.write(ours, table.feed(os.read(ours, 4096)))
            except OSError:
                return

    thread = threading.Thread(target=listen)
    thread.start()
    yield os.ttyname(theirs), table
    os.close(theirs)
    thread.join(5.0)
    os.close(ours)


def test_the_judge_over_a_pseudo_terminal(terminal: tuple[str, Servos]) -> None:
    name, table = terminal
    port, handler = PortHandler(name), Protocol2PacketHandler()
    assert port.openPort()
    try:
        assert handler.ping(port, 2) == (MODEL, COMM_SUCCESS, 0)
        table.tables[1][132:136] = b"\xff\xff\xfd\xff"  # a position that is stuffed
        assert handler.read4ByteTxRx(port, 1, 132) == (0xFFFDFFFF, COMM_SUCCESS, 0)
        assert handler.write1ByteTxRx(port, 1, *dynamixel_x.TORQUE_ENABLE) == (COMM_SUCCESS, 0)
        reader = GroupSyncRead(port, handler, *dynamixel_x.PRESENT_POSITION)
        assert reader.addParam(1)
        assert reader.addParam(2)
        assert reader.fastSyncRead() == COMM_SUCCESS
        assert reader.getData(1, 132, 4) == 0xFFFDFFFF
    finally:
        port.closePort()
    assert table.tables[1][64] == 1


def closed(body: str) -> bytes:
    """Return a packet with the right CRC."""
    content = bytes.fromhex(body)
    return content + dynamixel.crc16(content).to_bytes(2, "little")


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (closed("fffffd00 01 0300 55"), "without an error byte"),
        (closed("fffffd00 01 0400 55"), "as long as it says, not 10"),
        (closed("fffffd00 fd 0400 55 00"), "not a packet"),
        (closed("fffffdfd 01 0400 55 00"), "not a packet"),
        (PONG + b"\0", "as long as it says, not 15"),
        (b"", "not 0 bytes"),
    ],
)
def test_a_malformed_packet_says_why(content: bytes, why: str) -> None:
    with pytest.raises(SentenceError, match=why):
        dynamixel.decode(content)


def test_a_bad_checksum_says_what_would_be_right() -> None:
    with pytest.raises(ChecksumError, match="must be 5d65"):
        dynamixel.decode(PONG[:-1] + b"\0")


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        (Status(1, 0, b"\1\2"), "2 bytes from servo 1: must be 4$"),
        (Status(1, 4, b""), "must be 4; a number is out of its range"),
        (Status(0xFE, 0, b"\3" + bytes(5)), "must be a multiple of 8"),
    ],
)
def test_an_answer_that_is_no_position_says_why(answer: Status, why: str) -> None:
    with pytest.raises(SentenceError, match=why):
        dynamixel_x.positions(answer)


def test_settings_have_the_units_of_the_table() -> None:
    assert dynamixel_x.enable_torque(3, True) == dynamixel.write(3, 64, b"\1")
    assert dynamixel_x.enable_torque(3, False) == dynamixel.write(3, 64, b"\0")
    assert dynamixel_x.set_return_delay(3, 20e-6) == dynamixel.write(3, 9, b"\x0a")
    assert dynamixel_x.set_bus_watchdog(3, 0.5) == dynamixel.write(3, 98, b"\x19")
    assert dynamixel.decode_instruction(dynamixel.reboot(3)) == Instruction(3, 8, b"")
    assert dynamixel_x.counts(0.0) == 2048
    assert dynamixel_x.counts(-math.pi) == 0


@pytest.mark.parametrize(
    ("order", "arguments"),
    [
        (dynamixel_x.set_bus_watchdog, (1, 3.0)),
        (dynamixel_x.set_return_delay, (1, -1e-3)),
        (dynamixel_x.write_positions, ([(1, math.nan)],)),
        (dynamixel_x.write_positions, ([(1, 1e9)],)),
        (dynamixel_x.write_positions, ([(k, 0.0) for k in range(40)],)),
        (dynamixel.ping, (253,)),
        (dynamixel.ping, (255,)),
        (dynamixel.sync_write, (116, 4, [(1, b"123")])),
        (dynamixel.fast_status, ([],)),
        (dynamixel.fast_status, ([Status(1, 0, bytes(4))] * 20,)),
    ],
)
def test_what_cannot_be_is_refused(order: Any, arguments: tuple[Any, ...]) -> None:
    with pytest.raises(ValueError, match=r"must|NaN"):
        order(*arguments)
