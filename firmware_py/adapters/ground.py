"""Stations on the ground: MAVLink over UDP, several links at once, beside whoever else gives orders."""

from __future__ import annotations

import contextlib
import math
import socket
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from firmware_py.marine import Origin
from firmware_py.mavlink.identity import Identity
from firmware_py.mavlink.node import MavlinkParams, Node
from firmware_py.mavlink.status import Actuators
from firmware_py.ports import Ground
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import NO_ORDER, Arming, Mode, Order, Setpoint
from firmware_py.schedule import Tick

DATAGRAMS_PER_TICK = 16
_DATAGRAM_BYTES = 2048
_MOST_STATIONS = 4
_RIGHT = "write udpout:HOST:PORT or udpin:HOST:PORT, with :ardusub (the default) or :generic behind it"

Address = tuple[str, int]


class GroundError(Exception):
    """A link that cannot be opened; the text names it and what would be right."""


class LinkSpec(NamedTuple):
    """A link as it is written: udpout sends to a station, udpin waits for stations to speak."""

    listens: bool
    address: Address
    identity: Identity


def parse_link(text: str) -> LinkSpec:
    """Reads `udpout:HOST:PORT[:IDENTITY]` or `udpin:HOST:PORT[:IDENTITY]`.

    Raises:
        GroundError: it is none of these.
    """
    parts = text.split(":")
    identities = {identity.name.lower(): identity for identity in Identity}
    if len(parts) == 3:
        parts.append("ardusub")
    if len(parts) != 4 or parts[0] not in ("udpout", "udpin") or not parts[1] or parts[3] not in identities:
        raise GroundError(f"link {text!r}: {_RIGHT}")
    if not (parts[2].isascii() and parts[2].isdigit() and int(parts[2]) < 2**16) or parts[0::2] == ["udpout", "0"]:
        raise GroundError(f"link {text!r}: port {parts[2]!r} is not one of 1 to 65535")
    return LinkSpec(parts[0] == "udpin", (parts[1], int(parts[2])), identities[parts[3]])


class UdpLink:
    """A socket that never waits. A station that is not there is silence, not an error."""

    def __init__(self, text: str) -> None:
        spec = parse_link(text)
        self.identity = spec.identity
        self._listens = spec.listens
        self._stations: dict[Address, None] = {}  # who was heard last stands last
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self.lost = 0
        """Datagrams that the network would not take."""
        try:
            if spec.listens:
                self._socket.bind(spec.address)
            else:
                self._socket.connect(spec.address)
        except OSError as error:
            self._socket.close()
            raise GroundError(f"link {text!r} cannot be opened: {error.strerror or error}; {_RIGHT}") from None

    @property
    def address(self) -> Address:
        """Where this end of the link is."""
        host, port = self._socket.getsockname()
        return host, port

    def fileno(self) -> int:
        """The socket, for those that wait for it."""
        return self._socket.fileno()

    def receive(self) -> list[bytes]:
        """The datagrams that have come, oldest first, up to so many a tick; the rest waits in the kernel."""
        datagrams = []
        for _ in range(DATAGRAMS_PER_TICK):
            try:
                datagram, sender = self._socket.recvfrom(_DATAGRAM_BYTES)
            except BlockingIOError:
                break
            except OSError:  # the answer to something sent: nobody listens there (yet)
                continue
            datagrams.append(datagram)
            if self._listens:
                self._stations.pop(sender, None)
                self._stations[sender] = None
                if len(self._stations) > _MOST_STATIONS:
                    del self._stations[next(iter(self._stations))]
        return datagrams

    def send(self, datagram: bytes) -> None:
        """Sends to the station, or to those that spoke last."""
        for station in list(self._stations) if self._listens else (None,):
            try:
                if station is None:
                    self._socket.send(datagram)
                else:
                    self._socket.sendto(datagram, station)
            except ConnectionRefusedError:
                pass
            except OSError:
                self.lost += 1

    def close(self) -> None:
        """Gives the port back; may be called twice."""
        self._socket.close()


class MavlinkGround:
    """A `ports.Ground` over MAVLink."""

    def __init__(self, links: Iterable[str], params: MavlinkParams, origin: Origin, actuators: Actuators) -> None:
        """Opens every link, or none.

        Raises:
            GroundError: a link is written wrongly or cannot be opened.
        """
        with contextlib.ExitStack() as opened:
            self.links = []
            for text in links:
                link = UdpLink(text)
                opened.callback(link.close)
                self.links.append(link)
            self._close = opened.pop_all().close
        self.node = Node(params, origin, actuators, [link.identity for link in self.links])

    def read(self, tick: Tick) -> Order:
        """What was asked since the last tick."""
        for i, link in enumerate(self.links):
            datagrams = link.receive()
            if datagrams:
                self.node.hear(tick, i, datagrams)
        return self.node.order()

    def write(self, cycle: Cycle) -> None:
        """Reports the cycle: at most one datagram per link and station."""
        for link, datagram in zip(self.links, self.node.report(cycle), strict=True):
            if datagram:
                link.send(datagram)

    def close(self) -> None:
        """Closes every link."""
        self._close()


class Grounds:
    """Several who give orders, as one `ports.Ground`; see `merge` for who is obeyed."""

    def __init__(self, *grounds: Ground) -> None:
        self._grounds = grounds

    def read(self, tick: Tick) -> Order:
        """What all of them asked."""
        return merge([ground.read(tick) for ground in self._grounds])

    def write(self, cycle: Cycle) -> None:
        """Shows the cycle to all of them."""
        for ground in self._grounds:
            ground.write(cycle)


def merge(orders: Sequence[Order]) -> Order:
    """One order of many: of each thing the last word holds, of sticks the latest; but who disarms is obeyed."""
    said = [order for order in orders if order is not NO_ORDER]
    if len(said) < 2:
        return said[0] if said else NO_ORDER
    arming, mode, setpoint, latest = Arming.KEEP, None, NO_ORDER.setpoint, said[0]
    for order in said:
        if order.arming is not Arming.KEEP and arming is not Arming.DISARM:
            arming = order.arming
        if order.mode is not None and mode is not Mode.DISARMED:
            mode = order.mode
        setpoint = Setpoint(
            *(old if math.isnan(new) else new for old, new in zip(setpoint, order.setpoint, strict=True))
        )
        if order.t_sticks >= latest.t_sticks:
            latest = order
    return Order(arming, mode, setpoint, latest.sticks, latest.t_sticks)
