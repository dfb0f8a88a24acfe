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

    Raises:
        GroundError: it cannot be opened.
    """

    def __init__(self, spec: LinkSpec) -> None:
        self.configuration = spec.configuration
        self._is_server = spec.kind == "udpin"
        self._stations: dict[Address, None] = {}  # in the order in which they were last heard
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self.lost = 0
        """Datagrams that the network did not accept."""
        self._overrun = 0
        try:
            if self._is_server:
                self._socket.bind(spec.address)
            else:
                self._socket.connect(spec.address)
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
            except OSError:  # ICMP answer to a datagram sent: nobody listens there (yet)
                continue
            datagrams.append(datagram)
            if self._is_server:
                self._stations.pop(sender, None)
                self._stations[sender] = None
                if len(self._stations) > _MAX_STATIONS:
                    del self._stations[next(iter(self._stations))]
        return datagrams

    def send(self, datagram: bytes) -> None:
        """Send to the station, or to those heard last."""
        for station in list(self._stations) if self._is_server else (None,):
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
        """Close the port; may be called twice."""
        self._overrun = self.overrun
        self._socket.close()
