"""What a station may say of depth, heading, speed and place, by command or by message, all of it as a `Setpoint`.

Heights become depths here: AMSL counts from the sea, relative altitude from the water's surface, so that what is above
either is no depth and is denied. Attitude is not for a station to say: the laws have it from depth and heading.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

from firmware_py.marine import Origin, geodetic_to_local
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import (
    NO_FRAME,
    REJECTED,
    UNSUPPORTED,
    WARNING,
    Command,
    CommandHandler,
    CommandRefused,
    LinkOutput,
)
from firmware_py.mavlink.commands.queue import CommandQueue, PendingCommand, setpoint_refusal
from firmware_py.records.order import KEEP_SETPOINT, Arming, Asker, Mode, Setpoint
from firmware_py.schedule import NS_PER_S, Tick

_NAN = math.nan
_AMSL = (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_GLOBAL_INT)
_RELATIVE = (dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT, dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)
_LOCAL = dialect.MAV_FRAME_LOCAL_NED
_E7, _E4, _INT_UNKNOWN = 1e-7, 1e-4, 2147483647.0
_AT_SURFACE = 0.01
"""So much above the surface, m, is rounding."""
_MAX_DISTANCE = 1e5
"""A place farther from the origin, m, is none of ours."""
_IGNORE_POSITION, _IGNORE_DEPTH, _IGNORE_YAW = 1 | 2, 4, 1024
_IGNORE_VELOCITY, _IGNORE_REST = 8 | 16, 64 | 128 | 256 | 2048
_REPEAT_REFUSAL_NS = 10 * NS_PER_S


class WaterFrame(NamedTuple):
    """Where the local frame touches the earth, and the water's surface above mean sea level, m."""

    origin: Origin
    surface: float

    def depth(self, frame: int, height: float) -> float:
        """The depth, m, of a height in a frame; NaN of NaN.

        Raises:
            Refusal: it is above the water, or the frame has no such height.
        """
        if frame in _AMSL:
            depth = self.surface - height
        elif frame in _RELATIVE:
            depth = -height
        elif frame == _LOCAL:
            depth = height
        else:
            raise CommandRefused(f"frame {frame} is not known here; use a global one or LOCAL_NED", NO_FRAME)
        if math.isinf(depth) or depth < -_AT_SURFACE:
            raise CommandRefused(f"{-depth:.2f} m above the water is no depth")
        return max(depth, 0.0) if math.isfinite(depth) else _NAN

    def position(self, latitude: float, longitude: float) -> tuple[float, float]:
        """(x, y), m, of degrees.

        Raises:
            Refusal: it is no place, or too far off to be one of ours.
        """
        if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
            raise CommandRefused(f"{latitude:g}, {longitude:g} is no place")
        return _within_range(*geodetic_to_local(self.origin, math.radians(latitude), math.radians(longitude)))


class SetpointCheck(Protocol):
    """Whoever knows how deep and where the vehicle may be sent."""

    @property
    def depth_max(self) -> float:
        """The supervisor's limit, m."""

    def check_position(self, x: float, y: float, u: float) -> str:
        """Return what is wrong with going to (x, y), m, at u, m/s (0: none asked); "" if nothing is."""


class Setpoints:
    """Of one link. What `check` has something against is refused, not obeyed and undone."""

    def __init__(
        self, link: int, output: LinkOutput, queue: CommandQueue, water_frame: WaterFrame, check: SetpointCheck
    ) -> None:
        self._link, self._output, self._queue, self._water_frame = link, output, queue, water_frame
        self._check = check
        self._last_refusal: dict[int, tuple[int, str]] = {}

    def command_handlers(self) -> dict[int, CommandHandler]:
        """Who does which command."""
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

    def message_handlers(self) -> dict[int, Callable[[Tick, Message], None]]:
        """The message ids that come here."""
        return {
            dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: self._position_target,
            dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: self._position_target,
            dialect.MAVLINK_MSG_ID_SET_ATTITUDE_TARGET: self._attitude,
        }

    def _handler(self, parser: Callable[[Command], tuple[Setpoint, Mode | None]]) -> CommandHandler:
        def do(tick: Tick, command: Command) -> int | None:
            setpoint, mode = parser(command)
            self._refuse_beyond(setpoint)
            if mode is None and (why := setpoint_refusal(self._queue.mode, setpoint)):
                raise CommandRefused(why, REJECTED)
            who = (self._link, command.system, command.component, command.number)
            self._queue.put(PendingCommand(*who, Arming.KEEP, mode, setpoint), command.again, tick.t_ns)
            return None

        return do

    def _reposition(self, command: Command) -> tuple[Setpoint, Mode | None]:
        """Unknown values keep what is there; a radius and a yaw are not for this vehicle to choose."""
        speed, flags, _, _, x, y, z = command.params
        frame = command.frame if command.frame >= 0 else _AMSL[0]
        depth = self._water_frame.depth(frame, z)
        if math.isnan(x + y) or _INT_UNKNOWN in (x, y):
            position = (_NAN, _NAN)
        elif frame == _LOCAL:
            position = _within_range(x * _E4, y * _E4)
        else:
            scale = _E7 if command.frame >= 0 else 1.0
            position = self._water_frame.position(x * scale, y * scale)
        u_d = _NAN if math.isnan(speed) or speed <= 0.0 else _speed(speed)
        change = math.isfinite(flags) and int(flags) & dialect.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
        return Setpoint(depth, _NAN, u_d, *position), Mode.GUIDED if change else None

    def _speed(self, command: Command) -> tuple[Setpoint, None]:
        kind, speed = command.params[:2]
        if kind not in (dialect.SPEED_TYPE_AIRSPEED, dialect.SPEED_TYPE_GROUNDSPEED):
            raise CommandRefused(f"speed type {kind:g}: only speed ahead (0 or 1) can be changed", UNSUPPORTED)
        return KEEP_SETPOINT._replace(u_d=_speed(speed)), None

    def _altitude(self, command: Command) -> tuple[Setpoint, None]:
        height, frame = command.params[:2]
        return self._to_depth(height, int(frame) if math.isfinite(frame) else -1)

    def _guided_altitude(self, command: Command) -> tuple[Setpoint, None]:
        return self._to_depth(command.params[6], command.frame if command.frame >= 0 else _AMSL[0])

    def _to_depth(self, height: float, frame: int) -> tuple[Setpoint, None]:
        depth = self._water_frame.depth(frame, height)
        if math.isnan(depth):
            raise CommandRefused("nan is no height")
        return KEEP_SETPOINT._replace(z_d=depth), None

    def _yaw(self, command: Command) -> tuple[Setpoint, None]:
        """The shorter way, whatever direction is asked for, unless the angle is relative."""
        angle, _, direction, relative = command.params[:4]
        if relative == 1.0:
            cycle = self._queue.cycle
            here = math.degrees(cycle.state.eta.psi) if cycle is not None else _NAN
            angle = here + (-angle if direction < 0.0 else angle)
        elif relative != 0.0:
            raise CommandRefused(f"{relative:g} is neither absolute (0) nor relative (1)")
        return KEEP_SETPOINT._replace(psi_d=_heading(angle)), None

    def _heading(self, command: Command) -> tuple[Setpoint, None]:
        return KEEP_SETPOINT._replace(psi_d=_heading(command.params[1])), None

    def _position_target(self, tick: Tick, m: Message) -> None:
        """Place, depth and yaw, or a velocity as course and speed; there is no answer, so a refusal is a sentence."""
        asker = Asker(self._link, m.get_srcSystem(), m.get_srcComponent(), 0)
        try:
            setpoint = self._position_target_setpoint(m)
            self._refuse_beyond(setpoint)
            if why := setpoint_refusal(self._queue.mode, setpoint):
                raise CommandRefused(why)
        except CommandRefused as refusal:
            self._refuse(tick, m, str(refusal))
            return
        self._queue.set_setpoint(setpoint, asker)

    def _position_target_setpoint(self, m: Message) -> Setpoint:
        mask, frame = m.type_mask, m.coordinate_frame
        depth = psi_d = u_d = x = y = _NAN
        local = m.get_msgId() == dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED
        if local != (frame == _LOCAL):
            raise CommandRefused(f"frame {frame} is not known here; use a global one or LOCAL_NED")
        if mask & _IGNORE_REST != _IGNORE_REST:
            raise CommandRefused(f"type_mask {mask}: acceleration and yaw rate cannot be followed; ignore them")
        if not mask & _IGNORE_POSITION:
            x, y = _within_range(m.x, m.y) if local else self._water_frame.position(m.lat_int * _E7, m.lon_int * _E7)
        if not mask & _IGNORE_DEPTH:
            depth = self._water_frame.depth(frame, m.z if local else m.alt)
        if not mask & _IGNORE_VELOCITY:
            u_d = _speed(math.hypot(m.vx, m.vy))
            if math.isnan(x) and u_d > 0.0:
                psi_d = math.atan2(m.vy, m.vx)
        if not mask & _IGNORE_YAW and math.isnan(x):
            psi_d = _heading(math.degrees(m.yaw))
        if all(map(math.isnan, (depth, psi_d, u_d, x))):
            raise CommandRefused(f"type_mask {mask} leaves nothing to follow")
        return Setpoint(depth, psi_d, u_d, x, y)

    def _refuse_beyond(self, setpoint: Setpoint) -> None:
        if setpoint.z_d > self._check.depth_max:
            raise CommandRefused(f"depth {setpoint.z_d:.1f} m, limit {self._check.depth_max:g} m")
        if math.isnan(setpoint.x):
            return
        cycle, u_d = self._queue.cycle, setpoint.u_d
        if math.isnan(u_d):
            u_d = 0.0 if cycle is None else cycle.reference.u_d
        if why := self._check.check_position(setpoint.x, setpoint.y, u_d):
            raise CommandRefused(why)

    def _attitude(self, tick: Tick, m: Message) -> None:
        self._refuse(tick, m, "attitude cannot be set; set depth and heading")

    def _refuse(self, tick: Tick, m: Message, why: str) -> None:
        """Stations repeat such messages many times a second."""
        last, what = self._last_refusal.get(m.get_msgId(), (-_REPEAT_REFUSAL_NS, why))
        if tick.t_ns - last >= (_REPEAT_REFUSAL_NS if what == why else NS_PER_S):
            self._last_refusal[m.get_msgId()] = tick.t_ns, why
            self._output.send_text(f"{m.get_type()} refused: {why}", WARNING)


def _within_range(x: float, y: float) -> tuple[float, float]:
    if not math.hypot(x, y) <= _MAX_DISTANCE:
        raise CommandRefused(f"the place is not within {_MAX_DISTANCE / 1000.0:g} km of the origin")
    return x, y


def _speed(speed: float) -> float:
    if not 0.0 <= speed <= 100.0:
        raise CommandRefused(f"{speed:g} m/s is no speed ahead")
    return speed


def _heading(angle: float) -> float:
    if not math.isfinite(angle):
        raise CommandRefused(f"{angle:g} deg is no heading")
    return math.radians(angle % 360.0)
