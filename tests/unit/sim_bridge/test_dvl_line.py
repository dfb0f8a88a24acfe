"""The serial line: what was sent can be read, whole, by the real driver, and nobody ever waits for a reader."""

from __future__ import annotations

import os
import time
from types import SimpleNamespace

import pytest
import serial

from sim_bridge.devices import serial_line
from sim_bridge.devices.serial_line import CAPACITY, SerialLine

LINE = b"wrz,0.120,-0.400,0.010,y,1.30,0.002,1e-06;0;0;0;1e-06;0;0;0;1e-06,1,2,3.0,0*00\r\n"


@pytest.fixture
def line():
    with SerialLine() as line:
        yield line


@pytest.fixture
def port(line):
    with serial.Serial(line.path, 115200, timeout=0) as port:
        yield port


def test_every_line_can_be_read_the_moment_send_returns(line, port):
    for i in range(500):
        sent = b"%d," % i + LINE
        line.send(sent)
        assert port.in_waiting == len(sent)
        assert port.read(4096) == sent
    assert (line.lost, line.late) == (0, 0)


def test_lines_that_wait_together_stay_in_order(line, port):
    sent = [b"%d," % i + LINE for i in range(20)]
    for each in sent:
        line.send(each)
    assert port.read(4096) == b"".join(sent)


@pytest.mark.parametrize("byte", range(256))
def test_the_line_changes_no_byte(line, port, byte):
    line.send(bytes([byte, 0x0D, byte, 0x0A]))
    assert port.read(16) == bytes([byte, 0x0D, byte, 0x0A])


def test_without_a_reader_whole_lines_are_lost_and_counted_and_nobody_waits(line):
    fit = CAPACITY // len(LINE)
    for _ in range(fit + 100):
        line.send(LINE)
    assert line.lost == 100
    assert line.late == 0
    assert line.waiting() == fit * len(LINE)
    with serial.Serial(line.path, 115200, timeout=0) as port:  # opening discards what lay there
        assert port.in_waiting == 0
        line.send(LINE)
        assert port.read(4096) == LINE


def test_a_reader_that_leaves_and_comes_back_breaks_nothing(line):
    for _ in range(3):
        with serial.Serial(line.path, 115200, timeout=0) as port:
            line.send(LINE)
            assert port.read(4096) == LINE
        line.send(LINE)
    assert line.lost == 0


def test_what_the_vehicle_writes_reaches_the_device(line, port):
    assert line.receive() == b""
    port.write(b"wcp,6\r\n")
    port.flush()
    heard, end = b"", time.monotonic() + 5.0
    while not heard.endswith(b"\n") and time.monotonic() < end:
        heard += line.receive()
    assert heard == b"wcp,6\r\n"


def test_what_never_arrives_is_given_up_and_counted(monkeypatch):
    clock = iter([10.0, 10.4, 10.8, 11.2])
    with SerialLine(timeout=1.0) as impatient:
        monkeypatch.setattr(impatient, "waiting", lambda: 0)
        monkeypatch.setattr(serial_line, "time", SimpleNamespace(monotonic=lambda: next(clock)))
        impatient.send(LINE)
        assert (impatient.lost, impatient.late) == (0, 1)
    assert next(clock, None) is None


def test_close_may_be_called_twice_and_frees_the_line():
    line = SerialLine()
    line.close()
    line.close()
    assert not os.path.exists(line.path)


def test_a_reader_that_takes_the_line_at_once_does_not_stall_a_plant_that_keeps_its_own_time(monkeypatch):
    with SerialLine(timeout=0.0) as line:
        monkeypatch.setattr(line, "waiting", lambda: 0)  # read before it was seen
        monkeypatch.setattr(serial_line, "time", SimpleNamespace(monotonic=lambda: pytest.fail("it waits")))
        line.send(LINE)
        assert (line.lost, line.late) == (0, 0)
