"""The exact codec: any layout and any value, bit by bit; the reference that `struct_codec` must agree with."""

from __future__ import annotations

import math
import struct
from typing import Any

from firmware_py.wire.dronecan.dsdl_types import (
    Boolean,
    DecodeError,
    DsdlArray,
    Float,
    Integer,
    Layout,
    Struct,
    Union,
    Void,
    length_in_tail,
)

NUDGE = 1.0 + 2.0**-26
"""Sends a tie between two float16 away from zero, as libuavcan, libcanard and pydronecan do; moves no other float32."""

_LARGEST = {16: 65504.0, 32: 3.4028234663852886e38, 64: 1.7976931348623157e308}
_FLOAT = {16: struct.Struct("<e"), 32: struct.Struct("<f"), 64: struct.Struct("<d")}


def encode(layout: Layout, value: Any) -> bytes:
    """Return the payload of a value, padded with zeros to whole bytes.

    Raises:
        ValueError: if an array has a length that the layout does not allow.
        TypeError: if a value is not of its field's type.
    """
    writer = _Writer()
    writer.put(layout, value, tail=True)
    spare = -writer.count % 8
    return (writer.bits << spare).to_bytes((writer.count + spare) // 8, "big")


def decode(layout: Layout, payload: bytes) -> Any:
    """Return the value of a payload.

    Raises:
        DecodeError: if the payload is too short, too long, or an array or a tag in it is out of bounds.
    """
    reader = _Reader(payload)
    value = reader.get(layout, tail=True)
    if reader.left >= 8:
        raise DecodeError(f"payload of {len(payload)} bytes is {reader.left // 8} longer than its layout")
    return value


def half(value: float) -> int:
    """Return the bits of a float16: by way of float32, ties away from zero, saturated; NaN has all but its sign set."""
    if value != value:
        return 0xFFFF if math.copysign(1.0, value) < 0.0 else 0x7FFF
    (single,) = _FLOAT[32].unpack(_FLOAT[32].pack(_saturated(value, 16)))
    return int.from_bytes(_FLOAT[16].pack(single * NUDGE), "little")


def _saturated(value: float, bits: int) -> float:
    return min(max(value, -_LARGEST[bits]), _LARGEST[bits]) if value == value else value


class _Writer:
    """The bits written so far, as one integer."""

    __slots__ = ("bits", "count")

    def __init__(self) -> None:
        self.bits = 0
        self.count = 0

    def put(self, layout: Layout, value: Any, tail: bool) -> None:
        match layout:
            case Integer(bits, signed, truncated):
                if not truncated:
                    low, high = (-1 << bits - 1, (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
                    value = min(max(value, low), high)
                self._integer(value & (1 << bits) - 1, bits)
            case Boolean():
                self._integer(1 if value else 0, 1)
            case Float(16):
                self._integer(half(value), 16)
            case Float(bits):
                self._integer(int.from_bytes(_FLOAT[bits].pack(_saturated(value, bits)), "little"), bits)
            case Void(bits):
                self._integer(0, bits)
            case DsdlArray():
                self._array(layout, value, tail)
            case Struct(_, parts):
                fields = iter(value)
                for i, part in enumerate(parts, 1):
                    self.put(part, None if isinstance(part, Void) else next(fields), tail and i == len(parts))
            case Union(_, alternatives):
                tag, inner = value
                if not 0 <= tag < len(alternatives):
                    raise ValueError(f"union tag {tag}: must be in [0, {len(alternatives) - 1}]")
                self._integer(tag, layout.tag_bits)
                self.put(alternatives[tag], inner, tail)

    def _integer(self, value: int, bits: int) -> None:
        whole, rest = divmod(bits, 8)
        low = value & (1 << 8 * whole) - 1
        self.bits <<= bits
        self.bits |= int.from_bytes(low.to_bytes(whole, "little"), "big") << rest | value >> 8 * whole
        self.count += bits

    def _array(self, array: DsdlArray, items: Any, tail: bool) -> None:
        count = len(items)
        if count > array.length or (not array.dynamic and count != array.length):
            raise ValueError(f"array of {count} items: must be {'at most ' * array.dynamic}{array.length}")
        unsent = length_in_tail(array, tail)
        if array.dynamic and not unsent:
            self._integer(count, array.length.bit_length())
        for i, item in enumerate(items, 1):
            self.put(array.item, item, tail and not unsent and i == count)


class _Reader:
    """The bits not yet read, as one integer."""

    __slots__ = ("bits", "left")

    def __init__(self, payload: bytes) -> None:
        self.bits = int.from_bytes(payload, "big")
        self.left = 8 * len(payload)

    def get(self, layout: Layout, tail: bool) -> Any:
        match layout:
            case Integer(bits, signed):
                value = self._integer(bits)
                return value - (1 << bits) if signed and value >> bits - 1 else value
            case Boolean():
                return self._integer(1) == 1
            case Float(bits):
                return _FLOAT[bits].unpack(self._integer(bits).to_bytes(bits // 8, "little"))[0]
            case Void(bits):
                self._integer(bits)
                return None
            case DsdlArray():
                return self._array(layout, tail)
            case Struct(record, parts):
                last = len(parts) - 1
                values = [(part, self.get(part, tail and i == last)) for i, part in enumerate(parts)]
                return record(*[v for part, v in values if not isinstance(part, Void)])
            case Union(record, alternatives):
                tag = self._integer(layout.tag_bits)
                if tag >= len(alternatives):
                    raise DecodeError(f"union tag {tag}: must be in [0, {len(alternatives) - 1}]")
                return record(tag, self.get(alternatives[tag], tail))

    def _integer(self, bits: int) -> int:
        if bits > self.left:
            raise DecodeError(f"payload ends {bits - self.left} bits too early")
        self.left -= bits
        value = self.bits >> self.left & (1 << bits) - 1
        whole, rest = divmod(bits, 8)
        low = int.from_bytes((value >> rest).to_bytes(whole, "big"), "little")
        return low | (value & (1 << rest) - 1) << 8 * whole

    def _array(self, array: DsdlArray, tail: bool) -> Any:
        items: list[Any] = []
        if length_in_tail(array, tail):
            while self.left >= 8:
                if len(items) == array.length:
                    raise DecodeError(f"array is longer than {array.length} items")
                items.append(self.get(array.item, tail=False))
        else:
            count = self._integer(array.length.bit_length()) if array.dynamic else array.length
            if count > array.length:
                raise DecodeError(f"array of {count} items: must be at most {array.length}")
            items = [self.get(array.item, tail and i == count) for i in range(1, count + 1)]
        return bytes(items) if array.bytelike else tuple(items)
