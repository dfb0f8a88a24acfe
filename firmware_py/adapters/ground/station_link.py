"""Links to ground stations: the syntax of the command line, and the interface of a link."""

from __future__ import annotations

import errno
import os
import socket
from typing import NamedTuple, Protocol

from firmware_py.error_text import quoted
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration

_SYNTAX = (
    "write udpout:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:DEVICE:BAUD, "
    "with :ardusub (the default) or :generic and :highlatency behind it"
)
_PORT_IN_USE = "another program has that port: end it, or take another port"
_NETWORK, _SERIAL = ("udpout", "udpin", "tcp", "tcpin"), "serial"
_HIGH_LATENCY = "highlatency"
_LATER = (
    errno.ENOENT,
    errno.ENODEV,
    errno.ENXIO,
    errno.EIO,
    errno.ENETDOWN,
    errno.ENETUNREACH,
    errno.EHOSTUNREACH,
    errno.EADDRNOTAVAIL,
    socket.EAI_AGAIN,
    socket.EAI_NONAME,
)
"""What keeps a link from being opened before its adapter is plugged in, or the network is up."""
_NOT_YET = (errno.EAGAIN, errno.EBUSY, errno.EACCES)
"""Of a serial port besides: a modem manager tries it, or udev has not given it to its group yet."""
_BITS_PER_BYTE = 10
_USED_SHARE = 0.9
"""Share of a serial line's rate that is used, so that its queue cannot grow."""

Address = tuple[str, int]


class GroundError(Exception):
    """A link cannot be opened; the text names it and what would be right."""


class LinkAbsentError(GroundError):
    """A link that may be opened later; `why` it cannot be now."""

    def __init__(self, text: str, why: str) -> None:
        super().__init__(text)
        self.why = why


class LinkSpec(NamedTuple):
    """A parsed link: udpout and tcp connect to a station, udpin and tcpin wait for one; serial is (device, baud)."""

    text: str
    kind: str
    address: Address
    configuration: LinkConfiguration

    def error(self, error: OSError | str) -> GroundError:
        """Return the error that says why the link cannot be opened."""
        why = error if isinstance(error, str) else error.strerror or error
        taken = isinstance(error, OSError) and error.errno == errno.EADDRINUSE
        text = f"link {quoted(self.text)} cannot be opened: {why}; {_PORT_IN_USE if taken else _SYNTAX}"
        later = self.kind == _SERIAL and isinstance(error, OSError) and error.errno in _NOT_YET
        if isinstance(error, OSError) and error.errno and (later or error.errno in _LATER):
            return LinkAbsentError(text, os.strerror(error.errno) if error.errno > 0 else str(why))
        return GroundError(text)


class StationLink(Protocol):
    """A transport to stations that never blocks. A station that is not connected is no error."""

    configuration: LinkConfiguration

    @property
    def lost(self) -> int:
        """Datagrams that were not accepted for sending; on a stream, the output of whole ticks."""

    @property
    def overrun(self) -> int:
        """Received datagrams that the kernel had no room for; 0 on a stream, where the sender waits."""

    def fileno(self) -> int:
        """Return the file descriptor to wait on for input; -1 if there is none."""

    def receive(self) -> list[bytes]:
        """Return what was received, oldest first, up to a limit per tick; the rest waits in the kernel."""

    def send(self, datagram: bytes) -> None:
        """Send to the connected stations."""

    def close(self) -> None:
        """Close the link; may be called twice."""


def parse_link(text: str) -> LinkSpec:
    """Parse `KIND:PLACE:NUMBER[:IDENTITY][:highlatency]`.

    Raises:
        GroundError: wrong syntax.
    """
    kind, *rest = text.split(":")
    identities = {identity.name.lower(): identity for identity in Identity}
    identity, high_latency = Identity.ARDUSUB, False
    for word in rest[2:]:
        if word in identities:
            identity = identities[word]
        elif word == _HIGH_LATENCY:
            high_latency = True
        else:
            raise GroundError(f"link {quoted(text)}: {_SYNTAX}")
    if kind not in (*_NETWORK, _SERIAL) or len(rest) < 2 or not rest[0] or len(rest) > 4:
        raise GroundError(f"link {quoted(text)}: {_SYNTAX}")
    place, number = rest[0], rest[1]
    whole = int(number) if number.isascii() and number.isdigit() and len(number) < 9 else -1
    if kind == _SERIAL:
        if not 1200 <= whole <= 4_000_000:
            raise GroundError(f"link {quoted(text)}: baud {quoted(number)} is not one of 1200 to 4000000")
        rate = _USED_SHARE * whole / _BITS_PER_BYTE
        return LinkSpec(
            text, kind, (place, whole), LinkConfiguration(identity, rate, stream=True, high_latency=high_latency)
        )
    if not (1 <= whole < 2**16 or (whole == 0 and kind.endswith("in"))):
        raise GroundError(f"link {quoted(text)}: port {quoted(number)} is not one of 1 to 65535")
    configuration = LinkConfiguration(identity, stream=kind.startswith("tcp"), high_latency=high_latency)
    return LinkSpec(text, kind, (place, whole), configuration)
