"""The vehicle on all its links: one `Order` a tick from whoever spoke, and a datagram per link of each cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from firmware_py.marine import Origin
from firmware_py.mavlink.codec import dialect
from firmware_py.mavlink.helm import HelmParams
from firmware_py.mavlink.identity import Identity, autopilot_version, heartbeat
from firmware_py.mavlink.lateness import Lateness
from firmware_py.mavlink.link import Link
from firmware_py.mavlink.orders import Orders
from firmware_py.mavlink.status import Actuators, Status
from firmware_py.mavlink.telemetry import Maker, Telemetry, TelemetryParams
from firmware_py.mavlink.texts import severity
from firmware_py.params import param
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode, Order
from firmware_py.schedule import Tick


@dataclass(frozen=True, slots=True)
class MavlinkParams:
    """Table [mavlink]."""

    system: int = param(1, low=1, high=250, doc="System id; every vehicle of a fleet has its own.", mav="MAV_SYSID")
    telemetry: TelemetryParams = field(default_factory=TelemetryParams)
    helm: HelmParams = field(default_factory=HelmParams)


class Node:
    """Pure: hears datagrams, gives orders, reports cycles.

    Of orders each link's are obeyed alike, in the order in which they came; of sticks the last word holds.
    """

    def __init__(
        self, params: MavlinkParams, origin: Origin, actuators: Actuators, identities: Sequence[Identity]
    ) -> None:
        self._orders = Orders()
        self._mode = Mode.DISARMED
        self._failsafe = False
        self._late = Lateness()
        status = Status(actuators, self._late)
        shared = Telemetry(params.telemetry, origin, actuators.n_max).makers() | status.makers()
        self.links = tuple(
            Link(i, params.system, params.helm, self._orders, shared | self._introduces(identity))
            for i, identity in enumerate(identities)
        )

    def hear(self, tick: Tick, link: int, datagrams: Sequence[bytes]) -> None:
        """Takes what came by a link since the last tick."""
        self.links[link].hear(tick, datagrams)

    def order(self) -> Order:
        """The order of this tick."""
        return self._orders.next()

    def report(self, cycle: Cycle) -> list[bytes]:
        """What each link has to say of a cycle; empty in most."""
        self._watch(cycle)
        self._late.watch(cycle)
        for event in cycle.events:
            matters = severity(event)
            for link in self.links:
                link.tell(event, matters)
        for wish, result in self._orders.judge(cycle.mode.mode, cycle.tick.t_ns):
            self.links[wish.link].answer(wish, result)
        return [link.report(cycle) for link in self.links]

    def _introduces(self, identity: Identity) -> dict[int, Maker]:
        return {
            dialect.MAVLINK_MSG_ID_HEARTBEAT: lambda cycle: heartbeat(identity, cycle.mode.mode, self._failsafe),
            dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION: lambda _: autopilot_version(identity),
        }

    def _watch(self, cycle: Cycle) -> None:
        """It is a failsafe that surfaces, unless someone ordered it or the mission was done."""
        mode = cycle.mode.mode
        if mode is not self._mode:
            done = self._mode is Mode.MISSION and cycle.mode.mission_done
            self._failsafe = mode is Mode.SURFACE and cycle.order.mode is not Mode.SURFACE and not done
            self._mode = mode
