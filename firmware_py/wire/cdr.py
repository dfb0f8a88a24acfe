"""Records to bytes and back, without a schema of their own: the layout follows from the records' types.

Every float is a float64 and keeps all its bits, every int an int64, an enum an int8; a tuple has the length that it has
in the sample; a field marked `BESIDE` is left out. The code of each codec is generated, because a cycle has some 150
numbers and the loop has no time for walking a tree of them: one read of every attribute, one `struct.pack`.
"""

from __future__ import annotations

import dataclasses
import enum
import itertools
import re
import struct
import types
import typing
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Generic, TypeVar

from firmware_py.records.order import BESIDE
from firmware_py.wire import ros2msg
from firmware_py.wire.ros2msg import ENCAPSULATION, Array, Layout, Node, Record, Scalar, SchemaError, Texts

R = TypeVar("R")
Count = Callable[[str], int]
"""How long the tuple at a path is."""

_FIELD_NAME = re.compile("[a-z][a-z0-9_]*")
_SCALARS: Mapping[Any, str] = {bool: "bool", int: "int64", float: "float64"}


class Codec(Generic[R]):
    """Encodes and decodes one type of record.

    Attributes:
        name: the message's name in a log, "sternplane/msg/Cycle".
        schema: its `ros2msg` text.
        layout: where each number stands.
        encode: record -> bytes. Raises ValueError or struct.error where a tuple's length or a type is not the sample's.
        decode: bytes -> an equal record.
    """

    def __init__(self, cls: type[R], count: Count) -> None:
        root = _node(cls, count, "")
        if not isinstance(root, Record):
            raise SchemaError(f"{cls.__name__} is not a record")
        self.name = f"{ros2msg.PACKAGE}/msg/{root.name}"
        self.schema = ros2msg.text(root)
        self.layout = Layout(root)
        self.encode: Callable[[R], bytes] = _encoder(self.layout)
        self.decode: Callable[[bytes], R] = _decoder(self.layout)

    @classmethod
    def like(cls, sample: R) -> Codec[R]:
        """The codec of all records whose tuples are as long as the sample's."""

        def count(path: str) -> int:
            value: Any = sample
            for name in path.split("."):
                value = getattr(value[0] if type(value) is tuple else value, name)
            return len(value)

        return cls(type(sample), count)

    @classmethod
    def of(cls, record: type[R], schema: str) -> Codec[R]:
        """The codec of the records in a log.

        Raises:
            SchemaError: if the records have changed since that schema was written.
        """
        counts = dict(_counts(ros2msg.parse(record.__name__, schema), ""))
        codec = cls(record, lambda path: counts.get(path, 0))
        if codec.schema != schema:
            raise SchemaError(f"the record {record.__name__} is not the one of today")
        return codec


def _node(hint: Any, count: Count, path: str) -> Node:
    """The node of a type; `count` tells the length of a tuple by its path."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if hint in _SCALARS:
        return Scalar(_SCALARS[hint])
    if isinstance(hint, type) and issubclass(hint, enum.IntEnum):
        return Scalar("int8", hint)
    if origin in (typing.Union, types.UnionType) and len(args) == 2 and args[1] is type(None):
        inner = _node(args[0], count, path)
        if isinstance(inner, Scalar) and inner.enum is not None:
            return Scalar("int8", inner.enum, optional=True)
    if args == (str, ...):
        return Texts()
    if origin is tuple and len(set(args) - {...}) == 1:
        item = _node(args[0], count, path)
        if isinstance(item, Scalar | Record):
            return Array(item, count(path) if args[-1] is ... else len(args))
    cls = origin or hint
    if isinstance(cls, type) and (dataclasses.is_dataclass(cls) or hasattr(cls, "_fields")):
        return _record(cls, args, count, path)
    raise SchemaError(f"{path}: {hint} cannot be logged")


def _record(cls: Any, args: tuple[Any, ...], count: Count, path: str) -> Record:
    """A dataclass or NamedTuple; a generic one with its parameters filled in is a message of its own, HeardFloat."""
    hints = typing.get_type_hints(cls)
    filled = dict(zip(cls.__parameters__, args, strict=True)) if args else {}
    if dataclasses.is_dataclass(cls):
        names = [f.name for f in dataclasses.fields(cls) if BESIDE not in f.metadata]
    else:
        names = cls._fields
    fields: list[tuple[str, Node]] = []
    for name in names:
        if not _FIELD_NAME.fullmatch(name):
            raise SchemaError(f"{cls.__name__}.{name}: ROS 2 wants field names in lower case")
        inner = f"{path}.{name}" if path else name
        fields.append((name, _node(filled.get(hints[name], hints[name]), count, inner)))
    return Record(cls.__name__ + "".join(a.__name__.capitalize() for a in args), tuple(fields), cls)


def _counts(node: Node, path: str) -> Iterator[tuple[str, int]]:
    if isinstance(node, Array):
        yield path, node.count
        node = node.item
    for name, inner in node.fields if isinstance(node, Record) else ():
        yield from _counts(inner, f"{path}.{name}" if path else name)


def _encoder(layout: Layout) -> Callable[[Any], bytes]:
    """Source like: `a0 = r.tick; a1 = r.frame; ...; return pack(START, a0.k, a0.dt_ns, ..., *a2)`."""
    lines: list[str] = []
    values = ["START"]
    fresh = (f"a{i}" for i in itertools.count())

    def take(node: Node, value: str) -> None:
        if isinstance(node, Scalar):
            values.append(f"(-1 if {value} is None else {value})" if node.optional else value)
        elif isinstance(node, Array):
            names = [next(fresh) for _ in range(node.count)]
            lines.append(f"[{', '.join(names)}] = {value}")
            for name in names:
                take(node.item, name)
        elif isinstance(node, Record):
            if issubclass(node.cls, tuple) and all(isinstance(f, Scalar) and not f.optional for _, f in node.fields):
                values.append(f"*{value}")
                return
            name = next(fresh)
            lines.append(f"{name} = {value}")
            for field, inner in node.fields:
                take(inner, f"{name}.{field}")
        else:
            name = next(fresh)
            lines.append(f"{name} = {value}")
            values.append(f"len({name})")
            tail.append(f" + texts({name}) if {name} else ")

    tail: list[str] = []
    take(layout.root, "record")
    packed = f"pack({', '.join(values)})"
    lines.append(f"return {packed}{tail[0]}{packed}" if tail else f"return {packed}")
    return _define("encode", "record", lines, pack=struct.Struct(layout.format).pack, START=ENCAPSULATION, texts=_texts)


def _decoder(layout: Layout) -> Callable[[bytes], Any]:
    """Source like: `v = unpack(data); return Cycle(tick=Tick(k=v[1], dt_ns=v[2], ...), frame=..., ...)`."""
    names: dict[str, Any] = {"unpack": struct.Struct(layout.format).unpack_from, "strings": layout.strings}
    place = itertools.count(1)

    def make(node: Node) -> str:
        if isinstance(node, Scalar):
            value = f"v[{next(place)}]"
            if node.enum is None:
                return value
            key = f"{node.enum.__name__}_{node.optional}"
            names[key] = {int(member): member for member in node.enum} | ({-1: None} if node.optional else {})
            return f"{key}[{value}]"
        if isinstance(node, Array):
            return f"({''.join(make(node.item) + ', ' for _ in range(node.count))})"
        if isinstance(node, Record):
            names[node.cls.__name__] = node.cls
            return f"{node.cls.__name__}({', '.join(f'{name}={make(inner)}' for name, inner in node.fields)})"
        return "strings(data)"

    lines = ["v = unpack(data)", f"return {make(layout.root)}"]
    return _define("decode", "data", lines, **names)


def _define(name: str, argument: str, lines: list[str], **names: Any) -> Callable[[Any], Any]:
    source = f"def {name}({argument}):\n" + "".join(f"    {line}\n" for line in lines)
    exec(compile(source, f"<{name}>", "exec"), names)
    function: Callable[[Any], Any] = names[name]
    return function


def _texts(strings: tuple[str, ...]) -> bytes:
    """The strings behind their count: each a length, UTF-8, a zero, and padding to the next length."""
    data = b""
    for string in strings:
        raw = string.encode("utf-8", "replace") + b"\0"
        data += bytes(-len(data) % 4) + len(raw).to_bytes(4, "little") + raw
    return data
