"""Questions of a bench tool to a node: its parameters, its counts, a restart. It waits, as nothing does in flight."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Protocol, TypeVar

from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.message_table import MessageType
from firmware_py.wire.dronecan.node_messages import (
    Empty,
    ExecuteOpcodeRequest,
    ExecuteOpcodeResponse,
    GetSetRequest,
    GetSetResponse,
    GetTransportStatsRequest,
    GetTransportStatsResponse,
    RestartNodeRequest,
    RestartNodeResponse,
    Value,
)
from firmware_py.wire.dronecan.node_services import MOST_PARAMETERS
from firmware_py.wire.dronecan.transfer import Frame, Reassembler, TransferSender

R = TypeVar("R")
S = TypeVar("S")

TOOL_ID = 126
"""The node id of tools: DroneCAN reserves it for them."""
SAVE, ERASE = 0, 1
"""Of `execute`."""
_TRIES, _ANSWER = 3, 0.5
"""So often a question is asked, and so long an answer is waited for, s."""
_FRAMES = 1024
_EMPTY = Value(0, Empty())
_ANSWERS = (m.GET_SET_RESPONSE, m.EXECUTE_OPCODE_RESPONSE, m.RESTART_NODE_RESPONSE, m.GET_TRANSPORT_STATS_RESPONSE)


class WaitingBus(Protocol):
    """What a client uses of a bus."""

    def drain(self, limit: int, seconds: float) -> list[Frame]:
        """Return what has come; wait for the first frame, for at most so long."""

    def send(self, frames: list[Frame], /) -> None:
        """Send frames."""


class NodeClient:
    """Asks the nodes of a bus, one question at a time; None is: no answer, to any of three.

    Args:
        bus: its end of the bus.
        node_id: under which it asks.
        overhear: is given every frame that comes meanwhile, with the time of `time.monotonic`: for a monitor.
    """

    def __init__(
        self,
        bus: WaitingBus,
        node_id: int = TOOL_ID,
        overhear: Callable[[int, bytes, float], None] = lambda _can_id, _data, _t: None,
    ) -> None:
        self._bus, self._overhear = bus, overhear
        self._sender, self._answers = TransferSender(node_id), Reassembler(_ANSWERS, node_id)

    def parameters(self, node: int) -> Iterator[GetSetResponse | None]:
        """Yield the parameters of a node; None, as the last, if it stops to answer before their end."""
        for index in range(MOST_PARAMETERS):
            one = self.parameter(node, GetSetRequest(index, _EMPTY, b""))
            if one is not None and not one.name:
                return
            yield one
            if one is None:
                return

    def parameter(self, node: int, asked: GetSetRequest) -> GetSetResponse | None:
        """Return a parameter, by name or index; set before, if a value is given. The answer has what it is then."""
        return self._ask(node, m.GET_SET, asked, m.GET_SET_RESPONSE)

    def execute(self, node: int, opcode: int) -> ExecuteOpcodeResponse | None:
        """Have a node SAVE or ERASE its parameters; return whether it did."""
        return self._ask(node, m.EXECUTE_OPCODE, ExecuteOpcodeRequest(opcode), m.EXECUTE_OPCODE_RESPONSE)

    def restart(self, node: int) -> RestartNodeResponse | None:
        """Have a node restart; return whether it will. One that does so at once does not answer."""
        return self._ask(node, m.RESTART_NODE, RestartNodeRequest(), m.RESTART_NODE_RESPONSE, tries=1)

    def statistics(self, node: int) -> GetTransportStatsResponse | None:
        """Return what a node has counted on the bus."""
        return self._ask(node, m.GET_TRANSPORT_STATS, GetTransportStatsRequest(), m.GET_TRANSPORT_STATS_RESPONSE)

    def _ask(
        self, node: int, kind: MessageType[R], question: R, answer: MessageType[S], tries: int = _TRIES
    ) -> S | None:
        for _ in range(tries):
            frames = self._sender.send(kind, question, destination=node)
            self._bus.send(frames)
            heard = self._wait(node, answer, frames[0][1][-1] & 31)
            if heard is not None:
                return heard
        return None

    def _wait(self, node: int, kind: MessageType[S], transfer_id: int) -> S | None:
        """Return the answer with this transfer id; None if it does not come in time, or is none."""
        deadline = time.monotonic() + _ANSWER
        while (left := deadline - (now := time.monotonic())) > 0.0:
            for can_id, data in self._bus.drain(_FRAMES, left):
                self._overhear(can_id, data, now)
                heard = self._answers.accept(can_id, data, now)
                if heard is None or (heard.source, heard.kind, heard.transfer_id) != (node, kind, transfer_id):
                    continue
                try:
                    return kind.decode(heard.payload)
                except DecodeError:
                    return None
        return None
