"""The sequence that a message ends with: strings, numbers, or records that may have sequences of their own.

What is before it has a fixed layout and generated code (`cdr_codec`). A sequence is rare and of any length, so its
tree is walked. In CDR it is a count (uint32) and the items, each aligned to its own size; a string is its length with
the closing zero (uint32), UTF-8, the zero.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence as Items
from typing import Any

from firmware_py.wire.log.ros2_schema import (
    CODES,
    ENCAPSULATION,
    SIZES,
    Node,
    Record,
    Scalar,
    SchemaArray,
    SchemaError,
    Sequence,
)

_COUNT = struct.Struct("<I")
_START = len(ENCAPSULATION)
"""Alignment is counted from behind these bytes."""


def encode(item: Node, values: Items[Any], start: int) -> bytes:
    """Encode the values, whose first byte comes `start` bytes from the message's first; their count stands before."""
    data = bytearray()
    _write_all(item, values, data, start - _START)
    return bytes(data)


def decode(item: Node, message: bytes, start: int) -> tuple[Any, ...]:
    """Decode the values of a message, whose count ends where `start` says; a record without a class is a dict."""
    (count,) = _COUNT.unpack_from(message, start - _COUNT.size)
    return _read_all(item, count, message, start)[0]


def _write_all(item: Node, values: Items[Any], data: bytearray, base: int) -> None:
    if isinstance(item, Scalar) and item.enum is None and values:
        code = CODES[item.kind]
        _pad(data, base, SIZES[code])
        data += struct.pack(f"<{len(values)}{code}", *values)
        return
    for value in values:
        _write(item, value, data, base)


def _write(node: Node, value: Any, data: bytearray, base: int) -> None:
    if isinstance(node, Scalar):
        code = CODES[node.kind]
        _pad(data, base, SIZES[code])
        data += struct.pack(f"<{code}", -1 if value is None else value)
    elif isinstance(node, Record):
        for name, inner in node.fields:
            _write(inner, getattr(value, name), data, base)
    elif isinstance(node, Sequence):
        _count(len(value), data, base)
        _write_all(node.item, value, data, base)
    elif isinstance(node, SchemaArray):
        raise SchemaError("an array of fixed length in a sequence")
    else:
        raw = value.encode("utf-8", "replace") + b"\0"
        _count(len(raw), data, base)
        data += raw


def _count(count: int, data: bytearray, base: int) -> None:
    _pad(data, base, _COUNT.size)
    data += _COUNT.pack(count)


def _pad(data: bytearray, base: int, size: int) -> None:
    data += bytes(-(base + len(data)) % size)


def _read_all(item: Node, count: int, data: bytes, at: int) -> tuple[tuple[Any, ...], int]:
    if isinstance(item, Scalar) and item.enum is None and count:
        code = CODES[item.kind]
        at = _aligned(at, SIZES[code])
        return struct.unpack_from(f"<{count}{code}", data, at), at + count * SIZES[code]
    values = []
    for _ in range(count):
        value, at = _read(item, data, at)
        values.append(value)
    return tuple(values), at


def _read(node: Node, data: bytes, at: int) -> tuple[Any, int]:
    if isinstance(node, Scalar):
        code = CODES[node.kind]
        at = _aligned(at, SIZES[code])
        (value,) = struct.unpack_from(f"<{code}", data, at)
        if node.enum is not None:
            value = None if node.optional and value == -1 else node.enum(value)
        return value, at + SIZES[code]
    if isinstance(node, Record):
        fields: dict[str, Any] = {}
        for name, inner in node.fields:
            fields[name], at = _read(inner, data, at)
        return (fields if node.cls is None else node.cls(**fields)), at
    if isinstance(node, Sequence):
        count, at = _counted(data, at)
        return _read_all(node.item, count, data, at)
    if isinstance(node, SchemaArray):
        raise SchemaError("an array of fixed length in a sequence")
    length, at = _counted(data, at)
    return data[at : at + length - 1].decode(), at + length


def _counted(data: bytes, at: int) -> tuple[int, int]:
    at = _aligned(at, _COUNT.size)
    return _COUNT.unpack_from(data, at)[0], at + _COUNT.size


def _aligned(at: int, size: int) -> int:
    return at + -(at - _START) % size
