"""What the kernel keeps of a bus between two drains: how much it may be, and how often it was too little."""

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


def enlarge(door: socket.socket) -> None:
    """Asks for SIZE; without the right to exceed net.core.rmem_max, for as much as that allows."""
    try:
        door.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, SIZE)
    except OSError:
        door.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SIZE)


def overrun(door: socket.socket) -> int:
    """How many frames, one's own included, came while the buffer was full."""
    return int(_MEMINFO.unpack(door.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _MEMINFO.size))[_DROPS])
