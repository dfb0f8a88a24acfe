"""The kernel's receive buffer of a socket: make it large, and count what it had no room for."""

from __future__ import annotations

import socket
import struct

SIZE = 4 << 20
"""Room for some thousand frames, bytes: the kernel counts about 1 kB for each."""
# Linux, asm-generic/socket.h and linux/sock_diag.h; the socket module does not name them.
_SO_RCVBUFFORCE = 33
_SO_MEMINFO = 55
_MEMINFO = struct.Struct("9I")
_DROPS = 8


def enlarge(receiver: socket.socket) -> None:
    """Ask for SIZE bytes; without the right to exceed net.core.rmem_max, for as much as that allows."""
    try:
        receiver.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, SIZE)
    except OSError:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SIZE)


def overrun(receiver: socket.socket) -> int:
    """Return how many frames, one's own included, arrived while the buffer was full."""
    return int(_MEMINFO.unpack(receiver.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _MEMINFO.size))[_DROPS])
