"""`sternplane can params`: the parameters of a DroneCAN node."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from firmware_py.adapters.drivers.dronecan.node_client import NodeClient
from firmware_py.foreign_text import text_or_hex
from firmware_py.wire.dronecan.node_messages import Empty, GetSetResponse, NumericValue, Value
from sternplane.hardware.bus_nodes import BusNodes
from sternplane.hardware.output import Row, Sheet, console, show, show_json
from sternplane.hardware.shared_bus import shared_bus

_BOOLEAN = 3
"""Tag of a value."""
_KINDS = ("", "int64", "float32", "bool", "text")


def command(options: argparse.Namespace) -> int:
    """List the parameters of a node; return 1 if it does not answer, or stops to."""
    out, nodes = console(), BusNodes()
    with shared_bus(options.bus) as bus:

        def overhear(can_id: int, data: bytes, t: float) -> None:
            nodes.hear(can_id, data, t)
            bus.send(nodes.requests(t))

        answers = [*NodeClient(bus, overhear=overhear).parameters(options.node)]
    found = [answer for answer in answers if answer is not None]
    complete = len(found) == len(answers)
    if options.json:
        show_json(out, {"node": options.node, "complete": complete, "parameters": [*map(_plain, found)]})
    else:
        titles = ("index>", "name", "value>", "default>", "least>", "greatest>", "type")
        rows = [Row((f"{index}", *_cells(one))) for index, one in enumerate(found)]
        sheets = [Sheet(f"node {options.node}", titles, rows)] if rows else []
        show(out, sheets, _remarks(options.node, options.bus, complete, nodes, len(found)))
    return 0 if complete else 1


def _remarks(node: int, bus: str, complete: bool, nodes: BusNodes, found: int) -> Iterator[str]:
    if complete and not found:
        yield f"node {node} has no parameters"
    elif not complete and found:
        yield f"node {node} does not answer any more after parameter {found - 1}: the list is not complete"
    elif not complete and node in nodes.t_heard:
        yield f"node {nodes.described(node)} is there, but does not answer param.GetSet: many servos do not know it"
    elif not complete:
        yield f"node {node} does not answer, and was not heard on {bus}. Nodes heard: {nodes.listed()}"


def _cells(one: GetSetResponse) -> tuple[str, ...]:
    texts = [_text(one.value), _text(one.default_value), _text(one.min_value), _text(one.max_value)]
    return text_or_hex(one.name), *texts, _KINDS[one.value.tag]


def _text(value: Value | NumericValue) -> str:
    plain = _plain_value(value)
    if isinstance(plain, bool):
        return "true" if plain else "false"
    if isinstance(plain, float):
        return f"{plain:.7g}"
    return "-" if plain is None else text_or_hex(plain) if isinstance(plain, bytes) else f"{plain}"


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
