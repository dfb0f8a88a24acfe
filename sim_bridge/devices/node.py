"""What every simulated DroneCAN node does: NodeStatus once a second, and the answers to other nodes' requests.

One node may have several functions, as a servo hub that is the speed controller too.
"""

from __future__ import annotations

import math
from typing import TypeVar

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.wire.dronecan.message_table import NODE_STATUS, MessageType
from firmware_py.wire.dronecan.node_messages import (
    CanIfaceStats,
    GetTransportStatsResponse,
    HardwareVersion,
    NodeStatus,
    SoftwareVersion,
    Value,
)
from firmware_py.wire.dronecan.node_services import SERVICES, Identity, NodeServices, Parameter
from firmware_py.wire.dronecan.transfer import Reassembler, TransferSender

R = TypeVar("R")
VENDOR = "org.sternplane.sim."


class DeviceNode:
    """One node of the bus. Without power it neither sends nor answers; it restarts when it is asked to.

    `functions` are its roles in the io file, each of which faults may strike; what is without any is a sender alone.
    """

    def __init__(self, node_id: int, name: str, bus: FramePort) -> None:
        self.node_id = node_id
        self.name = VENDOR + name
        self.powered = True
        self._t_on = 0.0
        self.functions: list[NodeFunction] = []
        self._bus = bus
        self._sender = TransferSender(node_id)
        self._requests = Reassembler(SERVICES, node_id)
        self._received = self._requested = 0
        unique_id = self.name.encode()[-16:].rjust(16, b"\0")
        self._identity = Identity(
            self.name.encode(), SoftwareVersion(major=1), HardwareVersion(major=1, unique_id=unique_id)
        )
        self._services = self._fresh_services()

    @property
    def silent(self) -> bool:
        """Return whether faults silence all that it does, so that nothing is sent."""
        return bool(self.functions) and all(one.silent for one in self.functions)

    def publish(self, message: MessageType[R], value: R) -> None:
        """Broadcast a message of the node itself."""
        if self.powered and not self.silent:
            self.send(message, value)

    def send(self, message: MessageType[R], value: R) -> None:
        """Broadcast a message, whatever faults there are; each type has its transfer ids."""
        self._bus.send(self._sender.send(message, value))

    def publish_status(self, t: float) -> None:
        """Send NodeStatus; due once a second."""
        if math.isnan(self._t_on):
            self._t_on = t
        self.publish(NODE_STATUS, self._status(t))

    def restart(self) -> None:
        """Begin anew, with power: uptime, transfer ids and counts begin at 0."""
        self.powered, self._t_on = True, math.nan
        self._sender = TransferSender(self.node_id)
        self._received = self._requested = 0
        self._services = self._fresh_services()

    def accept_request(self, can_id: int, data: bytes, t: float) -> None:
        """Take a frame of a service request that is addressed to this node."""
        self._received += 1
        request = self._requests.accept(can_id, data, t)
        if request is not None and self.powered and not self.silent:
            self._requested += 1
            self._services.hear(request)
            self._bus.send(self._services.answer(self._status(t), self._stats))

    def _status(self, t: float) -> NodeStatus:
        health = max((one.health for one in self.functions), default=0)
        return NodeStatus(0 if math.isnan(self._t_on) else int(t - self._t_on), health)

    def _fresh_services(self) -> NodeServices:
        parameters = [Parameter(b"node_id", Value(1, self.node_id))]
        return NodeServices(self._sender, self._identity, parameters, self._restart_asked)

    def _restart_asked(self) -> str:
        self.restart()
        return ""

    def _stats(self) -> GetTransportStatsResponse:
        """Return what the node has counted: of what it receives, the requests to it alone."""
        frames = CanIfaceStats(self._sender.frames_sent, self._received, 0)
        return GetTransportStatsResponse(self._sender.sent, self._requested, self._services.malformed, (frames,))


class NodeFunction:
    """One of the roles of a node. A fault strikes it alone, and the node where that has no other.

    A node without any function that is on has no power, and begins anew with the first one that is on again.
    """

    def __init__(self, node: DeviceNode) -> None:
        self.node = node
        self.on = True
        self.silent = False
        """A fault: it acts, but sends nothing."""
        self.health = 0
        """A fault: what NodeStatus says; of several functions the worst."""
        node.functions.append(self)

    @property
    def node_id(self) -> int:
        """Return the id of its node."""
        return self.node.node_id

    @property
    def powered(self) -> bool:
        """Return whether it works."""
        return self.on and self.node.powered

    def publish(self, message: MessageType[R], value: R) -> None:
        """Broadcast a message of this function."""
        if self.on and not self.silent and self.node.powered:
            self.node.send(message, value)

    def switch_off(self) -> None:
        """Take its power away; what else its node does goes on."""
        self.on = False
        self.node.powered = any(one.on for one in self.node.functions)

    def switch_on(self) -> None:
        """Give it power again."""
        self.on = True
        if not self.node.powered:
            self.node.restart()
