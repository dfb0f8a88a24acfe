"""A device's end of a TCP port, which the driver of the autopilot connects to."""

from __future__ import annotations

import contextlib
import re
import socket
from types import TracebackType

from firmware_py.adapters.buses.can_bus import BusError
from firmware_py.error_text import quoted

MOST_PEERS = 4
"""So many are served at once; the first to have come goes when one more comes."""
_PORT = re.compile(r"tcp:([^:\[\]]+):(\d{1,5})")


class TcpLine:
    """Listens at a port, and sends the same to all who are connected. Nothing ever blocks.

    Args:
        port: "tcp:HOST:PORT" as in an io file; HOST must be an address of this computer. Port 0: any that is free.

    Attributes:
        path: the port, with its number.
        lost: how often somebody left no room; they are cut off, since half a message would follow.
        late: always 0, since what loopback has taken can be read.

    Raises:
        BusError: it cannot listen there.
    """

    def __init__(self, port: str) -> None:
        self.lost = self.late = 0
        self._peers: list[socket.socket] = []
        found = _PORT.fullmatch(port)
        if found is None or not int(found[2]) < 65536:
            raise BusError(f"port {quoted(port)}: must be tcp:HOST:PORT, such as tcp:127.0.0.1:16171")
        try:
            self._listener = socket.create_server((found[1], int(found[2])))
        except OSError as error:
            host = f"HOST must be this computer: tcp:127.0.0.1:{found[2]}, or ip address add {found[1]}/32 dev lo"
            raise BusError(f"port {quoted(port)}: nothing can listen there ({error.strerror}); {host}") from None
        self._listener.setblocking(False)
        self.path = f"tcp:{found[1]}:{self._listener.getsockname()[1]}"

    def send(self, line: bytes) -> None:
        """Send bytes to all who are connected; cut off who does not take them."""
        self._accept()
        for peer in [*self._peers]:
            try:
                whole = peer.send(line) == len(line)
            except BlockingIOError:
                whole = False
            except OSError:
                self._cut(peer)
                continue
            if not whole:
                self.lost += 1
                self._cut(peer)

    def receive(self) -> bytes:
        """Return what was written to the device, at most 1 kB of each; empty if nothing."""
        self._accept()
        told = b""
        for peer in [*self._peers]:
            try:
                data = peer.recv(1024)
            except BlockingIOError:
                continue
            except OSError:
                data = b""
            if not data:
                self._cut(peer)
            told += data
        return told

    def close(self) -> None:
        """Stop listening, and end all connections; a second call does nothing."""
        for peer in [*self._peers]:
            self._cut(peer)
        self._listener.close()

    def __enter__(self) -> TcpLine:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _accept(self) -> None:
        with contextlib.suppress(BlockingIOError, ConnectionError):
            peer, _ = self._listener.accept()
            peer.setblocking(False)
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._peers.append(peer)
            if len(self._peers) > MOST_PEERS:
                self._cut(self._peers[0])

    def _cut(self, peer: socket.socket) -> None:
        self._peers.remove(peer)
        peer.close()
