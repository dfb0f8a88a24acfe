"""The vehicle on all its links: one `Order` a tick from the stations, and a datagram per link of each cycle."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from firmware_py.marine import Origin
from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.identity import autopilot_version, heartbeat, protocol_version
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.message_definitions import PROTOCOL_VERSION
from firmware_py.mavlink.base.modes import Identity, current_mode, modes_monitor, shown_mode
from firmware_py.mavlink.base.service import PersistentState
from firmware_py.mavlink.base.signing import Signing
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.commands.queue import CommandQueue
from firmware_py.mavlink.files.ftp_server import FtpServer
from firmware_py.mavlink.files.log_transfer import LogTransfer
from firmware_py.mavlink.files.tree import FileTree, LogStorage
from firmware_py.mavlink.link import MAX_PARSED_PER_TICK, Link, Shared
from firmware_py.mavlink.parameters import metadata, store
from firmware_py.mavlink.parameters.store import ParameterStore
from firmware_py.mavlink.parameters.transfer import ParameterTransfer
from firmware_py.mavlink.plans import plan_builder
from firmware_py.mavlink.plans.plan_builder import PlanBuilder
from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.mavlink.settings import MavlinkParams, NodeSettings
from firmware_py.mavlink.telemetry.communication import Communication
from firmware_py.mavlink.telemetry.health import Actuators, HealthTelemetry, NamedValues
from firmware_py.mavlink.telemetry.high_latency import HighLatency
from firmware_py.mavlink.telemetry.lateness import Lateness
from firmware_py.mavlink.telemetry.odometry import OdometryTelemetry
from firmware_py.mavlink.telemetry.pose import Encoder, PoseTelemetry
from firmware_py.mavlink.telemetry.system_state import SystemState
from firmware_py.mavlink.telemetry.time_sync import Calendar, TimeSync
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode, Order
from firmware_py.tick import Tick

__all__ = ["MavlinkParams", "Node", "NodeSettings", "SharedState", "VehicleDescription"]

STATE_FILES = (store.FILE, *plan_builder.FILES.values())
"""The names of all files that `Node.files_to_save` may return."""


class VehicleDescription(NamedTuple):
    """What a node must know of the vehicle: the local frame's origin, the actuators, and the names of the coefficients.

    `coefficients` are those that are estimated, in the order of the records; empty if none are. `drop_weight` says
    whether there is one.
    """

    origin: Origin
    actuators: Actuators
    coefficients: Sequence[str] = ()
    drop_weight: bool = False


class SharedState(NamedTuple):
    """What outlives a start: the signing key (with it all links are signed), the parameters, and the plans."""

    signing: Signing | None = None
    parameters: ParameterStore | None = None
    plans: Mapping[int, PlanBuilder] | None = None


NOTHING_SAVED = SharedState()


class Node:
    """Takes datagrams, gives orders and reports cycles, without clock or socket.

    Commands of all links are executed alike, in the order in which they came; of manual control the latest holds.
    """

    def __init__(
        self,
        settings: NodeSettings,
        vehicle: VehicleDescription,
        configurations: Sequence[LinkConfiguration],
        state: SharedState = NOTHING_SAVED,
    ) -> None:
        """`configurations` has one entry for each link."""
        params, parameters = settings.params, state.parameters
        self._queue = CommandQueue()
        self._system_state = SystemState()
        water_frame = WaterFrame(vehicle.origin, params.telemetry.surface_altitude)
        self._plan_store = PlanStore(water_frame, settings.limits, state.plans)
        self._lateness = Lateness()
        self.communication = Communication()
        calendar = Calendar()
        self.files: dict[str, Callable[[], bytes]] = {} if parameters is None else metadata.files(parameters)
        """The generated files that MAVLink FTP offers: names without a leading slash, and who makes the bytes."""
        encoders = PoseTelemetry(params.telemetry, vehicle.origin, vehicle.actuators.n_max).encoders()
        encoders |= HealthTelemetry(vehicle.actuators, self._lateness, self._plan_store, self.communication).encoders()
        encoders |= OdometryTelemetry(water_frame.surface).encoders() | calendar.encoders()
        if parameters is not None:
            encoders[metadata.MESSAGE_ID] = metadata.encoder(self.files)
        shared = Shared(params.system, self._queue, self._plan_store, state.signing, vehicle.drop_weight)
        self.links = tuple(
            Link(
                *(i, configuration, shared, params.manual_control),
                encoders | NamedValues(vehicle.coefficients).encoders() | self._link_encoders(configuration, vehicle),
            )
            for i, configuration in enumerate(configurations)
        )
        self._persistent: list[PersistentState] = [self._plan_store]
        self._tree = FileTree(self.files)
        if state.signing is not None:
            self._persistent.append(state.signing)
        if parameters is not None:
            self._persistent.append(parameters)
            parameters.subscribe_changes(self._settings_changed)
        for link, configuration in zip(self.links, configurations, strict=True):
            if parameters is not None:
                link.add_service(ParameterTransfer(parameters, link, configuration.identity, self._armed))
            link.add_service(FtpServer(self._tree, link))
            link.add_service(LogTransfer(self._tree, link, self._armed))
            link.add_service(TimeSync(calendar, link))
            link.add_service(link.plan_upload)

    def receive(self, tick: Tick, datagrams: Sequence[Sequence[bytes]]) -> None:
        """Handle the datagrams received since the last tick, by link.

        Together they cost at most MAX_PARSED_PER_TICK parse attempts: each link that received something has its share,
        and later links also what earlier ones have left.
        """
        left, active = MAX_PARSED_PER_TICK, [i for i, received in enumerate(datagrams) if received]
        for done, i in enumerate(active):
            left -= self.links[i].receive(tick, datagrams[i], left // (len(active) - done))

    def order(self) -> Order:
        """Return the order of this tick."""
        order = self._queue.next_order()
        changes = tuple([change for state in self._persistent for change in state.changes()])
        return replace(order, changes=changes) if changes else order

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """Return the files to save for the next start, since the last call: name and content."""
        return [file for state in self._persistent for file in state.files_to_save()]

    def report(self, cycle: Cycle) -> list[bytes]:
        """Return the datagram of each link for a cycle; most are empty."""
        self._system_state.update(cycle)
        self._lateness.update(cycle)
        self._plan_store.update(cycle)
        if cycle.events:
            for link in self.links:
                link.send_events(cycle.events)
        for result in self._queue.results(cycle):
            self.links[result.pending.link].send_result(result)
        return [link.report(cycle) for link in self.links]

    @property
    def end_request(self) -> str:
        """What a station asked of a disarmed vehicle: "reboot" or "shutdown"; empty until then."""
        return self._queue.end_request

    @property
    def end_requester(self) -> str:
        """The station that asked, by system and component."""
        return self._queue.end_requester

    def offer_logs(self, log_storage: LogStorage) -> None:
        """Offer stations the logs of a storage."""
        self._tree.log_storage = log_storage

    def allow_end(self) -> None:
        """Let stations ask a disarmed vehicle to reboot or shut down."""
        self._queue.end_allowed = True

    def _armed(self) -> bool:
        return self._system_state.mode is not Mode.DISARMED

    def _link_encoders(self, configuration: LinkConfiguration, vehicle: VehicleDescription) -> dict[int, Encoder]:
        identity, state, plans = configuration.identity, self._system_state, self._plan_store
        high_latency = HighLatency(identity, vehicle.origin, vehicle.actuators.n_max, state, plans)
        return {
            dialect.MAVLINK_MSG_ID_HEARTBEAT: lambda cycle: heartbeat(identity, cycle.mode, state.state),
            dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION: lambda _: autopilot_version(identity),
            PROTOCOL_VERSION.id: lambda _: protocol_version(),
            dialect.MAVLINK_MSG_ID_CURRENT_MODE: lambda cycle: current_mode(
                identity, shown_mode(cycle.mode), state.intended
            ),
            dialect.MAVLINK_MSG_ID_AVAILABLE_MODES_MONITOR: lambda _: modes_monitor(),
            dialect.MAVLINK_MSG_ID_MISSION_CURRENT: lambda cycle: plans.current(cycle, identity is Identity.ARDUSUB),
            dialect.MAVLINK_MSG_ID_FENCE_STATUS: plans.fence_status,
            dialect.MAVLINK_MSG_ID_HIGH_LATENCY2: high_latency.message,
        }

    def _settings_changed(self, settings: NodeSettings) -> None:
        """Take over the parameters that a station has changed."""
        self._plan_store.set_limits(settings.limits)
        for link in self.links:
            link.manual_control = settings.params.manual_control
