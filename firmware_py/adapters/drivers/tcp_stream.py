"""A device that listens on a TCP port, tcp:HOST:PORT: connected to without waiting, and again when it is back."""

from __future__ import annotations

import contextlib
import socket
import time

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.adapters.drivers.serial_port import BYTES_PER_TICK
from firmware_py.adapters.tcp_dial import TcpDial, address_of, prepare
from firmware_py.error_text import quoted

START_S = 1.0
"""So long a connection is waited for at the start, s."""
_KEEPALIVE = {socket.TCP_KEEPIDLE: 2, socket.TCP_KEEPINTVL: 1}
"""A device that is silent for 2 s is asked every second whether it is there: a plug that was pulled tells nothing."""


class TcpStream:
    """A byte stream. A connection that ends is silence, not an error, and is made again when it can.

    Args:
        device: what is connected to, for errors.
        port: "tcp:HOST:PORT".
        absent: whether a device that is not there yet is silence too, and not an error. So is a host that is not known
            at the start: it is never looked up again.

    Attributes:
        missing: why there was no connection at the start; empty if there was one.
        openings: how often it was made: after another one the rest of a message does not come.

    Raises:
        BusError: no such port, or no connection.
    """

    def __init__(self, device: str, port: str, *, absent: bool = False) -> None:
        self._peer: socket.socket | None = None
        self._breaks = self._not_sent = 0
        self.missing, self.openings = "", 0
        try:
            address = address_of(port)
        except ValueError as error:
            raise BusError(f"{device}: port {quoted(port)}: {error}") from None
        self._dial: TcpDial | None = None
        try:
            self._dial = TcpDial(address)
        except (OSError, UnicodeError) as error:
            text = "there is no such host; give its address in numbers, or look at the network"
            self.missing = f"{device}: port {quoted(port)} cannot be opened: {text}"
            if not absent or isinstance(error, UnicodeError):
                raise BusError(self.missing) from None
            return  # to look it up may take seconds, which no cycle has
        began = time.monotonic()
        while self.broken and time.monotonic() - began < START_S:
            self._connect(0.0)
            if self.broken and self._dial.fileno() < 0:
                break
            time.sleep(0.001)
        if self.broken:
            self.missing = f"{device}: port {quoted(port)} cannot be opened: nothing answers there"
            if not absent:
                self.close()
                raise BusError(self.missing)

    @property
    def broken(self) -> bool:
        """Return whether there is no connection."""
        return self._peer is None

    def fileno(self) -> int:
        """Return the socket, to wait on; -1 while there is none."""
        return -1 if self._peer is None else self._peer.fileno()

    def read(self, t: float) -> bytes:
        """Return the bytes that have arrived, a bounded number; try to connect again at `t`, s."""
        if self._peer is None:
            self._connect(t)
            if self._peer is None:
                return b""
        try:
            data = self._peer.recv(BYTES_PER_TICK)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._leave()
            self._breaks += 1
        return data

    def write(self, data: bytes) -> None:
        """Send bytes; what the connection does not take at once is counted. A broken one takes nothing."""
        if self._peer is None:
            return
        try:
            sent = self._peer.send(data)
        except OSError:  # a connection that broke is noticed when it is read
            sent = 0
        self._not_sent += sent < len(data)

    def losses(self) -> dict[str, int]:
        """Return what is wrong with the connection.

        Returns:
            broken: 1 while there is none; breaks: how often it ended.
            not_sent: how often it did not take what the device should have been told.
        """
        return {"broken": int(self.broken), "breaks": self._breaks, "not_sent": self._not_sent}

    def close(self) -> None:
        """Close the connection; may be called twice."""
        self._leave()
        if self._dial is not None:
            self._dial.close()

    def _connect(self, t: float) -> None:
        peer = None if self._dial is None else self._dial.connected(t)
        if peer is None:
            return
        with contextlib.suppress(OSError):  # one that has ended already is noticed when it is read
            prepare(peer)
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
            for option, value in _KEEPALIVE.items():
                peer.setsockopt(socket.IPPROTO_TCP, option, value)
        self._peer = peer
        self.openings += 1

    def _leave(self) -> None:
        if self._peer is not None:
            self._peer.close()
            self._peer = None
