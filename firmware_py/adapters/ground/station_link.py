"""The links to ground stations as they are written on the command line, and who opens each."""

from __future__ import annotations

import errno
from typing import NamedTuple, Protocol

from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration

_SYNTAX = (
    "write udpout:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:DEVICE:BAUD, "
    "with :ardusub (the default) or :generic and :highlatency behind it"
)
_PORT_IN_USE = "another program has that port: end it, or take another port"
_NETWORK, _SERIAL = ("udpout", "udpin", "tcp", "tcpin"), "serial"
_HIGH_LATENCY = "highlatency"
_BITS_PER_BYTE = 10
_USED_SHARE = 0.9
"""Of a serial line's rate that is used: what comes late would come later and later."""

Address = tuple[str, int]


class GroundError(Exception):
    """A link that cannot be opened; the text names it and what would be right."""


class LinkSpec(NamedTuple):
    """A link as it is written: udpout and tcp go to a station, udpin and tcpin wait for one; of serial the baud."""

    text: str
    kind: str
    address: Address
    configuration: LinkConfiguration

    def error(self, error: OSError | str) -> GroundError:
        """That it cannot be opened."""
        why = error if isinstance(error, str) else error.strerror or error
        taken = isinstance(error, OSError) and error.errno == errno.EADDRINUSE
        return GroundError(f"link {self.text!r} cannot be opened: {why}; {_PORT_IN_USE if taken else _SYNTAX}")


class StationLink(Protocol):
    """A way to stations that never waits. A station that is not there is silence, not an error."""

    configuration: LinkConfiguration
    lost: int
    """What the way would not take: datagrams, or of a stream what one tick had to say."""

    @property
    def overrun(self) -> int:
        """Datagrams that came and found no room in the kernel; of a stream the sender waits instead."""

    def fileno(self) -> int:
        """What those can wait for who want to know that something came."""

    def receive(self) -> list[bytes]:
        """What has come, oldest first, up to so much a tick; the rest waits in the kernel."""

    def send(self, datagram: bytes) -> None:
        """Sends to whoever is there."""

    def close(self) -> None:
        """Gives the way back; may be called twice."""


def parse_link(text: str) -> LinkSpec:
    """Reads `KIND:PLACE:NUMBER[:IDENTITY][:highlatency]`.

    Raises:
        GroundError: it is no link.
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
            raise GroundError(f"link {text!r}: {_SYNTAX}")
    if kind not in (*_NETWORK, _SERIAL) or len(rest) < 2 or not rest[0] or len(rest) > 4:
        raise GroundError(f"link {text!r}: {_SYNTAX}")
    place, number = rest[0], rest[1]
    whole = int(number) if number.isascii() and number.isdigit() and len(number) < 9 else -1
    if kind == _SERIAL:
        if not 1200 <= whole <= 4_000_000:
            raise GroundError(f"link {text!r}: baud {number!r} is not one of 1200 to 4000000")
        rate = _USED_SHARE * whole / _BITS_PER_BYTE
        return LinkSpec(
            text, kind, (place, whole), LinkConfiguration(identity, rate, stream=True, high_latency=high_latency)
        )
    if not (1 <= whole < 2**16 or (whole == 0 and kind.endswith("in"))):
        raise GroundError(f"link {text!r}: port {number!r} is not one of 1 to 65535")
    configuration = LinkConfiguration(identity, stream=kind.startswith("tcp"), high_latency=high_latency)
    return LinkSpec(text, kind, (place, whole), configuration)
