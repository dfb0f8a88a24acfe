"""Ground stations: MAVLink over several links at once, merged with other sources of orders."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from firmware_py.adapters.ground.awaited_link import AwaitedLink
from firmware_py.adapters.ground.station_link import GroundError, LinkAbsentError, LinkSpec, StationLink, parse_link
from firmware_py.adapters.ground.stream_links import SerialLink, TcpClient, TcpServer
from firmware_py.adapters.ground.udp_link import UdpLink
from firmware_py.adapters.storage.disk_log_storage import DiskLogStorage
from firmware_py.adapters.storage.state_store import StateStore
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.node import NOTHING_SAVED, Node, NodeSettings, SharedState, VehicleDescription
from firmware_py.ports import Ground
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import NO_ORDER, NOBODY, Arming, Mode, Order, Setpoint
from firmware_py.tick import Rate, Tick

__all__ = ["GroundError", "Grounds", "MavlinkGround", "open_link"]

_PRECEDENCE = (Arming.KEEP, Arming.CHECK, Arming.ARM, Arming.DISARM, Arming.FORCE_DISARM)
"""Of two demands on arming, the later in this list wins."""
_LINK_CLASSES: dict[str, Callable[[LinkSpec], StationLink]] = {
    "udpout": UdpLink,
    "udpin": UdpLink,
    "tcp": TcpClient,
    "tcpin": TcpServer,
    "serial": SerialLink,
}


def open_link(text: str, *, absent: bool = False) -> StationLink:
    """Open a link; see `station_link.parse_link` for its syntax.

    Args:
        text: as the command line has it.
        absent: whether one that may be there later is opened then, and is no error.

    Raises:
        GroundError: it has wrong syntax or cannot be opened.
    """
    spec = parse_link(text)
    try:
        return _LINK_CLASSES[spec.kind](spec)
    except LinkAbsentError as error:
        if not absent:
            raise
        return AwaitedLink(spec, _LINK_CLASSES[spec.kind], error)


class MavlinkGround:
    """A `ports.Ground` over MAVLink."""

    def __init__(
        self,
        links: Iterable[str],
        settings: NodeSettings,
        vehicle: VehicleDescription,
        state: SharedState = NOTHING_SAVED,
        *,
        absent: bool = False,
    ) -> None:
        """Open every link, or none; with `absent` those that are not there yet later.

        Raises:
            GroundError: a link has wrong syntax or cannot be opened.
        """
        with contextlib.ExitStack() as opened:
            self.links: list[StationLink] = []
            for text in links:
                link = open_link(text, absent=absent)
                opened.callback(link.close)
                self.links.append(link)
            self._close = opened.pop_all().close
        configurations = [link.configuration for link in self.links]
        self.node = Node(settings, vehicle, configurations, state)
        self._state_store: StateStore | None = None
        self._say_aboard: Callable[[str], None] | None = None
        self._log_store: DiskLogStorage | None = None

    def read(self, tick: Tick) -> Order:
        """Return what stations asked for since the last tick."""
        self.node.receive(tick, [link.receive() for link in self.links])
        return self.node.order()

    def write(self, cycle: Cycle) -> None:
        """Report the cycle: at most one datagram per link and station."""
        for link, datagram in zip(self.links, self.node.report(cycle), strict=True):
            if datagram:
                link.send(datagram)
        if cycle.tick.every(Rate.HZ_1):
            self._count()
        if self._state_store is not None:
            self._save_changes(self._state_store, cycle.tick)

    def losses(self) -> dict[str, int]:
        """Return what each link has lost or refused, by cause; links count from 1, in the order given."""
        self._count()
        return {
            f"gcs_{i}_{cause}": count
            for i, (link, transport) in enumerate(zip(self.node.links, self.links, strict=True), 1)
            for cause, count in {**link.losses, "not_sent": transport.lost}.items()
        }

    def count(self, lost: Mapping[str, int], received: int) -> None:
        """Tell stations what was lost, by source and cause, and how many messages have arrived on the bus."""
        self.node.communication.update(lost, received)

    @property
    def awaited(self) -> list[AwaitedLink]:
        """Return the links that were not there at the start."""
        return [link for link in self.links if isinstance(link, AwaitedLink)]

    def save_changes_in(self, folder: Path, say: Callable[[str], None] | None = None) -> None:
        """Save what stations change, and what `save` is given, in a folder, for the next start.

        Args:
            folder: is made if it is missing.
            say: is told what cannot be written, as stations are.

        Raises:
            StateStoreError: it cannot be written.
        """
        self._state_store, self._say_aboard = StateStore(folder), say

    def save(self, name: str, content: bytes) -> None:
        """Save a file for the next start, after `save_changes_in`; return at once."""
        if self._state_store is not None:
            self._state_store.save(name, content)

    def say(self, text: str, severity: int = dialect.MAV_SEVERITY_WARNING) -> None:
        """Send a sentence to all stations."""
        for link in self.node.links:
            link.send_text(text, severity)

    def offer_logs(self, folder: Path, beside: bool) -> None:
        """Offer stations the log of a run's folder, and with `beside` those of the neighbouring folders."""
        self._log_store = DiskLogStorage(folder, beside)
        self.node.offer_logs(self._log_store)

    def _count(self) -> None:
        for link, transport in zip(self.node.links, self.links, strict=True):
            link.overrun = transport.overrun

    def _save_changes(self, store: StateStore, tick: Tick) -> None:
        for name, content in self.node.files_to_save():
            store.save(name, content)
        store.work()
        if tick.every(Rate.HZ_1):
            for error in store.errors():
                self.say(error, dialect.MAV_SEVERITY_CRITICAL)
                if self._say_aboard:
                    self._say_aboard(error)

    def close(self) -> None:
        """Close every link after everything is saved."""
        if self._state_store is not None:
            self._state_store.close()
        if self._log_store is not None:
            self._log_store.close()
        self._close()


class Grounds:
    """Several sources of orders as one `ports.Ground`; see `merge_orders`."""

    def __init__(self, *grounds: Ground) -> None:
        self._grounds = grounds

    def read(self, tick: Tick) -> Order:
        """Return the merged order of all."""
        return merge_orders([ground.read(tick) for ground in self._grounds])

    def write(self, cycle: Cycle) -> None:
        """Report the cycle to all."""
        for ground in self._grounds:
            ground.write(cycle)


def merge_orders(orders: Sequence[Order]) -> Order:
    """Return one order of many: the last value of each field, the latest times; a demand to disarm always wins.

    Permanent changes are all kept, in order. The asker is the source of the arming or mode demand that won, or else the
    last source that asked for anything.
    """
    given = [order for order in orders if order is not NO_ORDER]
    if len(given) < 2:
        return given[0] if given else NO_ORDER
    arming, mode, setpoint, latest, jump = Arming.KEEP, None, NO_ORDER.setpoint, given[0], NO_ORDER.jump
    changes, chooses = NO_ORDER.changes, NO_ORDER.chooses
    for order in given:
        arming = max(arming, order.arming, key=_PRECEDENCE.index)
        if order.mode is not None and mode is not Mode.DISARMED:
            mode, chooses = order.mode, order.chooses
        setpoint = Setpoint(
            *(old if math.isnan(new) else new for old, new in zip(setpoint, order.setpoint, strict=True))
        )
        if order.t_sticks >= latest.t_sticks:
            latest = order
        if order.jump != NO_ORDER.jump:
            jump = order.jump
        changes += order.changes
    decisive = (
        [order for order in given if order.arming is arming is not Arming.KEEP]
        or [order for order in given if order.mode is mode is not None]
        or [order for order in given if order.asker != NOBODY]
    )
    asker = decisive[-1].asker if decisive else NOBODY
    sticks, t_station = (latest.sticks, latest.t_sticks), max(order.t_station for order in given)
    terminate, release = any(order.terminate for order in given), any(order.release for order in given)
    return Order(arming, mode, setpoint, *sticks, jump, asker, t_station, terminate, release, chooses, changes)
