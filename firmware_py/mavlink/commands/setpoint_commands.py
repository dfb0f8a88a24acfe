"""Setpoints of depth, heading, speed and position from one link, by command or by message."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from functools import partial
from typing import Protocol

from firmware_py.marine import Eta
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import (
    REJECTED,
    UNSUPPORTED,
    Command,
    CommandHandler,
    CommandRefused,
    LinkOutput,
)
from firmware_py.mavlink.base.refusal import Refusal
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.base.water_frame import AMSL, LOCAL, WaterFrame, within_range
from firmware_py.mavlink.commands.position_targets import heading, setpoint_of, speed_ahead
from firmware_py.mavlink.commands.queue import CommandQueue, PendingCommand, PendingSetpoint, setpoint_refusal
from firmware_py.records.order import KEEP_SETPOINT, Arming, Asker, Mode, Setpoint
from firmware_py.tick import NS_PER_S, Tick

_NAN = math.nan
_E7, _E4, _INT_UNKNOWN = 1e-7, 1e-4, 2147483647.0
_NOWHERE = Eta(*[_NAN] * 6)
_PARAMS = struct.Struct("<i7d")
_REPEAT_REFUSAL_NS = 10 * NS_PER_S


class SetpointChecks(Protocol):
    """What setpoints are checked against; the plan store is one."""

    water_frame: WaterFrame

    @property
    def depth_max(self) -> float:
        """The supervisor's limit, m."""

    def check_position(self, x: float, y: float, u: float) -> str:
        """Return what is wrong with going to (x, y), m, at u, m/s (0: cruising speed); "" if nothing is."""


class SetpointCommands:
    """The setpoints of one link. What lies beyond the operating limits or the fence is refused."""

    def __init__(self, link: int, output: LinkOutput, queue: CommandQueue, checks: SetpointChecks) -> None:
        self._link, self._output, self._queue, self._checks = link, output, queue, checks
        self._water_frame = checks.water_frame
        self._last_refusal: dict[int, tuple[int, Refusal]] = {}
        """Time and refusal, by message id."""

    def command_handlers(self) -> dict[int, CommandHandler]:
        """Return the handler of each command."""
        parsers = {
            dialect.MAV_CMD_DO_REPOSITION: self._reposition,
            dialect.MAV_CMD_DO_CHANGE_SPEED: self._speed,
            dialect.MAV_CMD_GUIDED_CHANGE_SPEED: self._speed,
            dialect.MAV_CMD_DO_CHANGE_ALTITUDE: self._altitude,
            dialect.MAV_CMD_GUIDED_CHANGE_ALTITUDE: self._guided_altitude,
            dialect.MAV_CMD_CONDITION_YAW: self._yaw,
            dialect.MAV_CMD_GUIDED_CHANGE_HEADING: self._heading,
        }
        return {number: self._handler(parser) for number, parser in parsers.items()}

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: self._position_target,
            dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: self._position_target,
            dialect.MAVLINK_MSG_ID_SET_ATTITUDE_TARGET: self._attitude,
        }

    def _handler(self, parser: Callable[[Command], tuple[Setpoint, Mode | None]]) -> CommandHandler:
        def handle(tick: Tick, command: Command) -> int | None:
            setpoint, mode = parser(command)
            self._check_limits(setpoint)
            if mode is None and (why := setpoint_refusal(self._queue.mode, setpoint)) is not None:
                raise CommandRefused(why, REJECTED)
            sender = (self._link, command.system, command.component, command.number)
            params = _PARAMS.pack(command.frame, *command.params)
            pending = PendingCommand(*sender, Arming.KEEP, mode, setpoint, params=params)
            self._queue.put(pending, command.again, tick.t_ns)
            return None

        return handle

    def _reposition(self, command: Command) -> tuple[Setpoint, Mode | None]:
        """Read DO_REPOSITION: unknown values keep what holds; radius and yaw are ignored."""
        speed, flags, _, _, x, y, z = command.params
        frame = command.frame if command.frame >= 0 else AMSL[0]
        depth = self._water_frame.depth(frame, z)
        if math.isnan(x + y) or _INT_UNKNOWN in (x, y):
            position = (_NAN, _NAN)
        elif frame == LOCAL:
            position = within_range(x * _E4, y * _E4)
        else:
            scale = _E7 if command.frame >= 0 else 1.0
            position = self._water_frame.position(x * scale, y * scale)
        u_d = _NAN if math.isnan(speed) or speed <= 0.0 else speed_ahead(speed)
        change = math.isfinite(flags) and int(flags) & dialect.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
        return Setpoint(depth, _NAN, u_d, *position), Mode.GUIDED if change else None

    def _speed(self, command: Command) -> tuple[Setpoint, None]:
        kind, speed = command.params[:2]
        if kind not in (dialect.SPEED_TYPE_AIRSPEED, dialect.SPEED_TYPE_GROUNDSPEED):
            raise CommandRefused(f"speed type {kind:g}: only speed ahead (0 or 1) can be changed", UNSUPPORTED)
        return KEEP_SETPOINT._replace(u_d=speed_ahead(speed)), None

    def _altitude(self, command: Command) -> tuple[Setpoint, None]:
        height, frame = command.params[:2]
        return self._to_depth(height, int(frame) if math.isfinite(frame) else -1)

    def _guided_altitude(self, command: Command) -> tuple[Setpoint, None]:
        return self._to_depth(command.params[6], command.frame if command.frame >= 0 else AMSL[0])

    def _to_depth(self, height: float, frame: int) -> tuple[Setpoint, None]:
        depth = self._water_frame.depth(frame, height)
        if math.isnan(depth):
            raise CommandRefused("nan is not a height")
        return KEEP_SETPOINT._replace(z_d=depth), None

    def _yaw(self, command: Command) -> tuple[Setpoint, None]:
        """Read CONDITION_YAW: an absolute angle is reached the shorter way, whatever direction is asked for."""
        angle, _, direction, relative = command.params[:4]
        if relative == 1.0:
            cycle = self._queue.cycle
            here = math.degrees(cycle.state.eta.psi) if cycle is not None else _NAN
            angle = here + (-angle if direction < 0.0 else angle)
        elif relative != 0.0:
            raise CommandRefused(f"{relative:g} is neither absolute (0) nor relative (1)")
        return KEEP_SETPOINT._replace(psi_d=heading(angle)), None

    def _heading(self, command: Command) -> tuple[Setpoint, None]:
        return KEEP_SETPOINT._replace(psi_d=heading(command.params[1])), None

    def _position_target(self, tick: Tick, m: Message) -> None:
        """Take a position target; the message has no acknowledgement, so a refusal is a sentence."""
        try:
            cycle = self._queue.cycle
            setpoint = setpoint_of(m, self._water_frame, _NOWHERE if cycle is None else cycle.state.eta)
            self._check_limits(setpoint)
            if (why := setpoint_refusal(self._queue.mode, setpoint)) is not None:
                raise CommandRefused(why)
        except CommandRefused as refusal:
            self._refuse(tick, m, refusal.why)
            return
        asker = Asker(self._link, m.get_srcSystem(), m.get_srcComponent(), 0)
        self._queue.set_setpoint(PendingSetpoint(setpoint, asker, partial(self._refuse, tick, m)))

    def _check_limits(self, setpoint: Setpoint) -> None:
        depth_max = self._checks.depth_max
        if setpoint.z_d > depth_max:
            raise CommandRefused(f"depth {setpoint.z_d:.1f} m, limit {depth_max:g} m")
        if math.isnan(setpoint.x):
            return
        cycle, u_d = self._queue.cycle, setpoint.u_d
        if math.isnan(u_d):
            u_d = 0.0 if cycle is None else cycle.reference.u_d
        if why := self._checks.check_position(setpoint.x, setpoint.y, u_d):
            raise CommandRefused(why)

    def _attitude(self, tick: Tick, m: Message) -> None:
        self._refuse(tick, m, "attitude cannot be set; set depth and heading")

    def _refuse(self, tick: Tick, m: Message, why: Refusal) -> None:
        """Send the refusal, the same one not more often than every 10 s: stations repeat these messages."""
        last, what = self._last_refusal.get(m.get_msgId(), (-_REPEAT_REFUSAL_NS, why))
        if tick.t_ns - last >= (_REPEAT_REFUSAL_NS if what == why else NS_PER_S):
            self._last_refusal[m.get_msgId()] = tick.t_ns, why
            self._output.send_refusal(m.get_type(), why)
