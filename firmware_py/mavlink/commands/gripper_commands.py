"""MAV_CMD_DO_GRIPPER: a station's command to release the drop weight, and nothing else."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.link_output import Command, CommandHandler, CommandRefused
from firmware_py.mavlink.commands.queue import CommandQueue, PendingCommand
from firmware_py.records.order import Arming
from firmware_py.tick import Tick

_RELEASE = float(dialect.GRIPPER_ACTION_RELEASE)
_OURS = (0.0, 1.0)
"""Gripper ids: 0 is all of them, as MAVLink has it, and 1 the first."""


class GripperCommands:
    """The drop weight as gripper 1 of one link; `there` says whether the vehicle file has one."""

    def __init__(self, link: int, queue: CommandQueue, there: bool) -> None:
        self._link = link
        self._queue = queue
        self._there = there

    def command_handlers(self) -> dict[int, CommandHandler]:
        """See `service.Service`."""
        return {dialect.MAV_CMD_DO_GRIPPER: self._release}

    def _release(self, tick: Tick, command: Command) -> None:
        """Release the weight, armed or not; its result comes when the hardpoint says so."""
        gripper, action = command.params[:2]
        if not self._there:
            raise CommandRefused("the vehicle has no drop weight ([drop_weight] in vehicle.toml)")
        if gripper not in _OURS:
            raise CommandRefused(f"there is no gripper {gripper:g}; the drop weight is 1")
        if action != _RELEASE:
            raise CommandRefused(f"action {action:g} cannot be done: a drop weight can only be released (0)")
        who = (self._link, command.system, command.component, command.number)
        self._queue.put(PendingCommand(*who, Arming.KEEP, None, release=True), command.again, tick.t_ns)
