"""What every node answers when another asks: who it is, its parameters, what it has counted, whether it restarts.

Parameters are read only: a request to set one is answered with the value that it has. What is refused is said why, in a
LogMessage.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.node_messages import (
    Empty,
    ExecuteOpcodeResponse,
    GetNodeInfoResponse,
    GetSetRequest,
    GetSetResponse,
    GetTransportStatsResponse,
    HardwareVersion,
    LogLevel,
    LogMessage,
    NodeStatus,
    NumericValue,
    RestartNodeRequest,
    RestartNodeResponse,
    SoftwareVersion,
    Value,
)
from firmware_py.wire.dronecan.transfer import Frame, Transfer, TransferSender

SERVICES = (m.GET_NODE_INFO, m.GET_TRANSPORT_STATS, m.RESTART_NODE, m.EXECUTE_OPCODE, m.GET_SET)
"""The requests that are answered."""
MAGIC = RestartNodeRequest().magic_number
LOWEST = 30
"""Priority of what is said to people."""
MOST_PARAMETERS = 1 << 13
_WARNING = LogLevel(2)
_READ_ONLY = "parameters are read only: change them where the node is configured, and start it anew"


_NONE, _NO_NUMBER = Value(0, Empty()), NumericValue(0, Empty())


class Parameter(NamedTuple):
    """One parameter, as GetSet has it."""

    name: bytes
    value: Value
    default: Value = _NONE
    low: NumericValue = _NO_NUMBER
    high: NumericValue = _NO_NUMBER


class Identity(NamedTuple):
    """Who a node is; it does not change while it runs."""

    name: bytes
    software: SoftwareVersion
    hardware: HardwareVersion


NO_PARAMETER = GetSetResponse(_NONE, _NONE, _NO_NUMBER, _NO_NUMBER, b"")


class NodeServices:
    """Keeps the latest request of each kind and node, and answers one at a time, the oldest first.

    Args:
        sender: of the node.
        identity: what GetNodeInfo returns, with the status.
        parameters: what GetSet returns.
        restart: called for a RestartNode; returns why not, or "" if the node will.
    """

    def __init__(
        self,
        sender: TransferSender,
        identity: Identity,
        parameters: Sequence[Parameter],
        restart: Callable[[], str],
    ) -> None:
        self._sender, self._identity, self._restart = sender, identity, restart
        self._parameters = tuple(parameters[:MOST_PARAMETERS])
        self._by_name = {one.name: one for one in self._parameters}
        self._requests: dict[tuple[int, int], Transfer] = {}
        self.malformed = 0
        """Requests whose payload did not fit their type."""

    def hear(self, request: Transfer) -> None:
        """Take a request of a kind of SERVICES."""
        self._requests[request.source, request.kind.data_type_id] = request

    @property
    def waiting(self) -> bool:
        """Return whether there is a request to answer."""
        return bool(self._requests)

    def answer(self, status: NodeStatus, stats: Callable[[], GetTransportStatsResponse]) -> list[Frame]:
        """Return the frames of the answer to the oldest request; none if there is none, or it is malformed."""
        if not self._requests:
            return []
        request = self._requests.pop(next(iter(self._requests)))
        try:
            asked = request.kind.decode(request.payload)
        except DecodeError:
            self.malformed += 1
            return []
        respond = self._sender.respond
        if request.kind is m.GET_NODE_INFO:
            name, software, hardware = self._identity
            info = GetNodeInfoResponse(status, software, hardware, name)
            return respond(request, m.GET_NODE_INFO_RESPONSE, info)
        if request.kind is m.GET_TRANSPORT_STATS:
            return respond(request, m.GET_TRANSPORT_STATS_RESPONSE, stats())
        if request.kind is m.GET_SET:
            return respond(request, m.GET_SET_RESPONSE, self._parameter(asked))
        if request.kind is m.EXECUTE_OPCODE:
            return respond(request, m.EXECUTE_OPCODE_RESPONSE, ExecuteOpcodeResponse(0, False)) + self.said(_READ_ONLY)
        why = self._restart() if asked.magic_number == MAGIC else "restart refused: wrong magic number"
        answer = respond(request, m.RESTART_NODE_RESPONSE, RestartNodeResponse(not why))
        return answer + self.said(why) if why else answer

    def said(self, sentence: str) -> list[Frame]:
        """Return the frames of a sentence for people."""
        message = LogMessage(_WARNING, self._identity.name[-31:], sentence.encode()[:90])
        return self._sender.send(m.LOG_MESSAGE, message, LOWEST)

    def _parameter(self, asked: GetSetRequest) -> GetSetResponse:
        """Return the parameter of a name, or of an index if there is none; an empty one if it is not there."""
        found = self._by_name.get(asked.name) if asked.name else None
        if not asked.name and asked.param_index < len(self._parameters):
            found = self._parameters[asked.param_index]
        if found is None:
            return NO_PARAMETER
        return GetSetResponse(found.value, found.default, found.high, found.low, found.name)
