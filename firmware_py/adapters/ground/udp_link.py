"""Links over UDP: to one station, or to those that have sent something."""

from __future__ import annotations

import socket

from firmware_py.adapters.buses import receive_buffer
from firmware_py.adapters.ground.station_link import Address, LinkSpec

DATAGRAMS_PER_TICK = 16
_DATAGRAM_BYTES = 2048
_MAX_STATIONS = 4


class UdpLink:
    """A `StationLink` over UDP.

    Its socket is not connected, for that would keep the address which the vehicle had then: of a network that came up
    later, or gave another address, nothing would be sent or heard.

    Raises:
        GroundError: it cannot be opened.
    """

    def __init__(self, spec: LinkSpec) -> None:
        self.configuration = spec.configuration
        self._is_server = spec.kind == "udpin"
        self._stations: dict[Address, None] = {}
        """Those that are sent to, in the order in which they were last heard; with udpout always the one."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self.lost = 0
        """Datagrams that the network did not accept."""
        self._overrun = 0
        try:
            if self._is_server:
                self._socket.bind(spec.address)
            else:
                self._stations[_reachable(spec.address)] = None
                self._socket.bind(("", 0))
        except OSError as error:
            self._socket.close()
            raise spec.error(error) from None

    @property
    def address(self) -> Address:
        """The address of this end of the link."""
        host, port = self._socket.getsockname()
        return host, port

    @property
    def overrun(self) -> int:
        """See `StationLink`; after closing, the last count."""
        if self._socket.fileno() >= 0:
            self._overrun = receive_buffer.overrun(self._socket)
        return self._overrun

    def fileno(self) -> int:
        """Return the socket."""
        return self._socket.fileno()

    def receive(self) -> list[bytes]:
        """Return the datagrams received, oldest first, up to DATAGRAMS_PER_TICK; the rest waits in the kernel."""
        datagrams = []
        for _ in range(DATAGRAMS_PER_TICK):
            try:
                datagram, sender = self._socket.recvfrom(_DATAGRAM_BYTES)
            except BlockingIOError:
                break
            except OSError:
                continue
            if self._is_server:
                self._stations.pop(sender, None)
                self._stations[sender] = None
                if len(self._stations) > _MAX_STATIONS:
                    del self._stations[next(iter(self._stations))]
            elif sender not in self._stations:
                continue
            datagrams.append(datagram)
        return datagrams

    def send(self, datagram: bytes) -> None:
        """Send to the station, or to those heard last."""
        for station in self._stations:
            try:
                self._socket.sendto(datagram, station)
            except OSError:
                self.lost += 1

    def close(self) -> None:
        """Close the port; may be called twice."""
        self._overrun = self.overrun
        self._socket.close()


def _reachable(address: Address) -> Address:
    """Return an address with its host in numbers: a name is looked up once, and not in flight.

    Raises:
        OSError: there is no such host, or no way to it yet.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(address)
        host, port = probe.getpeername()
        return host, port
