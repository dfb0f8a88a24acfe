"""COMMAND_LONG, COMMAND_INT and SET_MODE: every command gets one COMMAND_ACK, refusals with a sentence.

What a command does is in its handler's file: `ModeCommands` (arming, modes, pause), `SetpointCommands` (speed, depth,
heading, places), `GripperCommands` (drop weight), `PreflightCommands`, `MessageRequests` and `PlanUpload`.
"""

from __future__ import annotations

from collections.abc import Mapping

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import (
    UNSUPPORTED,
    Command,
    CommandHandler,
    CommandRefused,
    LinkOutput,
)
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.commands.mode_commands import ModeCommands
from firmware_py.mavlink.commands.queue import IN_PROGRESS, CommandResult
from firmware_py.tick import Tick

_SET_MODE: int = dialect.MAVLINK_MSG_ID_SET_MODE
_UNKNOWN_PROGRESS = 255
_NAMES = {
    **{number: entry.name.removeprefix("MAV_CMD_") for number, entry in dialect.enums["MAV_CMD"].items()},
    0: "MISSION_SET_CURRENT",
    _SET_MODE: "SET_MODE",
}
"""Names of the commands, and of the two messages that are executed like commands."""


class CommandDispatch:
    """The commands of one link; `handlers` are those of other services."""

    def __init__(
        self,
        output: LinkOutput,
        modes: ModeCommands,
        handlers: Mapping[int, CommandHandler],
    ) -> None:
        self._output = output
        self._modes = modes
        self._handlers = {**modes.command_handlers(), **handlers}

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
        progress = _UNKNOWN_PROGRESS if result == IN_PROGRESS else 0
        self._output.send(dialect.MAVLink_command_ack_message(number, result, progress, 0, system, component))

    def _old_set_mode(self, tick: Tick, m: Message) -> None:
        """Execute SET_MODE. The standard has no answer to it; as ArduPilot does, answer with the message's id."""
        params = (float(m.base_mode), float(m.custom_mode), 0.0)
        self._attempt(
            self._modes.set_mode, tick, Command(m.get_srcSystem(), m.get_srcComponent(), _SET_MODE, False, params)
        )
