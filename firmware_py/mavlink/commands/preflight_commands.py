"""Commands before a flight: reboot and shutdown, calibration, and the home position."""

from __future__ import annotations

import math
from typing import Final

from firmware_py.marine import geodetic_to_local
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import (
    ACCEPTED,
    REJECTED,
    UNSUPPORTED,
    WARNING,
    Command,
    CommandHandler,
    CommandRefused,
    LinkOutput,
)
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.commands.queue import CommandQueue
from firmware_py.records.order import Mode
from firmware_py.tick import Tick

_E7, _MM = 1e-7, 1e-3
_TOLERANCE: Final = 1.0
"""A home within this distance, m, is the vehicle's own."""
_HOME, _ORIGIN = dialect.MAVLINK_MSG_ID_HOME_POSITION, dialect.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN


class PreflightCommands:
    """The pre-flight commands of one link. Home is the origin of the local frame, which the configuration sets."""

    def __init__(self, output: LinkOutput, queue: CommandQueue, water_frame: WaterFrame) -> None:
        self._output, self._queue, self._water_frame = output, queue, water_frame

    def command_handlers(self) -> dict[int, CommandHandler]:
        """Return the handler of each command."""
        return {
            dialect.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: self._restart,
            dialect.MAV_CMD_PREFLIGHT_CALIBRATION: self._calibrate,
            dialect.MAV_CMD_DO_SET_HOME: self._set_home,
        }

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_SET_GPS_GLOBAL_ORIGIN: self._origin,
            dialect.MAVLINK_MSG_ID_SET_HOME_POSITION: self._home,
        }

    def _refuse_armed(self) -> None:
        if self._queue.mode is not Mode.DISARMED:
            raise CommandRefused("the vehicle is armed; disarm first", REJECTED)

    def _restart(self, _: Tick, command: Command) -> int:
        """Request a reboot or shutdown of a disarmed vehicle; the command's force parameter is ignored."""
        if command.params[0] == 0.0:
            return ACCEPTED  # nothing is requested
        what = {1.0: "reboot", 2.0: "shutdown"}.get(command.params[0])
        if what is None:
            raise CommandRefused(f"{command.params[0]:g} is neither a reboot (1) nor a shutdown (2)")
        self._refuse_armed()
        if not self._queue.end_allowed:
            raise CommandRefused("this program cannot be restarted by a station; end it where it was started")
        self._queue.end_request, self._queue.end_requester = what, f"{command.system}/{command.component}"
        return ACCEPTED

    def _calibrate(self, _: Tick, command: Command) -> int:
        self._refuse_armed()
        if not any(command.params):
            return ACCEPTED  # nothing is requested
        self._output.send_text(
            "nothing to calibrate: the AHRS calibrates itself, and depth is zeroed until the first arming", WARNING
        )
        return UNSUPPORTED

    def _set_home(self, _: Tick, command: Command) -> int:
        current, (x, y, z) = command.params[0], command.params[4:]
        if current == 1.0:
            raise CommandRefused(
                "home stays at the origin of the local frame; it cannot be set to the vehicle's position"
            )
        scale = _E7 if command.frame >= 0 else 1.0
        return self._compare(x * scale, y * scale, z, "home", _HOME)

    def _home(self, _: Tick, m: Message) -> None:
        self._compare_message(m, "home", _HOME)

    def _origin(self, _: Tick, m: Message) -> None:
        self._compare_message(m, "origin", _ORIGIN)

    def _compare_message(self, m: Message, what: str, name: int) -> None:
        try:
            self._compare(m.latitude * _E7, m.longitude * _E7, m.altitude * _MM, what, name)
        except CommandRefused as refusal:
            self._output.send_refusal(m.get_type(), refusal.why)

    def _compare(self, latitude: float, longitude: float, altitude: float, what: str, name: int) -> int:
        """Send the current value, and refuse another one."""
        self._output.send_from_cycle(name)
        origin, surface = self._water_frame
        if not math.isfinite(latitude + longitude + altitude):
            raise CommandRefused(f"{latitude:g}, {longitude:g}, {altitude:g} m is not a position")
        x, y = geodetic_to_local(origin, math.radians(latitude), math.radians(longitude))
        if math.hypot(x, y) <= _TOLERANCE and abs(altitude - surface) <= _TOLERANCE:
            return ACCEPTED
        at = f"{math.degrees(origin.latitude):.6f}, {math.degrees(origin.longitude):.6f}, {surface:g} m"
        raise CommandRefused(f"{what} stays at {at}, as [origin] and surface_altitude of the configuration set it")
