"""A device over TCP: what cannot be a port, a host that does not answer, a device that reads nothing."""

from __future__ import annotations

import os
import socket

import pytest

from firmware_py.adapters import tcp_dial
from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.drivers.tcp_stream import TcpStream
from sim_bridge.devices.serial_line import SerialLine

from .wires import Tcp


@pytest.mark.parametrize("port", ["tcp:", "tcp:host", "tcp:host:", "tcp:host:0", "tcp:host:99999", "host:5", "tcp::5"])
@pytest.mark.parametrize("absent", [True, False])
def test_what_can_never_be_a_port_says_what_would_be_one(port, absent):
    with pytest.raises(BusError, match=r"^dvl: port .*: must be tcp:HOST:PORT, such as"):
        TcpStream("dvl", port, absent=absent)


def test_a_host_that_nobody_knows_is_an_error_of_one_line():
    with pytest.raises(BusError, match="there is no such host; give its address in numbers"):
        TcpStream("dvl", "tcp:no-such-host.invalid:16171")
    with pytest.raises(BusError, match="there is no such host; give its address in numbers"):
        TcpStream("dvl", f"tcp:{'a' * 64}.invalid:16171", absent=True)  # no name of a host


def test_a_host_that_is_not_known_where_it_may_be_absent_is_silence_and_not_looked_up_in_flight(monkeypatch):
    """At boot the network may not be there yet."""
    stream = TcpStream("dvl", "tcp:no-such-host.invalid:16171", absent=True)
    assert "there is no such host; give its address in numbers" in stream.missing
    monkeypatch.setattr(socket, "gethostbyname", None)
    assert [stream.read(float(t)) for t in range(5)] == [b""] * 5
    stream.write(b"hello")
    assert stream.broken
    stream.close()
    stream.close()


def test_a_device_that_must_be_there_and_is_not_is_an_error(tmp_path):
    wire = Tcp(tmp_path, plugged=False)
    with pytest.raises(BusError, match="cannot be opened: nothing answers there"):
        TcpStream("dvl", f"tcp:127.0.0.1:{wire.number}")
    wire.close()


def test_a_device_that_reads_nothing_is_never_waited_for(tmp_path):
    wire = Tcp(tmp_path)
    stream = wire.stream()
    wire.said()
    for _ in range(3000):
        stream.write(bytes(4000))
    assert stream.losses()["not_sent"] > 0
    stream.close()
    wire.close()


def test_a_line_that_takes_nothing_is_never_waited_for():
    with SerialLine() as line:
        port = SerialPort("device", line.path, 115200)
        for _ in range(100):
            port.write(bytes(1000))
        assert port.losses()["not_sent"] > 0
        port.close()


def test_a_connection_that_stays_away_is_begun_anew():
    """A listener whose queue is full answers nothing, as a host without its plug."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(0)
        fillers = [socket.socket() for _ in range(4)]
        for filler in fillers:
            filler.setblocking(False)
            filler.connect_ex(listener.getsockname())
        dial = tcp_dial.TcpDial(listener.getsockname())
        names = set()
        for k in range(100):
            assert dial.connected(k / 10) is None
            with socket.socket(fileno=os.dup(dial.fileno())) as same:
                names.add(same.getsockname())
        assert len(names) == 4
        for filler in fillers:
            filler.close()
        dial.close()
