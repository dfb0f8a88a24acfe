"""What every simulated DroneCAN node does: NodeStatus once a second, and the answer to GetNodeInfo."""

from __future__ import annotations

import math
from typing import TypeVar

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.wire.dronecan.message_table import GET_NODE_INFO, GET_NODE_INFO_RESPONSE, NODE_STATUS, MessageType
from firmware_py.wire.dronecan.node_messages import GetNodeInfoResponse, HardwareVersion, NodeStatus, SoftwareVersion
from firmware_py.wire.dronecan.transfer import Reassembler, Transfer, TransferSender

R = TypeVar("R")
VENDOR = "org.sternplane.sim."


class DeviceNode:
    """One device on the bus. Without power it neither sends nor answers."""

    def __init__(self, node_id: int, name: str, bus: FramePort) -> None:
        self.node_id = node_id
        self.name = VENDOR + name
        self.powered = True
        self._t_on = 0.0
        self.silent = False
        """A fault: it acts, but sends nothing."""
        self.health = 0
        self._bus = bus
        self._sender = TransferSender(node_id)
        self._requests = Reassembler([GET_NODE_INFO], node_id)

    def publish(self, message: MessageType[R], value: R) -> None:
        """Broadcast a message."""
        if self.powered and not self.silent:
            self._bus.send(self._sender.send(message, value))

    def publish_status(self, t: float) -> None:
        """Send NodeStatus; due once a second."""
        if math.isnan(self._t_on):
            self._t_on = t
        self.publish(NODE_STATUS, NodeStatus(self._uptime(t), self.health))

    def restart(self) -> None:
        """Begin anew, with power: uptime and transfer ids count from 0."""
        self.powered, self._t_on = True, math.nan
        self._sender = TransferSender(self.node_id)

    def accept_request(self, can_id: int, data: bytes, t: float) -> None:
        """Take a frame of a service request that is addressed to this node."""
        request = self._requests.accept(can_id, data, t)
        if request is not None and self.powered and not self.silent:
            self._send_node_info(request, t)

    def _uptime(self, t: float) -> int:
        return 0 if math.isnan(self._t_on) else int(t - self._t_on)

    def _send_node_info(self, request: Transfer, t: float) -> None:
        """Answer GetNodeInfo; the unique id is the end of the name."""
        name = self.name.encode()
        hardware = HardwareVersion(major=1, unique_id=name[-16:].rjust(16, b"\0"))
        info = GetNodeInfoResponse(NodeStatus(self._uptime(t), self.health), SoftwareVersion(major=1), hardware, name)
        self._bus.send(self._sender.respond(request, GET_NODE_INFO_RESPONSE, info))
