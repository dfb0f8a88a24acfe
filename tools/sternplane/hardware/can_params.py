"""`sternplane can params`: the parameters of a DroneCAN node."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from typing import Any

from firmware_py.adapters.buses.can_bus import BusError, CanBus
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.message_table import GET_SET, GET_SET_RESPONSE
from firmware_py.wire.dronecan.node_messages import Empty, GetSetRequest, GetSetResponse, NumericValue, Value
from firmware_py.wire.dronecan.transfer import Reassembler, TransferSender
from sternplane.hardware.node_names import TOOL_ID, NodeNames
from sternplane.hardware.output import Row, Sheet, console, show, show_json, text_of
from sternplane.hardware.shared_bus import shared_bus

_TRIES, _ANSWER_S = 4, 0.5
_MOST = 8192
"""Parameters have indices of 13 bits."""
_FRAMES = 1024
_NOTHING, _BOOLEAN = 0, 3
"""Tags of a value."""
_KINDS = ("", "int64", "float32", "bool", "text")


class Asking:
    """Asks one node, and listens to all.

    Attributes:
        names: who was heard meanwhile.
    """

    def __init__(self, bus: CanBus, node: int) -> None:
        self._bus, self._node = bus, node
        self._sender, self._answers = TransferSender(TOOL_ID), Reassembler([GET_SET_RESPONSE], TOOL_ID)
        self.names = NodeNames()

    def parameter(self, index: int) -> GetSetResponse | None:
        """Return a parameter; None if there was no answer, to any of several questions."""
        request = GetSetRequest(index, Value(_NOTHING, Empty()), b"")
        for _ in range(_TRIES):
            self._bus.send(self._sender.send(GET_SET, request, destination=self._node))
            answer = self._answer(time.monotonic() + _ANSWER_S)
            if answer is not None:
                return answer
        return None

    def _answer(self, deadline: float) -> GetSetResponse | None:
        while (left := deadline - (now := time.monotonic())) > 0.0:
            for can_id, data in self._bus.drain(_FRAMES, left):
                self.names.hear(can_id, data, now)
                answer = self._answers.accept(can_id, data, now)
                if answer is not None and answer.source == self._node:
                    try:
                        return GET_SET_RESPONSE.decode(answer.payload)
                    except DecodeError as error:
                        raise BusError(f"node {self._node}: its parameter cannot be read: {error}") from None
            self._bus.send(self.names.requests(now))
        return None


def command(options: argparse.Namespace) -> int:
    """List the parameters of a node; return 1 if it does not answer, or stops to."""
    out, found = console(), list[GetSetResponse]()
    with shared_bus(options.bus) as bus:
        asking = Asking(bus, options.node)
        for index in range(_MOST):
            answer = asking.parameter(index)
            if answer is None or not answer.name:
                break
            found.append(answer)
    complete = answer is not None
    if options.json:
        show_json(out, {"node": options.node, "complete": complete, "parameters": [*map(_plain, found)]})
    else:
        titles = ("index>", "name", "value>", "default>", "least>", "greatest>", "type")
        rows = [Row((f"{index}", *_cells(one))) for index, one in enumerate(found)]
        sheets = [Sheet(f"node {options.node}", titles, rows)] if rows else []
        show(out, sheets, _remarks(options.node, options.bus, complete, asking.names, len(found)))
    return 0 if complete else 1


def _remarks(node: int, bus: str, complete: bool, names: NodeNames, found: int) -> Iterator[str]:
    if complete and not found:
        yield f"node {node} has no parameters"
    elif not complete and found:
        yield f"node {node} does not answer any more after parameter {found - 1}: the list is not complete"
    elif not complete and node in names.nodes:
        yield f"node {names.described(node)} is there, but does not answer param.GetSet: many servos do not know it"
    elif not complete:
        yield f"node {node} does not answer, and was not heard on {bus}. Nodes heard: {names.listed()}"


def _cells(one: GetSetResponse) -> tuple[str, ...]:
    texts = [_text(one.value), _text(one.default_value), _text(one.min_value), _text(one.max_value)]
    return text_of(one.name), *texts, _KINDS[one.value.tag]


def _text(value: Value | NumericValue) -> str:
    plain = _plain_value(value)
    if isinstance(plain, bool):
        return "true" if plain else "false"
    if isinstance(plain, float):
        return f"{plain:.7g}"
    return "-" if plain is None else text_of(plain) if isinstance(plain, bytes) else f"{plain}"


def _plain(one: GetSetResponse) -> dict[str, Any]:
    return {
        "name": one.name,
        "value": _plain_value(one.value),
        "default": _plain_value(one.default_value),
        "least": _plain_value(one.min_value),
        "greatest": _plain_value(one.max_value),
        "type": _KINDS[one.value.tag],
    }


def _plain_value(value: Value | NumericValue) -> int | float | bool | bytes | None:
    content = value.value
    if isinstance(content, Empty):
        return None
    return bool(content) if value.tag == _BOOLEAN else content
