"""The transports that a device may be plugged in by: each brings `send`, `said`, `unplug` and `replug`."""

from __future__ import annotations

import array
import fcntl
import socket
import termios
import time
from pathlib import Path
from typing import Protocol

from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.drivers.stream_driver import ByteStream
from firmware_py.adapters.drivers.tcp_stream import TcpStream
from sim_bridge.devices.serial_line import SerialLine

PATIENCE = 10.0


class Wire(Protocol):
    """The device's end; `capacity` is how many bytes may wait."""

    capacity: int

    def stream(self) -> ByteStream:
        """The driver's end of it, which may be absent yet."""

    def send(self, data: bytes) -> None:
        """Send whole; return when it can be read."""

    def said(self) -> bytes:
        """What the device was told since the last time."""

    def unplug(self) -> None:
        """Break it off."""

    def replug(self) -> None:
        """Make it anew."""

    def close(self) -> None:
        """End it."""


class Terminal:
    """A serial line under a name that stays, as udev gives it: a pseudo-terminal."""

    capacity = 4000

    def __init__(self, folder: Path, *, plugged: bool = True) -> None:
        self._name = folder / "device"
        self._line: SerialLine | None = None
        if plugged:
            self.replug()

    def stream(self) -> SerialPort:
        return SerialPort("device", str(self._name), 115200, absent=True)

    def send(self, data: bytes) -> None:
        assert self._line is not None
        self._line.send(data)
        assert not self._line.lost

    def said(self) -> bytes:
        assert self._line is not None
        return self._line.receive()

    def unplug(self) -> None:
        assert self._line is not None
        self._name.unlink()
        self._line.close()
        self._line = None

    def replug(self) -> None:
        self._line = SerialLine()
        self._name.symlink_to(self._line.path)

    def close(self) -> None:
        if self._line is not None:
            self._line.close()


class Tcp:
    """A device that listens on a TCP port. A second socket keeps its number while it is unplugged."""

    capacity = 40_000

    def __init__(self, folder: Path, *, plugged: bool = True) -> None:
        self._holder = _bound(0)
        self.number = self._holder.getsockname()[1]
        self._listener: socket.socket | None = None
        self._peer: socket.socket | None = None
        self._count = array.array("i", [0])
        if plugged:
            self.replug()

    def stream(self) -> TcpStream:
        self._stream = TcpStream("device", f"tcp:127.0.0.1:{self.number}", absent=True)
        return self._stream

    def send(self, data: bytes) -> None:
        peer = self._accepted()
        wanted, deadline = self._waiting() + len(data), time.monotonic() + PATIENCE
        peer.sendall(data)
        while self._waiting() < wanted:
            assert time.monotonic() < deadline

    def said(self) -> bytes:
        peer = self._accepted()
        peer.setblocking(False)
        try:
            return peer.recv(4096)
        except BlockingIOError:
            return b""
        finally:
            peer.setblocking(True)

    def unplug(self) -> None:
        self._accepted().close()
        assert self._listener is not None
        self._listener.close()
        self._peer = self._listener = None

    def replug(self) -> None:
        self._listener = _bound(self.number)
        self._listener.listen(1)
        self._listener.settimeout(PATIENCE)

    def close(self) -> None:
        for one in (self._peer, self._listener, self._holder):
            if one is not None:
                one.close()

    def _waiting(self) -> int:
        """How many bytes wait at the driver's end."""
        if self._stream.fileno() >= 0:
            fcntl.ioctl(self._stream.fileno(), termios.FIONREAD, self._count, True)
        return self._count[0]

    def _accepted(self) -> socket.socket:
        if self._peer is None:
            assert self._listener is not None
            self._peer, _ = self._listener.accept()
        return self._peer


def _bound(port: int) -> socket.socket:
    one = socket.socket()
    one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    one.bind(("127.0.0.1", port))
    return one


WIRES = {"pty": Terminal, "tcp": Tcp}
