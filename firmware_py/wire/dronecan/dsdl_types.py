"""The types of DSDL (DroneCAN v0) as annotations of a NamedTuple's fields.

A record declares the fields of a message and their layout on the wire in one place:

    class StaticPressure(NamedTuple):
        static_pressure: float32
        static_pressure_variance: float16

Bit order of DSDL v0: an integer is cut into bytes from its low end, the last piece holds the remaining high bits, and
the pieces follow each other with the most significant bit first.
"""

from __future__ import annotations

import typing
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias


class DecodeError(ValueError):
    """A payload that does not fit the layout of its message."""


@dataclass(frozen=True, slots=True)
class Integer:
    """An integer of 1 to 64 bits; out of range it saturates, or loses its high bits if `truncated`."""

    bits: int
    signed: bool = False
    truncated: bool = False


@dataclass(frozen=True, slots=True)
class Boolean:
    """One bit."""

    bits: int = 1


@dataclass(frozen=True, slots=True)
class Float:
    """IEEE 754 of 16, 32 or 64 bits; a value out of range, infinity too, saturates; NaN stays NaN."""

    bits: int


@dataclass(frozen=True, slots=True)
class Void:
    """Padding bits: sent as zeros, skipped when read."""

    bits: int


@dataclass(frozen=True, slots=True)
class DsdlArray:
    """`length` items, or up to `length` if `dynamic`; of uint8 it is `bytes` in the record, else a tuple."""

    item: Layout
    length: int
    dynamic: bool

    @property
    def bytelike(self) -> bool:
        """Return True if the record holds the array as `bytes`."""
        return self.item == UINT8


@dataclass(frozen=True, slots=True)
class Struct:
    """A sequence of layouts; a `Void` among them has no field in `record`."""

    record: type[Any]
    parts: tuple[Layout, ...]


@dataclass(frozen=True, slots=True)
class Union:
    """A tag and the alternative it names: the record is (tag, value)."""

    record: type[Any]
    alternatives: tuple[Layout, ...]

    @property
    def tag_bits(self) -> int:
        """Return the width of the tag, bits."""
        return (len(self.alternatives) - 1).bit_length()


Layout: TypeAlias = Integer | Boolean | Float | Void | DsdlArray | Struct | Union

UINT8 = Integer(8)

boolean = Annotated[bool, Boolean()]
uint2 = Annotated[int, Integer(2)]
uint3 = Annotated[int, Integer(3)]
uint4 = Annotated[int, Integer(4)]
uint5 = Annotated[int, Integer(5)]
uint6 = Annotated[int, Integer(6)]
uint7 = Annotated[int, Integer(7)]
uint8 = Annotated[int, UINT8]
uint11 = Annotated[int, Integer(11)]
uint13 = Annotated[int, Integer(13)]
uint16 = Annotated[int, Integer(16)]
uint32 = Annotated[int, Integer(32)]
uint40 = Annotated[int, Integer(40)]
uint48 = Annotated[int, Integer(48)]
uint64 = Annotated[int, Integer(64)]
int5 = Annotated[int, Integer(5, signed=True)]
int14 = Annotated[int, Integer(14, signed=True)]
int18 = Annotated[int, Integer(18, signed=True)]
int27 = Annotated[int, Integer(27, signed=True)]
int36 = Annotated[int, Integer(36, signed=True)]
int37 = Annotated[int, Integer(37, signed=True)]
int48 = Annotated[int, Integer(48, signed=True)]
int64 = Annotated[int, Integer(64, signed=True)]
float16 = Annotated[float, Float(16)]
float32 = Annotated[float, Float(32)]
usec = Annotated[int, Integer(56, truncated=True)]
"""uavcan.Timestamp: microseconds, 0 is unknown."""


def void(bits: int) -> Void:
    """Return padding, as metadata of the field that follows it."""
    return Void(bits)


def array(item: object, length: int) -> DsdlArray:
    """Return the layout of DSDL's item[length]."""
    return DsdlArray(layout_of(item), length, dynamic=False)


def upto(item: object, length: int) -> DsdlArray:
    """Return the layout of DSDL's item[<=length]."""
    return DsdlArray(layout_of(item), length, dynamic=True)


def union(record: type[Any], *alternatives: object) -> Union:
    """Return the layout of DSDL's @union, alternatives in tag order; DSDL's Empty is a record without fields."""
    return Union(record, tuple(layout_of(a) for a in alternatives))


def layout_of(hint: object) -> Layout:
    """Return the layout of an annotated type, of a NamedTuple of such, or of a layout itself.

    Raises:
        TypeError: if the annotation names no layout.
    """
    if isinstance(hint, Integer | Boolean | Float | Void | DsdlArray | Struct | Union):
        return hint
    if isinstance(hint, type) and hasattr(hint, "_fields"):
        hints = typing.get_type_hints(hint, include_extras=True)
        return Struct(hint, tuple(part for field in hint._fields for part in _parts(hints[field])))
    parts = _parts(hint)
    if len(parts) != 1:
        raise TypeError(f"{hint!r} has no layout on the wire; annotate it with one of wire.dronecan.dsdl_types")
    return parts[0]


def struct_of(record: type[Any]) -> Struct:
    """Return the layout of a NamedTuple."""
    layout = layout_of(record)
    assert isinstance(layout, Struct)
    return layout


def _parts(hint: object) -> tuple[Layout, ...]:
    """Return the layouts that an annotation stands for: voids, then the field."""
    if isinstance(hint, type):
        return (layout_of(hint),) if hasattr(hint, "_fields") else ()
    return tuple(m for m in getattr(hint, "__metadata__", ()) if isinstance(m, typing.get_args(Layout)))


def min_bits(layout: Layout) -> int:
    """Return the least bits of a value, as DSDL counts for the tail array optimisation (a dynamic array counts 0)."""
    match layout:
        case DsdlArray(item, length, dynamic):
            return 0 if dynamic else length * min_bits(item)
        case Struct(_, parts):
            return sum(map(min_bits, parts))
        case Union(_, alternatives):
            return layout.tag_bits + min(map(min_bits, alternatives))
        case _:
            return layout.bits


def max_bits(layout: Layout) -> int:
    """Return the most bits of a value, with the length of every dynamic array."""
    match layout:
        case DsdlArray(item, length, dynamic):
            return length * max_bits(item) + (length.bit_length() if dynamic else 0)
        case Struct(_, parts):
            return sum(map(max_bits, parts))
        case Union(_, alternatives):
            return layout.tag_bits + max(map(max_bits, alternatives))
        case _:
            return layout.bits


def length_in_tail(array: DsdlArray, tail: bool) -> bool:
    """Return True if the array's length is not sent but follows from the payload's (tail array optimisation)."""
    return array.dynamic and tail and min_bits(array.item) >= 8
