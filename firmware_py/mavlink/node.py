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
from firmware_py.mavlink.base.service import PersistentState
from firmware_py.mavlink.base.signing import Signing
from firmware_py.mavlink.base.statustext import severity
from firmware_py.mavlink.commands.manual_control import ManualControlParams
from firmware_py.mavlink.commands.queue import CommandQueue
from firmware_py.mavlink.commands.setpoints import WaterFrame
from firmware_py.mavlink.files.ftp_server import FtpServer
from firmware_py.mavlink.files.log_transfer import LogTransfer
from firmware_py.mavlink.files.tree import FileTree, LogStorage
from firmware_py.mavlink.link import MAX_PARSED_PER_TICK, Link
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
from firmware_py.mavlink.telemetry.pose import Encoder, PoseTelemetry, TelemetryParams
from firmware_py.mavlink.telemetry.system_state import SystemState
from firmware_py.mavlink.telemetry.time_sync import Calendar, TimeSync
from firmware_py.parameter_tree import with_values
from firmware_py.params import TakesEffect, param, table
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Mode, Order
from firmware_py.records.turning import Turning
from firmware_py.schedule import Tick

STATE_FILES = (transfer.FILE, *plan_builder.FILES.values())
"""The names of all that `Node.saves` may ever give."""
_TURNING_KEYS = {
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
        coefficients: Sequence[str] = (),
        signing: Signing | None = None,
        parameter_store: ParameterStore | None = None,
        plans: Mapping[int, PlanBuilder] | None = None,
    ) -> None:
        """`doors` has one for each link, `coefficients` the names of what is learned, as the records order it.

        With `signing`, all links are signed. `book` has the parameters, `plans` mission, fence and rally points.
        """
        self._params = params
        self._queue = CommandQueue()
        self._system_state = SystemState()
        water_frame = WaterFrame(origin, params.telemetry.surface_altitude)
        self._plan_store = PlanStore(water_frame, plans)
        self._target = NavigationTarget(self._plan_store)
        self._lateness = Lateness()
        status = HealthTelemetry(actuators, self._lateness, self._plan_store)
        shared = PoseTelemetry(params.telemetry, origin, actuators.n_max).encoders() | status.encoders()
        shared |= OdometryTelemetry(water_frame.surface, self._target).encoders()
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
                *(i, configuration, params.system, params.manual_control, water_frame, self._queue),
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
        for i, (link, configuration) in enumerate(zip(self.links, configurations, strict=True)):
            missions = PlanUpload(i, self._plan_store, link, self._queue, configuration.identity)
            link.add_service(missions)
            link.add_commands(missions.command_handlers(), missions.mission_refusal)
            link.setpoints.position_refusal = self._plan_store.check_position

    def receive_all(self, tick: Tick, said: Sequence[Sequence[bytes]]) -> None:
        """Takes what came since the last tick, by link.

        All of it together costs no more than HEARD_PER_TICK places: each link that speaks has its share of them, and
        whoever comes later what those before have left.
        """
        left, speaking = MAX_PARSED_PER_TICK, [i for i, datagrams in enumerate(said) if datagrams]
        for set_turning, i in enumerate(speaking):
            left -= self.links[i].receive(tick, said[i], left // (len(speaking) - set_turning))

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
        self._target.update(cycle)
        for event in cycle.events:
            level = severity(event)
            for link in self.links:
                link.send_event(event, level)
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

    def set_limits(self, depth_max: float, altitude_min: float | None = None, turning: Turning | None = None) -> None:
        """The supervisor's limits, m: stations are told that no setpoint or mission may go beyond.

        `turning` says how wide a mission's circles will be.
        """
        self._plan_store.set_limits(depth_max, altitude_min)
        if turning is not None:
            self._plan_store.set_turning(**turning._asdict())
        for link in self.links:
            link.setpoints.depth_max = depth_max

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
        briefly = HighLatency(identity, water_frame.origin, water_frame.surface, n_max, system_state, self._target)
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

    def _parameter_changed(self, key: str, value: Any) -> None:
        """Of what stations change, that which is ours."""
        table, _, rest = key.partition(".")
        if key == "safety.depth_max_m":
            self.set_limits(value)
        if key == "safety.altitude_min_m":
            self._plan_store.set_limits(altitude_min=value)
        if key in _TURNING_KEYS:
            name, unit = _TURNING_KEYS[key]
            self._plan_store.set_turning(**{name: value * unit})
        if table == "mavlink":
            self._params = with_values(self._params, {rest: value}, table)
            for link in self.links:
                link.set_manual_control(self._params.manual_control)
