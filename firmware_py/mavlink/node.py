"""The vehicle on all its links: one `Order` a tick from whoever spoke, and a datagram per link of each cycle."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from firmware_py.marine import Origin
from firmware_py.mavlink.base import protocol_version
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.identity import autopilot_version, heartbeat
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.modes import Identity, current_mode, modes_monitor
from firmware_py.mavlink.base.service import PersistentState
from firmware_py.mavlink.base.signing import Signing
from firmware_py.mavlink.commands.manual_control import ManualControlParams
from firmware_py.mavlink.commands.queue import CommandQueue
from firmware_py.mavlink.commands.setpoints import WaterFrame
from firmware_py.mavlink.files.ftp_server import FtpServer
from firmware_py.mavlink.files.log_transfer import LogTransfer
from firmware_py.mavlink.files.tree import FileTree, LogStorage
from firmware_py.mavlink.link import MAX_PARSED_PER_TICK, Link
from firmware_py.mavlink.parameters import metadata, transfer
from firmware_py.mavlink.parameters.transfer import Checker, ParameterStore, ParameterTransfer
from firmware_py.mavlink.plans import plan_builder
from firmware_py.mavlink.plans.plan_builder import PlanBuilder
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.mavlink.telemetry.health import Actuators, HealthTelemetry, NamedValues
from firmware_py.mavlink.telemetry.high_latency import HighLatency
from firmware_py.mavlink.telemetry.lateness import Lateness
from firmware_py.mavlink.telemetry.odometry import OdometryTelemetry
from firmware_py.mavlink.telemetry.pose import Encoder, PoseTelemetry, TelemetryParams
from firmware_py.mavlink.telemetry.system_state import SystemState
from firmware_py.mavlink.telemetry.time_sync import Calendar, TimeSync
from firmware_py.params import TakesEffect, param, table
from firmware_py.records.cycle import Cycle
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.order import Mode, Order
from firmware_py.schedule import Tick

STATE_FILES = (transfer.FILE, *plan_builder.FILES.values())
"""The names of all that `Node.saves` may ever give."""


@dataclass(frozen=True, slots=True)
class MavlinkParams:
    """Table [mavlink]."""

    system: int = param(
        1,
        low=1,
        high=250,
        doc="System id; every vehicle of a fleet has its own.",
        mav="MAV_SYSID",
        when=TakesEffect.RESTART,
    )
    telemetry: TelemetryParams = table(TelemetryParams)
    manual_control: ManualControlParams = table(ManualControlParams)


class Node:
    """Pure: hears datagrams, gives orders, reports cycles.

    Of orders each link's are obeyed alike, in the order in which they came; of sticks the last word holds.
    """

    def __init__(
        self,
        params: MavlinkParams,
        origin: Origin,
        actuators: Actuators,
        configurations: Sequence[LinkConfiguration],
        limits: OperatingLimits,
        coefficients: Sequence[str] = (),
        signing: Signing | None = None,
        parameter_store: ParameterStore | None = None,
        plans: Mapping[int, PlanBuilder] | None = None,
    ) -> None:
        """Make all links.

        Args:
            params: table [mavlink].
            origin: where the local frame touches the earth.
            actuators: what fins and propeller can do.
            configurations: one for each link.
            limits: what stations send is checked against them: no setpoint or mission may go beyond.
            coefficients: the names of what is learned, as the records order it.
            signing: with it, all links are signed.
            parameter_store: the parameters that stations may see and change; without it, none.
            plans: mission, fence and rally points, by their MAV_MISSION_TYPE.
        """
        self._queue = CommandQueue()
        self._system_state = SystemState()
        water_frame = WaterFrame(origin, params.telemetry.surface_altitude)
        self._plan_store = PlanStore(water_frame, limits, plans)
        self._lateness = Lateness()
        status = HealthTelemetry(actuators, self._lateness, self._plan_store)
        shared = PoseTelemetry(params.telemetry, origin, actuators.n_max).encoders() | status.encoders()
        shared |= OdometryTelemetry(water_frame.surface).encoders()
        calendar = Calendar()
        shared |= calendar.encoders()
        self.files: dict[str, Callable[[], bytes]] = (
            metadata.files(parameter_store) if parameter_store is not None else {}
        )
        """What may be fetched by MAVLink FTP: names without a slash in front, and who makes the bytes."""
        if parameter_store is not None:
            shared[metadata.MESSAGE_ID] = metadata.encoder(self.files)
        self.links = tuple(
            Link(
                *(i, configuration, params.system, params.manual_control, self._plan_store, self._queue),
                shared
                | NamedValues(coefficients).encoders()
                | self._link_encoders(configuration, water_frame, actuators.n_max),
                signing,
            )
            for i, configuration in enumerate(configurations)
        )
        self._persistent: list[PersistentState] = [self._plan_store] if signing is None else [self._plan_store, signing]
        if parameter_store is not None:
            self._serve_parameters(parameter_store, configurations)
        self._tree = FileTree(self.files)
        for link in self.links:
            link.add_service(FtpServer(self._tree, link))
            link.add_service(LogTransfer(self._tree, link, lambda: self._system_state.mode is not Mode.DISARMED))
            link.add_service(TimeSync(calendar, link))
            link.add_service(link.plan_upload)

    def receive_all(self, tick: Tick, said: Sequence[Sequence[bytes]]) -> None:
        """Takes what came since the last tick, by link.

        All of it together costs no more than HEARD_PER_TICK places: each link that speaks has its share of them, and
        whoever comes later what those before have left.
        """
        left, speaking = MAX_PARSED_PER_TICK, [i for i, datagrams in enumerate(said) if datagrams]
        for turn, i in enumerate(speaking):
            left -= self.links[i].receive(tick, said[i], left // (len(speaking) - turn))

    def receive(self, tick: Tick, link: int, datagrams: Sequence[bytes]) -> None:
        """Takes what came by a link since the last tick, in which no other speaks."""
        self.links[link].receive(tick, datagrams)

    def order(self) -> Order:
        """The order of this tick."""
        order = self._queue.next_order()
        changes = tuple([change for owner in self._persistent for change in owner.changes()])
        return replace(order, changes=changes) if changes else order

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """What is to be kept for the next start, since this was asked last: names of files, and their content."""
        return [save for owner in self._persistent for save in owner.files_to_save()]

    def report(self, cycle: Cycle) -> list[bytes]:
        """What each link has to say of a cycle; empty in most."""
        self._system_state.update(cycle)
        self._lateness.update(cycle)
        self._plan_store.update(cycle)
        if cycle.events:
            for link in self.links:
                link.send_events(cycle.events)
        for answer in self._queue.results(cycle):
            self.links[answer.pending.link].send_result(answer)
        return [link.report(cycle) for link in self.links]

    @property
    def end_request(self) -> str:
        """What a station asked for of a disarmed vehicle: "reboot" or "shutdown"; empty until then."""
        return self._queue.end_request

    @property
    def end_requester(self) -> str:
        """Which station that was, by system and component."""
        return self._queue.end_requester

    def set_limits(self, limits: OperatingLimits) -> None:
        """Check what stations send against these limits from now on."""
        self._plan_store.set_limits(limits)

    def offer_logs(self, log_storage: LogStorage) -> None:
        """From now on stations may fetch the logs of a shelf."""
        self._tree.log_storage = log_storage

    def allow_end(self) -> None:
        """From now on a station may ask a disarmed vehicle to end."""
        self._queue.end_allowed = True

    def _link_encoders(
        self, configuration: LinkConfiguration, water_frame: WaterFrame, n_max: float
    ) -> dict[int, Encoder]:
        identity, system_state = configuration.identity, self._system_state
        briefly = HighLatency(identity, water_frame.origin, water_frame.surface, n_max, system_state)
        return {
            dialect.MAVLINK_MSG_ID_HEARTBEAT: lambda cycle: heartbeat(identity, cycle.mode.mode, system_state.state),
            dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION: lambda _: autopilot_version(identity),
            protocol_version.MESSAGE_ID: lambda _: protocol_version.protocol_version(),
            dialect.MAVLINK_MSG_ID_CURRENT_MODE: lambda cycle: current_mode(
                identity, cycle.mode.mode, system_state.intended
            ),
            dialect.MAVLINK_MSG_ID_AVAILABLE_MODES_MONITOR: lambda _: modes_monitor(),
            dialect.MAVLINK_MSG_ID_MISSION_CURRENT: lambda cycle: self._plan_store.current(
                cycle, home=identity is Identity.ARDUSUB
            ),
            dialect.MAVLINK_MSG_ID_FENCE_STATUS: self._plan_store.fence_status,
            dialect.MAVLINK_MSG_ID_HIGH_LATENCY2: briefly.message,
        }

    def _serve_parameters(self, parameter_store: ParameterStore, configurations: Sequence[LinkConfiguration]) -> None:
        system_state = self._system_state
        self._persistent.append(parameter_store)
        parameter_store.subscribe_changes(self._parameter_changed)
        for link, configuration in zip(self.links, configurations, strict=True):
            link.add_service(
                ParameterTransfer(
                    parameter_store, link, configuration.identity, lambda: system_state.mode is not Mode.DISARMED
                )
            )

    def _parameter_changed(self, checker: Checker) -> None:
        self.set_limits(checker.limits)
        for link in self.links:
            link.set_manual_control(checker.manual_control)
