"""`sternplane can params`: the parameters of a DroneCAN node, listed or set."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from firmware_py.adapters.drivers.dronecan.node_client import SAVE, NodeClient
from firmware_py.error_text import quoted, shortened
from firmware_py.foreign_text import text_or_hex
from firmware_py.run.usage_error import UsageError
from firmware_py.wire.dronecan.node_messages import Empty, GetSetRequest, GetSetResponse, NumericValue, Value
from sternplane.hardware.bus_nodes import BusNodes
from sternplane.hardware.can_node import client_of, no_answer
from sternplane.hardware.output import Row, Sheet, console, show, show_json
from sternplane.hardware.shared_bus import shared_bus

_NOTHING, _INTEGER, _REAL, _BOOLEAN, _TEXT = range(5)
"""Tags of a value."""
_KINDS = ("", "int64", "float32", "bool", "text")
_LONGEST_NAME, _LONGEST_TEXT = 92, 128
"""Bytes."""
_LARGEST_INTEGER, _LARGEST_REAL = 2**63 - 1, 3.4028235e38
"""What is beyond would be sent as these."""


def command(options: argparse.Namespace) -> int:
    """List the parameters of a node, or set some; return 1 if it does not answer, stops to, or does not take one.

    Raises:
        UsageError: a parameter or a value that cannot be.
    """
    out, nodes = console(), BusNodes()
    if options.set:
        with shared_bus(options.bus) as bus:
            return _set(options, client_of(bus, nodes), nodes)
    if options.save:
        raise UsageError("--save keeps what --set NAME=VALUE sets: give one")
    with shared_bus(options.bus) as bus:
        answers = [*client_of(bus, nodes).parameters(options.node)]
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
    elif not complete:
        yield no_answer(node, bus, nodes, "param.GetSet")


def _set(options: argparse.Namespace, client: NodeClient, nodes: BusNodes) -> int:
    wanted = [_pair(text) for text in options.set]
    said, taken = [], True
    for name, text in wanted:
        before = client.parameter(options.node, GetSetRequest(0, Value(_NOTHING, Empty()), name.encode()))
        if before is None:
            said.append(no_answer(options.node, options.bus, nodes, "param.GetSet"))
            taken = False
            break
        if not before.name:
            raise UsageError(f"--set {name}: node {options.node} has no such parameter; without --set all are listed")
        value = _value(name, text, before.value.tag)
        after = client.parameter(options.node, GetSetRequest(0, value, name.encode()))
        is_so = after is not None and _text(after.value) == _text(value)
        now = "does not answer" if after is None else f"is {_text(after.value)}"
        said.append(f"{name} {now}, was {_text(before.value)}" + ("" if is_so else f"; not taken: {text}"))
        taken = taken and is_so
    if options.save and taken:
        saved = client.execute(options.node, SAVE)
        taken = saved is not None and saved.ok
        said.append("saved" if taken else f"node {options.node} does not save it: it is gone when the node restarts")
    if options.json:
        show_json(console(), {"node": options.node, "taken": taken, "said": said})
    else:
        show(console(), [], said)
    return 0 if taken else 1


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise UsageError(f"--set {quoted(text)}: write NAME=VALUE")
    for what, part, most in (("name", name, _LONGEST_NAME), ("value", value, _LONGEST_TEXT)):
        if not part.isprintable():
            raise UsageError(f"--set {quoted(text)}: a {what} has printable characters only")
        if len(part.encode()) > most:
            raise UsageError(f"--set {quoted(text)}: a {what} has at most {most} bytes")
    return name, value


def _value(name: str, text: str, tag: int) -> Value:
    """Return a value of the type that a parameter has.

    Raises:
        UsageError: it cannot be one.
    """
    try:
        if tag == _INTEGER and abs(whole := int(text)) <= _LARGEST_INTEGER:
            return Value(tag, whole)
        if tag == _REAL and abs(real := float(text)) <= _LARGEST_REAL:
            return Value(tag, real)
        if tag == _BOOLEAN:
            return Value(tag, {"false": 0, "0": 0, "true": 1, "1": 1}[text.lower()])
    except (ValueError, KeyError):
        pass
    if tag not in (_TEXT, _NOTHING):
        raise UsageError(f"--set {shortened(f'{name}={text}')}: must be of type {_KINDS[tag]}")
    return Value(_TEXT, text.encode())


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
