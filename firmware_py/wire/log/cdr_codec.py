"""Records to CDR bytes and back; the layout follows from the types of the records.

Every float is a float64 and keeps all its bits, every int an int64, an enum an int8; a tuple has the length that it has
in the sample, unless it is of strings or its field is marked `ANY_LENGTH`: such a one comes last, and `sequences`
encodes it; a field marked `BESIDE` is left out. The code of each codec is generated (`wire.code_generator`): one
read of every attribute, one `struct.pack` for the some 150 numbers of a cycle.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import itertools
import re
import struct
import types
import typing
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Generic, TypeVar

from firmware_py.records.order import ANY_LENGTH, BESIDE
from firmware_py.wire.code_generator import Names, compile_function, function_source
from firmware_py.wire.log import ros2_schema, sequences
from firmware_py.wire.log.ros2_schema import (
    ENCAPSULATION,
    Layout,
    Node,
    Record,
    Scalar,
    SchemaArray,
    SchemaError,
    Sequence,
    Text,
)

R = TypeVar("R")
Count = Callable[[str], int]
"""The length of the tuple at a path."""

_FIELD_NAME = re.compile("[a-z][a-z0-9_]*")
_SCALARS: Mapping[Any, str] = {bool: "bool", int: "int64", float: "float64"}


class CdrCodec(Generic[R]):
    """Encoder and decoder of one type of record.

    Attributes:
        name: the message's name in a log, "sternplane/msg/Cycle".
        schema: its `ros2msg` text.
        layout: the place of each number.
        encode: record -> bytes. Raises ValueError or struct.error where a tuple's length or a type is not the sample's.
        decode: bytes -> an equal record.
    """

    def __init__(self, cls: type[R], count: Count) -> None:
        root = _node(cls, count, "")
        if not isinstance(root, Record):
            raise SchemaError(f"{cls.__name__} is not a record")
        self.name = f"{ros2_schema.PACKAGE}/msg/{root.name}"
        self.schema = ros2_schema.text(root)
        self.layout = Layout(root)
        self.encode: Callable[[R], bytes] = _encoder(self.layout)
        self.decode: Callable[[bytes], R] = _decoder(self.layout)

    @classmethod
    def like(cls, sample: R) -> CdrCodec[R]:
        """Return the codec of all records whose tuples are as long as the sample's."""

        def count(path: str) -> int:
            value: Any = sample
            for name in path.split("."):
                value = getattr(value[0] if type(value) is tuple else value, name)
            return len(value)

        return cls(type(sample), count)

    @classmethod
    def of(cls, record: type[R], schema: str) -> CdrCodec[R]:
        """Return the codec of the records in a log.

        Raises:
            SchemaError: if the records have changed since that schema was written.
        """
        counts = dict(_counts(ros2_schema.parse_schema(record.__name__, schema), ""))
        codec = cls(record, lambda path: counts.get(path, 0))
        if codec.schema != schema:
            raise SchemaError(f"the record {record.__name__} differs from that of this version")
        return codec


def closing_records(cls: type[R], layout: Layout) -> Callable[[bytes], tuple[R, ...]]:
    """Return a function: bytes of a message -> the records of that type which it ends with.

    Raises:
        SchemaError: the messages do not end with them, or they have changed since that layout was written.
    """
    item, logged = _node(cls, _no_sample, "", loose=True), layout.closing_item
    if item != logged:
        raise SchemaError(f"the record {cls.__name__} is not the one of today")
    return lambda message: sequences.decode(item, message, layout.size)


def _no_sample(path: str) -> int:
    raise SchemaError(f"{path} has no sample")


def _node(hint: Any, count: Count, path: str, *, loose: bool = False) -> Node:
    """Return the schema node of a type.

    Args:
        hint: the type.
        count: gives the length of a tuple by its path.
        path: of the field, for errors.
        loose: tuples have any length.
    """
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if hint is str:
        return Text()
    if hint in _SCALARS:
        return Scalar(_SCALARS[hint])
    if isinstance(hint, type) and issubclass(hint, enum.IntEnum):
        return Scalar("int8", hint)
    if origin in (typing.Union, types.UnionType) and len(args) == 2 and args[1] is type(None):
        inner = _node(args[0], count, path, loose=loose)
        if isinstance(inner, Scalar) and inner.enum is not None:
            return Scalar("int8", inner.enum, optional=True)
    if args == (str, ...) or (loose and origin is tuple and args[-1] is ...):
        return Sequence(_node(args[0], count, path, loose=True))
    if origin is tuple and len(set(args) - {...}) == 1:
        item = _node(args[0], count, path, loose=loose)
        if isinstance(item, Scalar | Record):
            return SchemaArray(item, count(path) if args[-1] is ... else len(args))
    cls = origin or hint
    if isinstance(cls, type) and (dataclasses.is_dataclass(cls) or hasattr(cls, "_fields")):
        return _record(cls, args, count, path, loose)
    raise SchemaError(f"{path}: {hint} cannot be logged")


def _record(cls: Any, args: tuple[Any, ...], count: Count, path: str, loose: bool) -> Record:
    """Return a dataclass or NamedTuple; a generic one with its parameters filled in is a message, HeardFloat."""
    hints = typing.get_type_hints(cls)
    filled = dict(zip(cls.__parameters__, args, strict=True)) if args else {}
    if dataclasses.is_dataclass(cls):
        names = [f.name for f in dataclasses.fields(cls) if BESIDE not in f.metadata]
        any_length = {f.name for f in dataclasses.fields(cls) if ANY_LENGTH in f.metadata}
    else:
        names, any_length = cls._fields, set()
    fields: list[tuple[str, Node]] = []
    for name in names:
        if not _FIELD_NAME.fullmatch(name):
            raise SchemaError(f"{cls.__name__}.{name}: ROS 2 demands field names in lower case")
        inner = f"{path}.{name}" if path else name
        hint = filled.get(hints[name], hints[name])
        fields.append((name, _node(hint, count, inner, loose=loose or name in any_length)))
    return Record(cls.__name__ + "".join(a.__name__.capitalize() for a in args), tuple(fields), cls)


def _counts(node: Node, path: str) -> Iterator[tuple[str, int]]:
    if isinstance(node, SchemaArray):
        yield path, node.count
        node = node.item
    for name, inner in node.fields if isinstance(node, Record) else ():
        yield from _counts(inner, f"{path}.{name}" if path else name)


def _encoder(layout: Layout) -> Callable[[Any], bytes]:
    """Return the function of a source like: `a0 = record.tick; ...; return pack(START, a0.k, a0.dt_ns, ..., *a2)`."""
    names = Names(pack=struct.Struct(layout.format).pack, START=ENCAPSULATION)
    lines: list[str] = []
    values = ["START"]
    tail: list[str] = []

    def take(node: Node, value: str) -> None:
        if isinstance(node, Scalar):
            values.append(f"(-1 if {value} is None else {value})" if node.optional else value)
        elif isinstance(node, SchemaArray):
            items = [names.variable("a") for _ in range(node.count)]
            lines.append(f"[{', '.join(items)}] = {value}")
            for item in items:
                take(node.item, item)
        elif isinstance(node, Record):
            if issubclass(node.cls, tuple) and all(isinstance(f, Scalar) and not f.optional for _, f in node.fields):
                values.append(f"*{value}")
                return
            name = names.variable("a")
            lines.append(f"{name} = {value}")
            for field, inner in node.fields:
                take(inner, f"{name}.{field}")
        else:
            name = names.variable("a")
            lines.append(f"{name} = {value}")
            values.append(f"len({name})")
            tail.append(f" + closing({name}) if {name} else ")

    take(layout.root, "record")
    packed = f"pack({', '.join(values)})"
    lines.append(f"return {packed}{tail[0]}{packed}" if tail else f"return {packed}")
    if layout.closing_item is not None:
        names.objects["closing"] = functools.partial(_encoded, layout.closing_item, layout.size)
    return compile_function(function_source("encode", "record", lines), "encode", names)


def _decoder(layout: Layout) -> Callable[[bytes], Any]:
    """Return the function of a source like: `v = unpack(data); return R1(tick=R2(k=v[1], dt_ns=v[2], ...), ...)`."""
    names = Names(unpack=struct.Struct(layout.format).unpack_from)
    if layout.closing_item is not None:
        names.objects["closing"] = functools.partial(_decoded, layout.closing_item, layout.size)
    place = itertools.count(1)

    def make(node: Node) -> str:
        if isinstance(node, Scalar):
            value = f"v[{next(place)}]"
            if node.enum is None:
                return value
            members = {int(member): member for member in node.enum} | ({-1: None} if node.optional else {})
            return f"{names.constant('E', members)}[{value}]"
        if isinstance(node, SchemaArray):
            return f"({''.join(make(node.item) + ', ' for _ in range(node.count))})"
        if isinstance(node, Record):
            fields = ", ".join(f"{name}={make(inner)}" for name, inner in node.fields)
            return f"{names.constant('R', node.cls)}({fields})"
        return "closing(data)"

    lines = ["v = unpack(data)", f"return {make(layout.root)}"]
    return compile_function(function_source("decode", "data", lines), "decode", names)


def _encoded(item: Node, size: int, values: tuple[Any, ...]) -> bytes:
    return sequences.encode(item, values, size)


def _decoded(item: Node, size: int, data: bytes) -> tuple[Any, ...]:
    return sequences.decode(item, data, size)
