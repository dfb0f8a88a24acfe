"""python-can's interfaces by name: slcan against an adapter on a real pseudo-terminal, and adapters that fail."""

from __future__ import annotations

import contextlib
import os
import tty
from collections.abc import Iterator
from types import SimpleNamespace

import can
import pytest

from firmware_py.adapters.buses import awaited_bus, python_can_bus
from firmware_py.adapters.buses.can_bus import BusError, CanBus, open_bus
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.buses.python_can_bus import PythonCanBus

from .bus_contract import NOTHING_LOST, collect

FRAMES = [(0x1ABCDEF, b"\x01\x02\xff"), (0x185 | STANDARD, bytes(range(8))), (0x7FF | STANDARD, b"")]
LINES = b"T01ABCDEF30102FF\rt18580001020304050607\rt7FF0\r"


class Adapter:
    """The far end of the line, by hand. Both ends are kept, so that the number is not another's before the end."""

    def __init__(self) -> None:
        self.end, self.line = os.openpty()
        tty.setraw(self.line)
        os.set_blocking(self.end, False)
        self.path = os.ttyname(self.line)

    def heard(self) -> bytes:
        found = b""
        with contextlib.suppress(BlockingIOError):
            while True:
                found += os.read(self.end, 65536)
        return found

    def close(self) -> None:
        os.close(self.end)
        os.close(self.line)


@pytest.fixture
def adapter() -> Iterator[Adapter]:
    found = Adapter()
    yield found
    found.close()


@pytest.fixture
def bus(adapter: Adapter) -> Iterator[CanBus]:
    with contextlib.closing(open_bus(f"python-can:slcan:{adapter.path}@500000", standard=True)) as found:
        assert adapter.heard().split(b"\r") == [b"C", b"S6", b"", b"O", b"O", b""]
        yield found


def test_slcan_says_and_hears_frames_of_both_kinds_as_the_protocol_has_them(adapter, bus):
    bus.send(FRAMES)
    assert adapter.heard() == LINES
    os.write(adapter.end, LINES)
    assert collect(bus, 3) == FRAMES
    assert bus.losses() == NOTHING_LOST
    bus.close()
    assert adapter.heard() == b"C\r"


def test_slcan_hears_frames_between_answers_with_timestamps_and_at_every_cut(adapter, bus):
    said = b"\rz\rZ\rT01ABCDEF30102FF1234\rV1013\r\nt1858000102030405060700FA\rF00\rr1230\rt7FF0\r"
    for cut in range(1, len(said), 3):
        heard = []
        for part in (said[:cut], said[cut:]):
            os.write(adapter.end, part)
            heard += bus.drain(10, 0.01)
        while len(heard) < 3:
            heard += bus.drain(10, 0.5)
        assert heard == FRAMES
    assert bus.losses() == NOTHING_LOST


MALFORMED = [
    b"hello",
    b"t",
    b"t12",
    b"t1239",
    b"t1232AA",
    b"t1232AAB",
    b"t1231ZZ",
    b"t8000",
    b"T200000000",
    b"T1234567",
    b"t1232AABBCC",
    b"\xff\xfe\x00",
    b"t" * 200,
]


@pytest.mark.parametrize("line", MALFORMED)
def test_a_line_that_is_none_is_counted_and_the_next_frame_is_heard(adapter, bus, line):
    os.write(adapter.end, line + b"\rt12310A\r")
    assert collect(bus, 1) == [(0x123 | STANDARD, b"\x0a")]
    assert bus.losses() == NOTHING_LOST | {"malformed": 1}


def test_noise_without_an_end_of_line_is_bounded_and_counted(adapter, bus):
    for _ in range(100):
        os.write(adapter.end, b"x" * 100)
        assert bus.drain(10) == []
    os.write(adapter.end, b"\rt12310A\r")
    assert collect(bus, 1) == [(0x123 | STANDARD, b"\x0a")]
    assert 1 <= bus.losses()["malformed"] <= 101


def test_what_the_adapter_refuses_is_counted(adapter, bus):
    os.write(adapter.end, b"\a\a\rt12310A\r")
    assert collect(bus, 1) == [(0x123 | STANDARD, b"\x0a")]
    assert bus.losses()["refused"] == 2


def test_an_adapter_that_takes_nothing_delays_nothing_and_no_frame_is_cut(adapter, bus):
    count = 4000
    for k in range(count):
        bus.send([(k, b"12345678")])
    not_sent = bus.losses()["not_sent"]
    assert 0 < not_sent < count
    said = b""
    while part := adapter.heard():
        said += part
        bus.drain(1)
    lines = said.split(b"\r")
    assert lines.pop() == b""
    assert len(lines) == count - not_sent
    sent = [int(line[1:9], 16) for line in lines]
    assert sent == sorted({*sent})
    assert all(line == b"T%08X83132333435363738" % k for k, line in zip(sent, lines, strict=True))


def test_an_adapter_that_is_unplugged_is_silence_and_told_until_one_is_there_again(adapter, monkeypatch, tmp_path):
    clock = [100.0]
    monkeypatch.setattr(python_can_bus, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    other = Adapter()
    name = str(tmp_path / "adapter")
    os.symlink(other.path, name)
    bus = PythonCanBus(f"slcan:{name}@1000000", standard=True)
    try:
        node = CanBus(bus)
        os.close(other.end)  # the other end hangs up
        assert node.drain(9) == []
        node.send([(1, b"lost")])
        assert node.drain(9) == []
        assert not node.sound
        assert {key: node.losses()[key] for key in ("not_sent", "failed_drains", "down")} == {
            "not_sent": 1,
            "failed_drains": 1,
            "down": 1,
        }
        os.unlink(name)
        clock[0] += 5.0
        node.send([(1, b"lost too")])
        assert not node.sound
        os.symlink(adapter.path, name)
        clock[0] += 5.0
        os.write(adapter.end, b"t12310A\r")
        node.send([(0x123 | STANDARD, b"\x0b")])
        assert node.sound
        assert adapter.heard().endswith(b"t12310B\r")
        assert node.losses()["not_sent"] == 2
    finally:
        bus.shutdown()
        bus.shutdown()
        os.close(other.line)


def test_an_adapter_that_is_plugged_in_later_is_waited_for(adapter, monkeypatch, tmp_path):
    clock = [100.0]
    monkeypatch.setattr(awaited_bus, "time", SimpleNamespace(monotonic=lambda: clock[0], sleep=lambda _: None))
    name = tmp_path / "adapter"
    bus = awaited_bus.AwaitedBus(f"python-can:slcan:{name}@1000000", standard=True)
    try:
        assert "cannot be opened: slcan: " in bus.missing
        assert bus.drain(9) == []
        assert not bus.sound
        name.symlink_to(adapter.path)
        clock[0] += 5.0
        assert bus.drain(9) == []
        assert bus.sound
        assert bus.missing == ""
        bus.send([(0x123 | STANDARD, b"\x0b")])
        assert adapter.heard().endswith(b"t12310B\r")
    finally:
        bus.close()


def test_an_slcan_port_that_is_not_there_is_told_in_words(tmp_path):
    with pytest.raises(can.CanInitializationError) as caught:
        PythonCanBus(f"slcan:{tmp_path}/none@500000", standard=True)
    assert str(caught.value) == f"slcan: {tmp_path}/none: there is no such device; is it plugged in?"


@pytest.mark.parametrize("place", ["nosuch:0", "slcan:/dev/x@fast", "kvaser:0@500000"])
def test_what_no_plug_will_mend_is_an_error_at_once(place):
    with pytest.raises(BusError):
        awaited_bus.AwaitedBus(f"python-can:{place}")


class Controller(can.BusABC):
    """A maker's interface with a controller of which a test says what it is."""

    def __init__(self, channel: str, **_: object) -> None:
        self.waiting: list[can.Message] = []
        self.now = can.BusState.ACTIVE
        super().__init__(channel)

    @property
    def state(self) -> can.BusState:
        return self.now

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise can.CanOperationError("the queue is full")

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        assert timeout == 0
        return (self.waiting.pop(0) if self.waiting else None), False


def test_error_frames_and_the_controllers_state_are_told(monkeypatch):
    controller = Controller("0")
    monkeypatch.setattr(python_can_bus.can, "Bus", lambda **_: controller)
    node = open_bus("python-can:pcan:PCAN_USBBUS1@500000")
    for state, sound in ((can.BusState.ACTIVE, True), (can.BusState.PASSIVE, False), (can.BusState.ERROR, False)):
        controller.now = state
        controller.waiting.append(can.Message(is_error_frame=True))
        assert node.drain(9) == []
        assert node.sound == sound
    controller.now = can.BusState.ACTIVE
    node.drain(9)
    assert node.sound
    assert node.losses() == NOTHING_LOST | {"error_frame": 3}
    controller.now = can.BusState.ERROR
    node.send([(1, b""), (2, b"")])
    assert not node.sound
    assert node.losses() == NOTHING_LOST | {"error_frame": 3, "not_sent": 2, "off": 1}
    node.close()


@pytest.mark.parametrize(
    ("place", "right"),
    [
        ("", "write python-can:INTERFACE:CHANNEL@BITRATE with one of: "),
        ("nosuch:0", "write python-can:INTERFACE:CHANNEL@BITRATE with one of: "),
        ("slcan:", "write python-can:INTERFACE:CHANNEL@BITRATE with one of: "),
        ("slcan:/dev/x@fast", "'fast' is no bitrate; write bits a second: @500000"),
        ("slcan:/dev/nosuch@500000", "slcan: "),
        ("slcan:/dev/null@123", "slcan: "),
        ("pcan:PCAN_USBBUS1@500000", "pcan: "),
        ("kvaser:0@500000", "kvaser: its maker's library is not installed"),
        ("socketcan:nosuch0", "socketcan: "),
    ],
)
def test_an_interface_that_is_not_there_is_one_line(place, right):
    with pytest.raises(BusError) as failure:
        open_bus(f"python-can:{place}")
    text = str(failure.value)
    assert text.startswith(f"bus 'python-can:{place}' cannot be opened: {right}")
    assert "\n" not in text
