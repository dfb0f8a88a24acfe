"""Who else commands the actuators of a bus: a bench tool moves nothing beside another autopilot."""

from __future__ import annotations

from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.message_table import TransferKind
from sternplane.hardware.messages import port_of

_COMMANDS = {
    kind.data_type_id: kind.name
    for kind in (m.ARRAY_COMMAND, m.RPM_COMMAND, m.RAW_COMMAND, m.HARDPOINT_COMMAND, m.ARMING_STATUS, m.TICK_DONE)
}
"""What none but an autopilot sends, or a tool that moves actuators."""


class OtherAutopilots:
    """Takes every frame that others send.

    Args:
        own_id: the autopilot's node id in the io file, under which nobody else may speak.

    Attributes:
        heard: by node id, what shows that it is one.
    """

    def __init__(self, own_id: int) -> None:
        self.heard: dict[int, str] = {}
        self._own_id = own_id

    def hear(self, can_id: int, _data: bytes, _t: float) -> None:
        """Take a frame."""
        if can_id & STANDARD:
            return
        port = port_of(can_id)
        if port.source == self._own_id:
            self.heard.setdefault(port.source, "speaks under the autopilot's own id")
        elif port.kind is TransferKind.MESSAGE and port.data_type_id in _COMMANDS:
            self.heard.setdefault(port.source, f"sends {_COMMANDS[port.data_type_id]}")
