"""The vehicle on all its links: one `Order` a tick from whoever spoke, and a datagram per link of each cycle."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from firmware_py.marine import Origin
from firmware_py.mavlink.base import protocol_version
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.identity import autopilot_version, heartbeat
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.modes import Identity, current_mode, modes_monitor
from firmware_py.mavlink.base.service import Keeper
from firmware_py.mavlink.base.signing import Signing
from firmware_py.mavlink.base.statustext import severity
from firmware_py.mavlink.commands.manual_control import ManualControlParams
from firmware_py.mavlink.commands.queue import CommandQueue
from firmware_py.mavlink.commands.setpoints import WaterFrame
from firmware_py.mavlink.files.ftp_server import FtpServer
from firmware_py.mavlink.files.log_transfer import LogTransfer
from firmware_py.mavlink.files.tree import FileTree, LogStorage
from firmware_py.mavlink.link import HEARD_PER_TICK, Link
from firmware_py.mavlink.parameters import metadata, transfer
from firmware_py.mavlink.parameters.transfer import ParameterStore, ParameterTransfer
from firmware_py.mavlink.plans import plan_builder
from firmware_py.mavlink.plans.plan_builder import PlanBuilder
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.mavlink.plans.upload import PlanUpload
from firmware_py.mavlink.telemetry.health import Actuators, HealthTelemetry, NamedValues
from firmware_py.mavlink.telemetry.high_latency import HighLatency
from firmware_py.mavlink.telemetry.lateness import Lateness
from firmware_py.mavlink.telemetry.navigation_target import NavigationTarget
from firmware_py.mavlink.telemetry.odometry import OdometryTelemetry
from firmware_py.mavlink.telemetry.pose import Maker, PoseTelemetry, TelemetryParams
from firmware_py.mavlink.telemetry.system_state import SystemState
from firmware_py.mavlink.telemetry.time_sync import Calendar, TimeSync
from firmware_py.param_tree import replaced
from firmware_py.params import When, param, table
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode, Order
from firmware_py.records.turning import Turning
from firmware_py.schedule import Tick

KEPT = (transfer.FILE, *plan_builder.FILES.values())
"""The names of all that `Node.saves` may ever give."""
_TURNING = {
    "guidance.loiter_radius_m": ("loiter_radius", 1.0),
    "guidance.turn_radius_m": ("turn_radius", 1.0),
    "guidance.turn_rate_max_deg_s": ("turn_rate_max", math.radians(1.0)),
    "guidance.cruise_speed_m_s": ("cruise_speed", 1.0),
    "guidance.speed_max_m_s": ("speed_max", 1.0),
}
"""Which parameter is what of `Turning`, and its unit in SI."""


@dataclass(frozen=True, slots=True)
class MavlinkParams:
    """Table [mavlink]."""

    system: int = param(
        1, low=1, high=250, doc="System id; every vehicle of a fleet has its own.", mav="MAV_SYSID", when=When.RESTART
    )
    telemetry: TelemetryParams = table(TelemetryParams)
    helm: ManualControlParams = table(ManualControlParams)


class Node:
    """Pure: hears datagrams, gives orders, reports cycles.

    Of orders each link's are obeyed alike, in the order in which they came; of sticks the last word holds.
    """

    def __init__(
        self,
        params: MavlinkParams,
        origin: Origin,
        actuators: Actuators,
        doors: Sequence[LinkConfiguration],
        coefficients: Sequence[str] = (),
        signing: Signing | None = None,
        book: ParameterStore | None = None,
        plans: Mapping[int, PlanBuilder] | None = None,
    ) -> None:
        """`doors` has one for each link, `coefficients` the names of what is learned, as the records order it.

        With `signing`, all links are signed. `book` has the parameters, `plans` mission, fence and rally points.
        """
        self._params = params
        self._orders = CommandQueue()
        self._standing = SystemState()
        sea = WaterFrame(origin, params.telemetry.surface_altitude)
        self._chart = PlanStore(sea, plans)
        self._aim = NavigationTarget(self._chart)
        self._late = Lateness()
        status = HealthTelemetry(actuators, self._late, self._chart)
        shared = PoseTelemetry(params.telemetry, origin, actuators.n_max).makers() | status.makers()
        shared |= OdometryTelemetry(sea.surface, self._aim).makers()
        calendar = Calendar()
        shared |= calendar.makers()
        self.files: dict[str, Callable[[], bytes]] = metadata.files(book) if book is not None else {}
        """What may be fetched by MAVLink FTP: names without a slash in front, and who makes the bytes."""
        if book is not None:
            shared[metadata.MESSAGE_ID] = metadata.maker(self.files)
        self.links = tuple(
            Link(
                *(i, door, params.system, params.helm, sea, self._orders),
                shared | NamedValues(coefficients).makers() | self._introduces(door, sea, actuators.n_max),
                signing,
            )
            for i, door in enumerate(doors)
        )
        self._keepers: list[Keeper] = [self._chart] if signing is None else [self._chart, signing]
        if book is not None:
            self._serve_parameters(book, doors)
        self._tree = FileTree(self.files)
        for link in self.links:
            link.serve(FtpServer(self._tree, link))
            link.serve(LogTransfer(self._tree, link, lambda: self._standing.mode is not Mode.DISARMED))
            link.serve(TimeSync(calendar, link))
        for i, (link, door) in enumerate(zip(self.links, doors, strict=True)):
            missions = PlanUpload(i, self._chart, link, self._orders, door.identity)
            link.serve(missions)
            link.learn(missions.does(), missions.objection)
            link.setpoints.objection = self._chart.guided

    def listen(self, tick: Tick, said: Sequence[Sequence[bytes]]) -> None:
        """Takes what came since the last tick, by link.

        All of it together costs no more than HEARD_PER_TICK places: each link that speaks has its share of them, and
        whoever comes later what those before have left.
        """
        left, speaking = HEARD_PER_TICK, [i for i, datagrams in enumerate(said) if datagrams]
        for turn, i in enumerate(speaking):
            left -= self.links[i].hear(tick, said[i], left // (len(speaking) - turn))

    def hear(self, tick: Tick, link: int, datagrams: Sequence[bytes]) -> None:
        """Takes what came by a link since the last tick, in which no other speaks."""
        self.links[link].hear(tick, datagrams)

    def order(self) -> Order:
        """The order of this tick."""
        order = self._orders.next()
        changes = tuple([change for keeper in self._keepers for change in keeper.changes()])
        return replace(order, changes=changes) if changes else order

    def saves(self) -> list[tuple[str, bytes]]:
        """What is to be kept for the next start, since this was asked last: names of files, and their content."""
        return [save for keeper in self._keepers for save in keeper.saves()]

    def report(self, cycle: Cycle) -> list[bytes]:
        """What each link has to say of a cycle; empty in most."""
        self._standing.watch(cycle)
        self._late.watch(cycle)
        self._chart.watch(cycle)
        self._aim.watch(cycle)
        for event in cycle.events:
            matters = severity(event)
            for link in self.links:
                link.announce(event, matters)
        for answer in self._orders.judge(cycle):
            self.links[answer.wish.link].answer(answer)
        return [link.report(cycle) for link in self.links]

    @property
    def ending(self) -> str:
        """What a station asked for of a disarmed vehicle: "reboot" or "shutdown"; empty until then."""
        return self._orders.ending

    @property
    def ender(self) -> str:
        """Which station that was, by system and component."""
        return self._orders.ender

    def limit(self, depth_max: float, altitude_min: float | None = None, turning: Turning | None = None) -> None:
        """The supervisor's limits, m: stations are told that no setpoint or mission may go beyond.

        `turning` says how wide a mission's circles will be.
        """
        self._chart.limit(depth_max, altitude_min)
        if turning is not None:
            self._chart.turn(**turning._asdict())
        for link in self.links:
            link.setpoints.depth_max = depth_max

    def shelve(self, shelf: LogStorage) -> None:
        """From now on stations may fetch the logs of a shelf."""
        self._tree.shelf = shelf

    def may_end(self) -> None:
        """From now on a station may ask a disarmed vehicle to end."""
        self._orders.may_end = True

    def _introduces(self, door: LinkConfiguration, sea: WaterFrame, n_max: float) -> dict[int, Maker]:
        identity, standing = door.identity, self._standing
        briefly = HighLatency(identity, sea.origin, sea.surface, n_max, standing, self._aim)
        return {
            dialect.MAVLINK_MSG_ID_HEARTBEAT: lambda cycle: heartbeat(identity, cycle.mode.mode, standing.state),
            dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION: lambda _: autopilot_version(identity),
            protocol_version.MESSAGE_ID: lambda _: protocol_version.protocol_version(),
            dialect.MAVLINK_MSG_ID_CURRENT_MODE: lambda cycle: current_mode(
                identity, cycle.mode.mode, standing.intended
            ),
            dialect.MAVLINK_MSG_ID_AVAILABLE_MODES_MONITOR: lambda _: modes_monitor(),
            dialect.MAVLINK_MSG_ID_MISSION_CURRENT: lambda cycle: self._chart.current(
                cycle, home=identity is Identity.ARDUSUB
            ),
            dialect.MAVLINK_MSG_ID_FENCE_STATUS: self._chart.fence_status,
            dialect.MAVLINK_MSG_ID_HIGH_LATENCY2: briefly.message,
        }

    def _serve_parameters(self, book: ParameterStore, doors: Sequence[LinkConfiguration]) -> None:
        standing = self._standing
        self._keepers.append(book)
        book.watch(self._take)
        for link, door in zip(self.links, doors, strict=True):
            link.serve(ParameterTransfer(book, link, door.identity, lambda: standing.mode is not Mode.DISARMED))

    def _take(self, key: str, value: Any) -> None:
        """Of what stations change, that which is ours."""
        table, _, rest = key.partition(".")
        if key == "safety.depth_max_m":
            self.limit(value)
        if key == "safety.altitude_min_m":
            self._chart.limit(altitude_min=value)
        if key in _TURNING:
            name, unit = _TURNING[key]
            self._chart.turn(**{name: value * unit})
        if table == "mavlink":
            self._params = replaced(self._params, {rest: value}, table)
            for link in self.links:
                link.steer_by(self._params.helm)
