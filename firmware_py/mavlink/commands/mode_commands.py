"""The commands that arm, disarm and choose a mode: each becomes a pending command that asks for it in the order."""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.link_output import REJECTED, Command, CommandHandler, CommandRefused
from firmware_py.mavlink.base.modes import Identity, mode_of, standard_mode
from firmware_py.mavlink.base.refusal import ModeReason, ModeRefusal
from firmware_py.mavlink.commands.queue import CommandQueue, PendingCommand
from firmware_py.records.order import Arming, Mode
from firmware_py.tick import Tick

_FORCE = 21196.0
"""Param2 of a command to arm or disarm that is forced."""


class ModeCommands:
    """Arming and modes for one link; `mission_refusal` says why a mission may not start."""

    def __init__(self, link: int, queue: CommandQueue, identity: Identity, mission_refusal: Callable[[], str]) -> None:
        self._link = link
        self._queue = queue
        self._identity = identity
        self._mission_refusal = mission_refusal

    def command_handlers(self) -> dict[int, CommandHandler]:
        """See `service.Service`."""
        return {
            dialect.MAV_CMD_COMPONENT_ARM_DISARM: self._arm,
            dialect.MAV_CMD_RUN_PREARM_CHECKS: self._check,
            dialect.MAV_CMD_DO_SET_MODE: self.set_mode,
            dialect.MAV_CMD_DO_SET_STANDARD_MODE: self._set_standard_mode,
            dialect.MAV_CMD_DO_PAUSE_CONTINUE: self._pause,
            dialect.MAV_CMD_NAV_LOITER_UNLIM: self._mode(Mode.LOITER),
            dialect.MAV_CMD_NAV_LAND: self._mode(Mode.SURFACE),
            dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH: self._mode(Mode.RETURN),
            dialect.MAV_CMD_DO_FLIGHTTERMINATION: self._terminate,
        }

    def _arm(self, tick: Tick, command: Command) -> int | None:
        """Arm or disarm. Force (param2) disarms under water too; arming is never forced: its checks always hold."""
        arm, force = command.params[:2]
        arming = {1.0: Arming.ARM, 0.0: Arming.DISARM}.get(arm)
        if arming is None:
            raise CommandRefused(f"{arm:g} is neither arm (1) nor disarm (0)")
        if arming is Arming.DISARM and force == _FORCE:
            arming = Arming.FORCE_DISARM
        if arming is Arming.ARM and self._queue.mode is Mode.DISARMED and self._queue.chosen is Mode.MISSION:
            self._check_mission()
        return self._enqueue(tick, command, arming, None)

    def _check(self, tick: Tick, command: Command) -> None:
        """Run the pre-arm checks; what would be refused comes as a sentence."""
        self._enqueue(tick, command, Arming.CHECK, None)

    def set_mode(self, tick: Tick, command: Command) -> int | None:
        """Execute DO_SET_MODE."""
        base, custom, sub = command.params[:3]
        if not math.isfinite(base) or not int(base) & dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            raise CommandRefused("only custom modes can be set")
        mode = mode_of(self._identity, custom, sub)
        if mode is None:
            raise CommandRefused(ModeRefusal(ModeReason.UNKNOWN_MODE, numbers=(custom, sub)))
        return self._enqueue(tick, command, Arming.KEEP, mode, chooses=True)

    def _set_standard_mode(self, tick: Tick, command: Command) -> int | None:
        mode = standard_mode(command.params[0])
        if mode is None:
            raise CommandRefused(f"standard mode {command.params[0]:g} is not supported")
        return self._enqueue(tick, command, Arming.KEEP, mode, chooses=True)

    def _pause(self, tick: Tick, command: Command) -> int | None:
        mode = {0.0: Mode.LOITER, 1.0: Mode.MISSION}.get(command.params[0])
        if mode is None:
            raise CommandRefused(f"{command.params[0]:g} is neither pause (0) nor continue (1)")
        return self._enqueue(tick, command, Arming.KEEP, mode)

    def _mode(self, mode: Mode) -> CommandHandler:
        def do(tick: Tick, command: Command) -> int | None:
            return self._enqueue(tick, command, Arming.KEEP, mode)

        return do

    def _terminate(self, tick: Tick, command: Command) -> int | None:
        """Surface and release the drop weight."""
        if not command.params[0] >= 1.0:
            raise CommandRefused(
                f"{command.params[0]:g} does not end the flight; 1 does: it surfaces and drops its weight"
            )
        self._put(tick, command, Arming.KEEP, None, terminate=True)
        return None

    def _enqueue(
        self, tick: Tick, command: Command, arming: Arming, mode: Mode | None, chooses: bool = False
    ) -> int | None:
        if mode is Mode.MISSION:
            self._check_mission()
        self._put(tick, command, arming, mode, chooses)
        return None

    def _check_mission(self) -> None:
        if why := self._mission_refusal():
            raise CommandRefused(why, REJECTED)

    def _put(
        self,
        tick: Tick,
        command: Command,
        arming: Arming,
        mode: Mode | None,
        chooses: bool = False,
        terminate: bool = False,
    ) -> None:
        who = (self._link, command.system, command.component, command.number)
        pending = PendingCommand(*who, arming, mode, chooses=chooses, terminate=terminate)
        self._queue.put(pending, command.again, tick.t_ns)
