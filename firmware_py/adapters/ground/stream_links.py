"""Links over byte streams: TCP server, TCP client and serial line. The codec finds the frames in them."""

from __future__ import annotations

import contextlib
import os
import socket
import time
from typing import Any

import serial

from firmware_py.adapters.ground.station_link import Address, LinkSpec
from firmware_py.adapters.serial_open import open_serial
from firmware_py.adapters.tcp_dial import RETRY_S, TcpDial, prepare

BYTES_PER_TICK = 4096
MAX_UNSENT = 16384


class TcpLink:
    """Base of the TCP links: at most one peer, and the bytes not sent to it yet.

    A peer that reads too slowly misses the output of whole ticks, never a part of a frame.
    """

    overrun = 0
    """See `StationLink`."""

    def __init__(self, spec: LinkSpec) -> None:
        self.configuration = spec.configuration
        self._peer: socket.socket | None = None
        self._unsent = b""
        self.lost = 0
        """Ticks whose output was not accepted."""

    def receive(self) -> list[bytes]:
        """Return what was received, up to BYTES_PER_TICK."""
        self._connect()
        if self._peer is None:
            return []
        try:
            data = self._peer.recv(BYTES_PER_TICK)
        except BlockingIOError:
            return []
        except OSError:
            data = b""
        if not data:
            self._disconnect()
            return []
        return [data]

    def send(self, datagram: bytes) -> None:
        """Send as much as the peer accepts now; the rest is sent before the next output."""
        if self._peer is None:
            return
        if len(self._unsent) + len(datagram) > MAX_UNSENT:
            self.lost += 1
        else:
            self._unsent += datagram
        try:
            self._unsent = self._unsent[self._peer.send(self._unsent) :]
        except BlockingIOError:
            pass
        except OSError:
            self._disconnect()

    def close(self) -> None:
        """Close the connection; may be called twice."""
        self._disconnect()

    def _connect(self) -> None:
        """Connect to a peer if that is possible without waiting."""
        raise NotImplementedError

    def _accept(self, peer: socket.socket) -> None:
        prepare(peer)
        self._peer = peer

    def _disconnect(self) -> None:
        self._unsent = b""
        if self._peer is not None:
            self._peer.close()
            self._peer = None


class TcpServer(TcpLink):
    """TCP server for one station; while it is connected, others wait in the kernel's queue.

    Raises:
        GroundError: the port cannot be opened.
    """

    def __init__(self, spec: LinkSpec) -> None:
        super().__init__(spec)
        self._listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._listener.setblocking(False)
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._listener.bind(spec.address)
            self._listener.listen(1)
        except OSError as error:
            self._listener.close()
            raise spec.error(error) from None

    @property
    def address(self) -> Address:
        """The address that stations connect to."""
        host, port = self._listener.getsockname()
        return host, port

    def fileno(self) -> int:
        """Return the station's socket, or the listening one."""
        return (self._peer or self._listener).fileno()

    def close(self) -> None:
        """Close the connection and the port; may be called twice."""
        super().close()
        self._listener.close()

    def _connect(self) -> None:
        if self._peer is None:
            with contextlib.suppress(OSError):
                self._accept(self._listener.accept()[0])


class TcpClient(TcpLink):
    """TCP client: connects to a station, and retries each second.

    Raises:
        GroundError: there is no such host.
    """

    def __init__(self, spec: LinkSpec) -> None:
        super().__init__(spec)
        try:
            self._dial = TcpDial(spec.address)
        except OSError as error:
            raise spec.error(error) from None
        self._connect()

    def fileno(self) -> int:
        """Return the socket; -1 while there is none."""
        return (self._peer or self._dial).fileno()

    def close(self) -> None:
        """Close the connection; may be called twice."""
        super().close()
        self._dial.close()

    def _connect(self) -> None:
        if self._peer is None and (peer := self._dial.connected(time.monotonic())) is not None:
            self._accept(peer)


class SerialLink:
    """A serial line. A line that breaks, such as an adapter that is unplugged, is reopened each second.

    A line that takes no more misses the output of whole ticks, never a part of a frame.

    Raises:
        GroundError: the device cannot be opened.
    """

    overrun = 0
    """See `StationLink`."""

    def __init__(self, spec: LinkSpec) -> None:
        self.configuration = spec.configuration
        self._device, self._baud = spec.address
        self._port: Any = None
        self._unsent = b""
        """The rest of a datagram that was begun."""
        self._tried = 0.0
        self.lost = 0
        """Ticks whose output was not accepted."""
        try:
            self._port = self._open()
        except (serial.SerialException, ValueError, OSError) as error:
            raise spec.error(error if isinstance(error, OSError) else str(error)) from None

    def fileno(self) -> int:
        """Return the device; -1 while it is broken."""
        return -1 if self._port is None else int(self._port.fileno())

    def receive(self) -> list[bytes]:
        """Return what was received, up to BYTES_PER_TICK."""
        if self._port is None and time.monotonic() - self._tried >= RETRY_S:
            with contextlib.suppress(serial.SerialException, OSError):
                self._port = self._open()
        if self._port is None:
            return []
        try:
            data: bytes = self._port.read(min(self._port.in_waiting, BYTES_PER_TICK))
        except (serial.SerialException, OSError):
            self.close()
            return []
        return [data] if data else []

    def send(self, datagram: bytes) -> None:
        """Send the datagram if the line has room for all of it and takes its beginning now."""
        if self._port is None:
            return
        rest = self._unsent
        try:
            room = BYTES_PER_TICK - self._port.out_waiting - len(rest)
            written = self._write(rest + datagram) if len(datagram) <= room else 0
        except (serial.SerialException, OSError):
            self.close()
            return
        begun = written > len(rest)
        self._unsent = (rest + datagram if begun else rest)[written:]
        self.lost += not begun

    def close(self) -> None:
        """Close the device; may be called twice."""
        if self._port is not None:
            with contextlib.suppress(serial.SerialException, OSError):
                self._port.close()
            self._port, self._unsent = None, b""

    def _write(self, data: bytes) -> int:
        """Return how many bytes the line takes now; pyserial would try until it takes all of them."""
        try:
            return os.write(self._port.fileno(), data)
        except BlockingIOError:
            return 0

    def _open(self) -> Any:
        self._tried = time.monotonic()
        return open_serial(self._device, self._baud)
