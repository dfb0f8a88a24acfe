"""Stations over a stream of bytes: TCP either way round, and serial lines. Frames are found in it by the codec."""

from __future__ import annotations

import contextlib
import errno
import socket
import time
from typing import Any

import serial

from firmware_py.adapters.ground.station_link import Address, LinkSpec

BYTES_PER_TICK = 4096
MAX_UNSENT = 16384
RETRY_S = 1.0
_CONNECTING, _CONNECTED = (errno.EINPROGRESS, errno.EALREADY), (0, errno.EISCONN)
"""What a second connect says of the first."""
_DEAD_AFTER_MS = 10_000
"""A peer that acknowledges nothing for so long is gone."""


class TcpLink:
    """What both ends of TCP have in common: at most one peer, and what it has not taken yet.

    A peer that reads too slowly misses what one tick had to say, whole, and not the end of a frame.
    """

    overrun = 0
    """See `StationLink`."""

    def __init__(self, spec: LinkSpec) -> None:
        self.configuration = spec.configuration
        self._peer: socket.socket | None = None
        self._unsent = b""
        self.lost = 0
        """Ticks whose words nobody took."""

    def receive(self) -> list[bytes]:
        """What has come, up to so many bytes."""
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
        """Sends what the peer takes now; the rest goes before what is sent next."""
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
        """Ends the connection; may be called twice."""
        self._disconnect()

    def _connect(self) -> None:
        """Sees to it that there is a peer, if that can be had at once."""
        raise NotImplementedError

    def _accept(self, peer: socket.socket) -> None:
        peer.setblocking(False)
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _DEAD_AFTER_MS)
        self._peer = peer

    def _disconnect(self) -> None:
        self._unsent = b""
        if self._peer is not None:
            self._peer.close()
            self._peer = None


class TcpServer(TcpLink):
    """Waits for a station; while one is there others wait in the kernel's queue.

    Raises:
        GroundError: the port cannot be had.
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
        """Where stations find it."""
        host, port = self._listener.getsockname()
        return host, port

    def fileno(self) -> int:
        """The station's socket, or the one at which stations ring."""
        return (self._peer or self._listener).fileno()

    def close(self) -> None:
        """Ends the connection and gives the port back; may be called twice."""
        super().close()
        self._listener.close()

    def _connect(self) -> None:
        if self._peer is None:
            with contextlib.suppress(OSError):
                self._accept(self._listener.accept()[0])


class TcpClient(TcpLink):
    """Goes to a station, again each second while it is not there.

    Raises:
        GroundError: there is no such host.
    """

    def __init__(self, spec: LinkSpec) -> None:
        super().__init__(spec)
        try:
            self._address = socket.gethostbyname(spec.address[0]), spec.address[1]
        except OSError as error:
            raise spec.error(error) from None
        self._connecting: socket.socket | None = None
        self._tried = -RETRY_S
        self._connect()

    def fileno(self) -> int:
        """The socket; -1 while there is none."""
        either = self._peer or self._connecting
        return -1 if either is None else either.fileno()

    def close(self) -> None:
        """Ends the connection; may be called twice."""
        super().close()
        if self._connecting is not None:
            self._connecting.close()
            self._connecting = None

    def _connect(self) -> None:
        if self._peer is not None:
            return
        if self._connecting is None:
            if time.monotonic() - self._tried < RETRY_S:
                return
            self._tried = time.monotonic()
            self._connecting = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
            self._connecting.setblocking(False)
        try:
            self._connecting.connect(self._address)
        except (BlockingIOError, InterruptedError):
            return
        except OSError as error:
            if error.errno in _CONNECTING:
                return
            if error.errno not in _CONNECTED:
                self._connecting.close()
                self._connecting = None
                return
        calling, self._connecting = self._connecting, None
        self._accept(calling)


class SerialLink:
    """A serial line. One that breaks, as an adapter that is unplugged does, is tried again each second.

    Raises:
        GroundError: the device cannot be opened.
    """

    overrun = 0
    """See `StationLink`."""

    def __init__(self, spec: LinkSpec) -> None:
        self.configuration = spec.configuration
        self._device, self._baud = spec.address
        self._port: Any = None
        self._tried = 0.0
        self.lost = 0
        """Ticks whose words the line did not take."""
        try:
            self._port = self._open()
        except (serial.SerialException, ValueError, OSError) as error:
            raise spec.error(error if isinstance(error, OSError) else str(error)) from None

    def fileno(self) -> int:
        """The device; -1 while it is broken."""
        return -1 if self._port is None else int(self._port.fileno())

    def receive(self) -> list[bytes]:
        """What has come, up to so many bytes."""
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
        """Hands it to the line if the line has room for all of it."""
        if self._port is None:
            return
        try:
            if self._port.out_waiting + len(datagram) > BYTES_PER_TICK or self._port.write(datagram) != len(datagram):
                self.lost += 1
        except serial.SerialTimeoutException:
            self.lost += 1
        except (serial.SerialException, OSError):
            self.close()

    def close(self) -> None:
        """Gives the device back; may be called twice."""
        if self._port is not None:
            with contextlib.suppress(serial.SerialException, OSError):
                self._port.close()
            self._port = None

    def _open(self) -> Any:
        self._tried = time.monotonic()
        return serial.Serial(self._device, self._baud, timeout=0, write_timeout=0, exclusive=True)
