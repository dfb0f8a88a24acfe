"""Encodes standard messages as ROS 2 does: classic CDR, little-endian (OMG DDSI-RTPS 2.2, 10.2).

The log's own codec knows records whose layout is fixed; these have texts and lists anywhere. A message is given as its
numbers and texts one after the other, in the order of its definition: neighbours of one kind are packed at once.
"""

from __future__ import annotations

import itertools
import re
import struct
from collections.abc import Iterator
from typing import Any, NamedTuple, TypeAlias

from firmware_py.wire.log.ros2_schema import ENCAPSULATION
from sternplane.logs.export.message_definitions import fields, full_name, schema

_CODES = {
    "bool": "?",
    "int8": "b",
    "uint8": "B",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "float32": "f",
    "float64": "d",
}
_TYPE = re.compile(r"([\w/]+)(?:\[(\d*)\])?")
_COUNT = struct.Struct("<I")


class _Numbers(NamedTuple):
    """Numbers of one kind, back to back."""

    code: str
    length: int


class _Text(NamedTuple):
    """A string."""


class _Items(NamedTuple):
    """Any number of what a plan describes."""

    plan: Plan


Plan: TypeAlias = tuple[_Numbers | _Text | _Items, ...]


class CdrMessage:
    """The encoder of one message, such as "nav_msgs/Odometry".

    Attributes:
        name: as ROS 2 writes it.
        schema: its definition.
    """

    def __init__(self, name: str) -> None:
        self.name, self.schema = full_name(name), schema(name)
        self._plan = _merged(_plan(name))

    def encode(self, *values: Any) -> bytes:
        """Encode a message from its numbers and texts in their order.

        A list is one value: of numbers, of texts, or of tuples that hold what each of its records has.
        """
        data = bytearray()
        _write(self._plan, iter(values), data)
        return ENCAPSULATION + data


def _plan(name: str) -> Iterator[_Numbers | _Text | _Items]:
    for kind, _ in fields(name):
        match = _TYPE.fullmatch(kind)
        assert match is not None
        item, count = match.groups()
        inner = tuple(_item(item))
        if count == "":
            yield _Items(_merged(iter(inner)))
        else:
            yield from inner * int(count or 1)


def _item(kind: str) -> Iterator[_Numbers | _Text | _Items]:
    if kind == "string":
        yield _Text()
    elif kind in _CODES:
        yield _Numbers(_CODES[kind], 1)
    else:
        yield from _plan(kind)


def _merged(parts: Iterator[_Numbers | _Text | _Items]) -> Plan:
    """Return a plan in which neighbours of one kind are one."""
    plan: list[_Numbers | _Text | _Items] = []
    for part in parts:
        last = plan[-1] if plan else None
        if isinstance(part, _Numbers) and isinstance(last, _Numbers) and part.code == last.code:
            plan[-1] = _Numbers(part.code, last.length + part.length)
        else:
            plan.append(part)
    return tuple(plan)


def _write(plan: Plan, values: Iterator[Any], data: bytearray) -> None:
    for part in plan:
        if isinstance(part, _Numbers):
            _write_numbers(part.code, list(itertools.islice(values, part.length)), data)
        elif isinstance(part, _Text):
            _write_text(next(values), data)
        else:
            _write_items(part.plan, next(values), data)


def _write_items(plan: Plan, items: Any, data: bytearray) -> None:
    data += bytes(-len(data) % 4) + _COUNT.pack(len(items))
    only = plan[0] if len(plan) == 1 else None
    if isinstance(only, _Numbers) and only.length == 1:
        if items:  # an empty list is not followed by what would align its first item
            _write_numbers(only.code, items, data)
    else:
        for item in items:
            _write(plan, iter((item,) if isinstance(only, _Text) else item), data)


def _write_numbers(code: str, values: Any, data: bytearray) -> None:
    data += bytes(-len(data) % struct.calcsize(f"<{code}"))
    data += struct.pack(f"<{len(values)}{code}", *values)


def _write_text(value: str, data: bytearray) -> None:
    raw = value.encode("utf-8", "replace") + b"\0"
    data += bytes(-len(data) % 4) + _COUNT.pack(len(raw)) + raw
