"""What every DroneCAN node aboard does: says once a second that it lives, and who it is when asked."""

from __future__ import annotations

from typing import TypeVar

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.wire.dronecan.messages import GET_NODE_INFO, GET_NODE_INFO_RESPONSE, NODE_STATUS, MessageType
from firmware_py.wire.dronecan.protocol import GetNodeInfoResponse, HardwareVersion, NodeStatus, SoftwareVersion
from firmware_py.wire.dronecan.transfer import Reassembler, Sender, Transfer

R = TypeVar("R")
VENDOR = "org.sternplane.sim."


class Node:
    """One device's place on the bus. Without power it says nothing and hears nothing."""

    def __init__(self, node_id: int, name: str, bus: FramePort) -> None:
        self.node_id = node_id
        self.name = VENDOR + name
        self.powered = True
        self._bus = bus
        self._sender = Sender(node_id)
        self._requests = Reassembler([GET_NODE_INFO], node_id)

    def publish(self, message: MessageType[R], value: R) -> None:
        """Broadcasts a message."""
        if self.powered:
            self._bus.send(self._sender.send(message, value))

    def beat(self, t: float) -> None:
        """NodeStatus; wanted once a second."""
        self.publish(NODE_STATUS, NodeStatus(int(t)))

    def serve(self, can_id: int, data: bytes, t: float) -> None:
        """Takes a frame of a service that is addressed to this node."""
        request = self._requests.accept(can_id, data, t)
        if request is not None and self.powered:
            self._introduce(request, t)

    def _introduce(self, request: Transfer, t: float) -> None:
        """Answers GetNodeInfo, which asks nothing; the unique id is the end of the name."""
        name = self.name.encode()
        hardware = HardwareVersion(major=1, unique_id=name[-16:].rjust(16, b"\0"))
        info = GetNodeInfoResponse(NodeStatus(int(t)), SoftwareVersion(major=1), hardware, name)
        self._bus.send(self._sender.respond(request, GET_NODE_INFO_RESPONSE, info))
