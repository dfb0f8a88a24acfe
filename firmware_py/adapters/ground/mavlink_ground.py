"""Stations on the ground: MAVLink over several links at once, beside whoever else gives orders."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from firmware_py.adapters.ground.station_link import GroundError, LinkSpec, StationLink, parse_link
from firmware_py.adapters.ground.stream_links import SerialLink, TcpClient, TcpServer
from firmware_py.adapters.ground.udp_link import UdpLink
from firmware_py.adapters.storage.disk_log_storage import DiskLogStorage
from firmware_py.adapters.storage.state_store import StateStore
from firmware_py.marine import Origin
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.signing import Signing
from firmware_py.mavlink.node import MavlinkParams, Node
from firmware_py.mavlink.parameters.transfer import ParameterStore
from firmware_py.mavlink.plans.plan_builder import PlanBuilder
from firmware_py.mavlink.telemetry.health import Actuators
from firmware_py.ports import Ground
from firmware_py.records.cycle import Cycle
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.order import NO_ORDER, NOBODY, Arming, Mode, Order, Setpoint
from firmware_py.schedule import Rate, Tick

__all__ = ["GroundError", "Grounds", "MavlinkGround", "open_link"]

_PRECEDENCE = (Arming.KEEP, Arming.CHECK, Arming.ARM, Arming.DISARM)
"""Of two words on arming the later in this list is obeyed."""
_LINK_CLASSES: dict[str, Callable[[LinkSpec], StationLink]] = {
    "udpout": UdpLink,
    "udpin": UdpLink,
    "tcp": TcpClient,
    "tcpin": TcpServer,
    "serial": SerialLink,
}


def open_link(text: str) -> StationLink:
    """Opens a link; `stations.parse_link` tells how it is written.

    Raises:
        GroundError: it is written wrongly or cannot be opened.
    """
    spec = parse_link(text)
    return _LINK_CLASSES[spec.kind](spec)


class MavlinkGround:
    """A `ports.Ground` over MAVLink."""

    def __init__(
        self,
        links: Iterable[str],
        params: MavlinkParams,
        origin: Origin,
        actuators: Actuators,
        limits: OperatingLimits,
        coefficients: Sequence[str] = (),
        signing: Signing | None = None,
        parameter_store: ParameterStore | None = None,
        plans: Mapping[int, PlanBuilder] | None = None,
    ) -> None:
        """Opens every link, or none; `coefficients` are the names of what is learned, with `signing` links are signed.

        What stations send is checked against `limits`.
        `book` has the parameters that stations may see and change, `plans` mission, fence and rally points.

        Raises:
            GroundError: a link is written wrongly or cannot be opened.
        """
        with contextlib.ExitStack() as opened:
            self.links: list[StationLink] = []
            for text in links:
                link = open_link(text)
                opened.callback(link.close)
                self.links.append(link)
            self._close = opened.pop_all().close
        configurations = [link.configuration for link in self.links]
        self.node = Node(
            params, origin, actuators, configurations, limits, coefficients, signing, parameter_store, plans
        )
        self._state_store: StateStore | None = None
        self._log_store: DiskLogStorage | None = None

    def read(self, tick: Tick) -> Order:
        """What was asked since the last tick."""
        self.node.receive_all(tick, [link.receive() for link in self.links])
        return self.node.order()

    def write(self, cycle: Cycle) -> None:
        """Reports the cycle: at most one datagram per link and station."""
        for link, datagram in zip(self.links, self.node.report(cycle), strict=True):
            if datagram:
                link.send(datagram)
        if cycle.tick.every(Rate.HZ_1):
            self._count()
        if self._state_store is not None:
            self._save_changes(self._state_store, cycle.tick)

    def losses(self) -> dict[str, int]:
        """What each link has lost or refused, by cause; they are counted from 1, as they were given."""
        self._count()
        return {
            f"gcs_{i}_{cause}": count
            for i, (link, transport) in enumerate(zip(self.node.links, self.links, strict=True), 1)
            for cause, count in {**link.losses, "not_sent": transport.lost}.items()
        }

    def save_changes_in(self, folder: Path) -> None:
        """From now on what stations change is kept in a folder, for the next start.

        Raises:
            StateStoreError: it cannot be written.
        """
        self._state_store = StateStore(folder)

    def offer_logs(self, folder: Path, beside: bool) -> None:
        """From now on stations may fetch the log of a run's folder, and with `beside` those beside it too."""
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
                for link in self.node.links:
                    link.send_text(error, dialect.MAV_SEVERITY_CRITICAL)

    def close(self) -> None:
        """Closes every link, once all is kept."""
        if self._state_store is not None:
            self._state_store.close()
        if self._log_store is not None:
            self._log_store.close()
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
    """One order of many: of each thing the last word holds, of sticks the latest; but who disarms is obeyed.

    What is changed for good is changed by all of them, in their order. The asker is whose word on arming or mode holds,
    or else the last who asked for anything.
    """
    given = [order for order in orders if order is not NO_ORDER]
    if len(given) < 2:
        return given[0] if given else NO_ORDER
    arming, mode, setpoint, latest, jump = Arming.KEEP, None, NO_ORDER.setpoint, given[0], NO_ORDER.jump
    changes = NO_ORDER.changes
    for order in given:
        arming = max(arming, order.arming, key=_PRECEDENCE.index)
        if order.mode is not None and mode is not Mode.DISARMED:
            mode = order.mode
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
    return Order(arming, mode, setpoint, latest.sticks, latest.t_sticks, jump, asker, changes)
