"""The layout of a logged message: its schema in the ROS 2 interface language, and the place of each number in CDR.

Messages are classic CDR (OMG DDSI-RTPS 2.2, 10.2): four bytes of encapsulation for "little-endian", then the fields in
order, each aligned to its own size counted from behind those four bytes. Everything of fixed length comes
first; a message may end with one sequence, of strings, numbers or records, which may have sequences of their own. Such
a log opens in any viewer that knows ROS 2, and a column of it is a strided view of the bytes.
"""

from __future__ import annotations

import enum
import re
from collections import abc
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

PACKAGE = "sternplane"
ENCAPSULATION = b"\0\1\0\0"
"""CDR, little-endian, no options."""

CODES = {"bool": "?", "int8": "b", "int64": "q", "float64": "d"}
SIZES = {"?": 1, "b": 1, "q": 8, "d": 8}
_RULE = "=" * 80
_CONSTANT = re.compile(r"int8 (\w+)=(-?\d+)")
_FIELD = re.compile(r"(?:sternplane/)?(\w+)(?:\[(\d*)\])? (\w+)")


class SchemaError(ValueError):
    """A record or a schema that this encoding cannot represent."""


@dataclass(frozen=True, slots=True)
class Scalar:
    """A number. An enum is an int8 whose members are constants of the message; None, where allowed, is -1."""

    kind: str
    enum: Any = field(default=None, compare=False)
    optional: bool = field(default=False, compare=False)


@dataclass(frozen=True, slots=True)
class SchemaArray:
    """A number of items of one kind, back to back."""

    item: Node
    count: int


@dataclass(frozen=True, slots=True)
class Record:
    """A message: its name, its fields in order, and the class it was made from, if any."""

    name: str
    fields: tuple[tuple[str, Node], ...]
    cls: Any = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Text:
    """A string, in a sequence."""


@dataclass(frozen=True, slots=True)
class Sequence:
    """Any number of one kind, at the end of a message or within a record of such a sequence."""

    item: Node


Node = Scalar | SchemaArray | Record | Text | Sequence


class Leaf(NamedTuple):
    """One number of a message: dotted path (without array indices), struct code, offset from the start of the bytes."""

    path: str
    code: str
    offset: int


class Layout:
    """The place of every number in a message.

    Attributes:
        leaves: every number, in order.
        size: bytes of the fixed part, the count of the closing sequence included.
        closing: the path of the closing sequence, or "".
        closing_item: what is in it; None where there is none.
        format: the fixed part in the notation of `struct`.
    """

    def __init__(self, root: Record) -> None:
        self.root = root
        self.leaves: list[Leaf] = []
        self.closing = ""
        self.closing_item: Node | None = None
        self._end = len(ENCAPSULATION)
        codes = [f"<{self._end}s", *self._place(root, "")]
        if self.closing:
            codes.append(self._pad(4) + "I")
            self._end += 4
        self.size = self._end
        self.format = "".join(codes)

    def columns(self, messages: abc.Sequence[bytes]) -> dict[str, npt.NDArray[Any]]:
        """Return every field over all messages: path -> array of shape (messages,) or, in arrays, (messages, count)."""
        fixed = b"".join([message[: self.size] for message in messages])
        grouped: dict[str, list[npt.NDArray[Any]]] = {}
        for path, code, offset in self.leaves:
            view = np.ndarray((len(messages),), "<i1" if code == "b" else f"<{code}", fixed, offset, (self.size,))
            grouped.setdefault(path, []).append(view)
        arrays = self._arrays(self.root, "")
        return {path: np.stack(c, axis=-1) if path in arrays else c[0] for path, c in grouped.items()}

    def names(self) -> dict[str, dict[int, str]]:
        """Return the names of the values of every field that has some, in the fixed part: path -> value -> name."""
        return dict(self._names(self.root, ""))

    def _names(self, node: Node, path: str) -> Iterator[tuple[str, dict[int, str]]]:
        if isinstance(node, SchemaArray):
            yield from self._names(node.item, path)
        elif isinstance(node, Record):
            for name, inner in node.fields:
                yield from self._names(inner, f"{path}.{name}" if path else name)
        elif isinstance(node, Scalar) and (members := _members(node)):
            yield path, {value: key for key, value in members}

    def _place(self, node: Node, path: str) -> Iterator[str]:
        if self.closing:
            raise SchemaError(f"{self.root.name}: {path} comes after {self.closing}; a sequence must be last")
        if isinstance(node, Scalar):
            code = CODES[node.kind]
            yield self._pad(SIZES[code]) + code
            self.leaves.append(Leaf(path, code, self._end))
            self._end += SIZES[code]
        elif isinstance(node, SchemaArray):
            for _ in range(node.count):
                yield from self._place(node.item, path)
        elif isinstance(node, Record):
            for name, inner in node.fields:
                yield from self._place(inner, f"{path}.{name}" if path else name)
        elif isinstance(node, Sequence):
            self.closing, self.closing_item = path, node.item
        else:
            raise SchemaError(f"{self.root.name}: {path} is a string; only sequences have strings")

    def _pad(self, size: int) -> str:
        gap = -(self._end - len(ENCAPSULATION)) % size
        self._end += gap
        return "x" * gap

    def _arrays(self, node: Node, path: str) -> set[str]:
        """Return the paths of the numbers that are in an array."""
        if isinstance(node, SchemaArray):
            return {leaf.path for leaf in self.leaves if leaf.path == path or leaf.path.startswith(f"{path}.")}
        inside = node.fields if isinstance(node, Record) else ()
        return set().union(*(self._arrays(inner, f"{path}.{name}" if path else name) for name, inner in inside))


def text(root: Record) -> str:
    """Return the schema (`ros2msg`) of a message and of all messages in it.

    Raises:
        SchemaError: if two different messages have one name.
    """
    known: dict[str, Record] = {}
    for record in _records(root):
        if known.setdefault(record.name, record) != record:
            raise SchemaError(f"two different messages are called {record.name}")
    first, *others = (_body(record) for record in known.values())
    names = list(known)[1:]
    return first + "".join(f"{_RULE}\nMSG: {PACKAGE}/{name}\n{body}" for name, body in zip(names, others, strict=True))


def parse_schema(name: str, schema: str) -> Record:
    """Return the message that a schema made by `text` describes, whatever version of the records wrote it.

    Raises:
        SchemaError: if it is not such a schema.
    """
    first, *others = schema.split(f"{_RULE}\n")
    bodies = {name: first}
    for part in others:
        title, _, body = part.partition("\n")
        bodies[title.removeprefix(f"MSG: {PACKAGE}/")] = body

    def record(of: str) -> Record:
        if of not in bodies:
            raise SchemaError(f"schema of {name}: {of} is not described")
        found: list[tuple[str, Node]] = []
        members: dict[str, int] = {}
        for line in filter(None, bodies[of].splitlines()):
            if constant := _CONSTANT.fullmatch(line):
                members[constant[1]] = int(constant[2])
            else:
                found.append(declared(line, members))
                members = {}
        return Record(of, tuple(found))

    def declared(line: str, members: dict[str, int]) -> tuple[str, Node]:
        match = _FIELD.fullmatch(line)
        if match is None:
            raise SchemaError(f"schema of {name}: {line!r} is not understood")
        kind, count, title = match.groups()
        named = {key.removeprefix(f"{title.upper()}_"): value for key, value in members.items()}
        number = Scalar(kind, enum.IntEnum(title, named) if named else None)
        node: Node = Text() if kind == "string" else number if kind in CODES else record(kind)
        if count == "":
            return title, Sequence(node)
        return title, SchemaArray(node, int(count)) if count else node

    return record(name)


def _records(node: Node) -> Iterator[Record]:
    if isinstance(node, SchemaArray | Sequence):
        yield from _records(node.item)
    elif isinstance(node, Record):
        yield node
        for _, inner in node.fields:
            yield from _records(inner)


def _body(record: Record) -> str:
    lines: list[str] = []
    for name, node in record.fields:
        if isinstance(node, SchemaArray) and node.count == 0:
            continue  # ROS 2 has no arrays of length zero
        item, count = node, ""
        if isinstance(node, SchemaArray):
            item, count = node.item, f"[{node.count}]"
        elif isinstance(node, Sequence):
            item, count = node.item, "[]"
        if isinstance(item, Scalar):
            lines += [f"int8 {name.upper()}_{key}={value}" for key, value in _members(item)]
            lines.append(f"{item.kind}{count} {name}")
        elif isinstance(item, Record):
            lines.append(f"{PACKAGE}/{item.name}{count} {name}")
        else:
            lines.append(f"string{count} {name}")
    return "\n".join(lines) + "\n"


def _members(scalar: Scalar) -> list[tuple[str, int]]:
    if scalar.enum is None:
        return []
    members = [(key, int(member)) for key, member in scalar.enum.__members__.items()]
    return [("NONE", -1), *members] if scalar.optional else members
