"""A TCP connection to an address, made without waiting and tried again every second."""

from __future__ import annotations

import errno
import re
import socket

Address = tuple[str, int]
RETRY_S = 1.0
PATIENCE_S = 3.0
"""What has not connected for so long begins anew, s: the kernel waits longer each time before it asks again."""
_CONNECTING, _CONNECTED = (errno.EINPROGRESS, errno.EALREADY, errno.EAGAIN), (0, errno.EISCONN)
"""Errors of a repeated connect: still connecting, and connected."""
_DEAD_AFTER_MS = 10_000
"""A peer that acknowledges nothing for so long is disconnected."""
_PORT = re.compile(r"tcp:([^:\[\]]+):(\d{1,5})")


def address_of(port: str) -> Address:
    """Return the address in "tcp:HOST:PORT".

    Raises:
        ValueError: it has another form.
    """
    found = _PORT.fullmatch(port)
    if found is None or not 0 < int(found[2]) < 65536:
        raise ValueError("must be tcp:HOST:PORT, such as tcp:192.168.194.95:16171")
    return found[1], int(found[2])


class TcpDial:
    """Connects to an address.

    Args:
        address: host and port; a name is looked up here, once.

    Raises:
        OSError: there is no such host.
    """

    def __init__(self, address: Address) -> None:
        self._address = socket.gethostbyname(address[0]), address[1]
        self._connecting: socket.socket | None = None
        self._tried = -RETRY_S

    def fileno(self) -> int:
        """Return the socket that connects; -1 while there is none."""
        return -1 if self._connecting is None else self._connecting.fileno()

    def connected(self, t: float) -> socket.socket | None:
        """Return a socket that has connected, once; else None, and go on connecting at `t`, s."""
        if self._connecting is not None and t - self._tried >= PATIENCE_S:
            self.close()
        if self._connecting is None:
            if t - self._tried < RETRY_S:
                return None
            self._tried = t
            self._connecting = socket.socket(socket.AF_INET, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
        error = self._connecting.connect_ex(self._address)
        if error in _CONNECTED:
            connected, self._connecting = self._connecting, None
            return connected
        if error not in _CONNECTING:
            self.close()
        return None

    def close(self) -> None:
        """Connect no longer; may be called twice."""
        if self._connecting is not None:
            self._connecting.close()
            self._connecting = None


def prepare(peer: socket.socket) -> None:
    """Have a connection send at once and never wait, and break when its peer is no longer there."""
    peer.setblocking(False)
    peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if hasattr(socket, "TCP_USER_TIMEOUT"):
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _DEAD_AFTER_MS)
