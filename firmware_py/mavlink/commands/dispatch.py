"""COMMAND_LONG, COMMAND_INT and SET_MODE: every command gets one COMMAND_ACK, refusals with a sentence.

Arming, modes and pausing are handled here; `MessageRequests`, `Setpoints`, `PreFlight` and `PlanUpload` handle the
other commands.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import (
    REJECTED,
    UNSUPPORTED,
    Command,
    CommandHandler,
    CommandRefused,
    LinkOutput,
)
from firmware_py.mavlink.base.modes import mode_of, standard_mode
from firmware_py.mavlink.base.refusal import ModeReason, ModeRefusal
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.commands.queue import CommandQueue, CommandResult, PendingCommand
from firmware_py.records.order import Arming, Mode
from firmware_py.schedule import Tick

_SET_MODE: int = dialect.MAVLINK_MSG_ID_SET_MODE
_NAMES = {
    **{number: entry.name.removeprefix("MAV_CMD_") for number, entry in dialect.enums["MAV_CMD"].items()},
    0: "MISSION_SET_CURRENT",
    _SET_MODE: "SET_MODE",
}
"""Names of the commands, and of the two messages that are executed like commands."""


class CommandDispatch:
    """The commands of one link. `handlers` are other services'; `mission_refusal` says why a mission may not start."""

    def __init__(
        self,
        link: int,
        output: LinkOutput,
        queue: CommandQueue,
        handlers: Mapping[int, CommandHandler],
        mission_refusal: Callable[[], str],
    ) -> None:
        self._link = link
        self._output = output
        self._queue = queue
        self._mission_refusal = mission_refusal
        self._handlers: dict[int, CommandHandler] = {
            dialect.MAV_CMD_COMPONENT_ARM_DISARM: self._arm,
            dialect.MAV_CMD_RUN_PREARM_CHECKS: self._check,
            dialect.MAV_CMD_DO_SET_MODE: self._set_mode,
            dialect.MAV_CMD_DO_SET_STANDARD_MODE: self._set_standard_mode,
            dialect.MAV_CMD_DO_PAUSE_CONTINUE: self._pause,
            dialect.MAV_CMD_NAV_LOITER_UNLIM: self._mode(Mode.LOITER),
            dialect.MAV_CMD_NAV_LAND: self._mode(Mode.SURFACE),
            dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH: self._mode(Mode.RETURN),
            **handlers,
        }

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_COMMAND_LONG: self._long,
            dialect.MAVLINK_MSG_ID_COMMAND_INT: self._int,
            dialect.MAVLINK_MSG_ID_SET_MODE: self._old_set_mode,
        }

    def send_result(self, result: CommandResult) -> None:
        """Send why a command was refused, and COMMAND_ACK unless it came by a message that is no command."""
        pending, code, why = result
        if why:
            self._output.send_refusal(_NAMES[pending.command], why)
        if pending.command:
            self._acknowledge(pending.command, code, pending.system, pending.component)

    def _long(self, tick: Tick, m: Message) -> None:
        params = (m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7)
        self._execute(tick, Command(m.get_srcSystem(), m.get_srcComponent(), m.command, m.confirmation > 0, params))

    def _int(self, tick: Tick, m: Message) -> None:
        params = (m.param1, m.param2, m.param3, m.param4, float(m.x), float(m.y), m.z)
        self._execute(tick, Command(m.get_srcSystem(), m.get_srcComponent(), m.command, False, params, m.frame))

    def _execute(self, tick: Tick, command: Command) -> None:
        self._attempt(self._handlers.get(command.number), tick, command)

    def _attempt(self, do: CommandHandler | None, tick: Tick, command: Command) -> None:
        try:
            result = UNSUPPORTED if do is None else do(tick, command)
        except CommandRefused as refusal:
            self._output.send_refusal(_NAMES[command.number], refusal.why)
            result = refusal.result
        if result is not None:
            self._acknowledge(command.number, result, command.system, command.component)

    def _acknowledge(self, number: int, result: int, system: int, component: int) -> None:
        self._output.send(dialect.MAVLink_command_ack_message(number, result, 0, 0, system, component))

    def _arm(self, tick: Tick, command: Command) -> int | None:
        """Arm or disarm; param2 (force) is ignored: the supervisor's checks always hold."""
        arming = {1.0: Arming.ARM, 0.0: Arming.DISARM}.get(command.params[0])
        if arming is None:
            raise CommandRefused(f"{command.params[0]:g} is neither arm (1) nor disarm (0)")
        return self._enqueue(tick, command, arming, None)

    def _check(self, tick: Tick, command: Command) -> None:
        """Run the pre-arm checks; what would be refused comes as a sentence."""
        self._enqueue(tick, command, Arming.CHECK, None)

    def _set_mode(self, tick: Tick, command: Command) -> int | None:
        base, custom, sub = command.params[:3]
        if not math.isfinite(base) or not int(base) & dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            raise CommandRefused("only custom modes can be set")
        mode = mode_of(custom, sub)
        if mode is None:
            raise CommandRefused(ModeRefusal(ModeReason.UNKNOWN_MODE, numbers=(custom, sub)))
        return self._enqueue(tick, command, Arming.KEEP, mode)

    def _set_standard_mode(self, tick: Tick, command: Command) -> int | None:
        mode = standard_mode(command.params[0])
        if mode is None:
            raise CommandRefused(f"standard mode {command.params[0]:g} is not supported")
        return self._enqueue(tick, command, Arming.KEEP, mode)

    def _old_set_mode(self, tick: Tick, m: Message) -> None:
        """Execute SET_MODE. The standard has no answer to it; as ArduPilot does, answer with the message's id."""
        params = (float(m.base_mode), float(m.custom_mode), 0.0)
        self._attempt(self._set_mode, tick, Command(m.get_srcSystem(), m.get_srcComponent(), _SET_MODE, False, params))

    def _pause(self, tick: Tick, command: Command) -> int | None:
        mode = {0.0: Mode.LOITER, 1.0: Mode.MISSION}.get(command.params[0])
        if mode is None:
            raise CommandRefused(f"{command.params[0]:g} is neither pause (0) nor continue (1)")
        return self._enqueue(tick, command, Arming.KEEP, mode)

    def _mode(self, mode: Mode) -> CommandHandler:
        def do(tick: Tick, command: Command) -> int | None:
            return self._enqueue(tick, command, Arming.KEEP, mode)

        return do

    def _enqueue(self, tick: Tick, command: Command, arming: Arming, mode: Mode | None) -> int | None:
        if mode is Mode.MISSION and (why := self._mission_refusal()):
            raise CommandRefused(why, REJECTED)
        who = (self._link, command.system, command.component, command.number)
        self._queue.put(PendingCommand(*who, arming, mode), command.again, tick.t_ns)
        return None
