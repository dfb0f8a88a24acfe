"""Frames by the dialect's own tables: every message id with extreme values in each field, and a right checksum."""

from __future__ import annotations

import math
import random
import re
import struct
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import all as mav  # type: ignore[import-untyped]

from sternplane.fuzz.sessions import COMPONENT, SYSTEM, Message

_FLOAT_MAX = struct.unpack("<f", b"\xff\xff\x7f\x7f")[0]
_NUMBERS = (
    *(math.nan, math.inf, -math.inf) * 3,
    *(_FLOAT_MAX, -_FLOAT_MAX, 1e-45, -0.0, 2.0**31, -(2.0**31), 1e9, 1e5, -1e5),
    *(0.0, 1.0, -1.0, 2.0, 3.0, 4.0, 5.0, 0.5, 1.5, 10.0, -10.0, 16.0, 30.0, 90.0, -180.0),
)
_TEXTS = (b"", b"\xff\xfe\x80", b"\xc3", b"/../..", b"%s%n", b"A\0B", b"\n\x1b[31m", b'"', b"\xf0\x9f\x90", b"x" * 255)
_INTEGERS = {"b": -8, "B": 8, "h": -16, "H": 16, "i": -32, "I": 32, "q": -64, "Q": 64}
"""Bits of each code of `struct`, below 0 for signed ones."""
_LOOKED_AT = frozenset(
    (
        *("target_system", "target_component", "target", "command", "param_id", "mission_type", "payload"),
        *("frame", "coordinate_frame", "type_mask"),
    )
)
_MOSTLY, _OFTEN = 0.85, 0.4


class PayloadField(NamedTuple):
    """A field as it lies in the payload: its name, code of `struct` and how many there are of it."""

    name: str
    code: str
    length: int


def shape(kind: Any) -> list[PayloadField]:
    """Return the fields of a message in the order of the payload; a text is one value, however long."""
    codes = re.findall(r"(\d*)(\w)", kind.unpacker.format[1:])
    return [
        PayloadField(name, code, 1 if code == "s" or not length else int(length))
        for name, (length, code) in zip(kind.ordered_fieldnames, codes, strict=True)
    ]


def frame(payload: bytes, name: int, seq: int, system: int = SYSTEM, component: int = COMPONENT) -> bytes:
    """Return a MAVLink 2 frame around a payload, with the checksum of that message id, if the id is known."""
    kind = mav.mavlink_map.get(name)
    body = bytes((len(payload), 0, 0, seq, system, component)) + name.to_bytes(3, "little") + payload
    return b"\xfd" + body + _checksum(body, kind.crc_extra if kind is not None else 0)


def frame_1(payload: bytes, name: int, seq: int) -> bytes:
    """Return a frame as `frame` does, in MAVLink 1, for ids below 256."""
    body = bytes((len(payload), seq, SYSTEM, COMPONENT, name)) + payload
    return b"\xfe" + body + _checksum(body, mav.mavlink_map[name].crc_extra)


def with_checksum(broken: bytes | bytearray) -> bytes:
    """Return a changed frame with its right checksum; as it is, if it is no frame any more."""
    data = bytearray(broken)
    head = 6 if data[:1] == b"\xfe" else 10
    if len(data) >= head + 2:
        kind = mav.mavlink_map.get(data[5] if head == 6 else int.from_bytes(data[7:10], "little"))
        end = head + data[1]
        if kind is not None and end + 2 <= len(data):
            data[end : end + 2] = _checksum(data[1:end], kind.crc_extra)
    return bytes(data)


def _checksum(data: bytes | bytearray, extra: int) -> bytes:
    crc: int = mav.x25crc(bytes(data) + bytes((extra,))).crc
    return crc.to_bytes(2, "little")


class Grammar:
    """Payloads of any message id, at random but far from usual.

    What a vehicle looks at before all else (its addressee, which command, which parameter) is mostly what occurs
    in the conversations, for else nothing would get beyond that look; of other fields it often is.
    """

    names: tuple[int, ...] = tuple(sorted(mav.mavlink_map))
    """Every message id of the dialect."""

    def __init__(self, rng: random.Random, conversations: Sequence[Sequence[Message]]) -> None:
        self._rng = rng
        self.known = tuple(
            name
            for name, _ in dict.fromkeys(
                (message.get_msgId(), getattr(message, "command", None))
                for messages in conversations
                for message in messages
            )
        )
        """The ids that occur in the conversations, those with commands once for each command."""
        self._shapes = {name: shape(mav.mavlink_map[name]) for name in self.names}
        self._pack = {name: mav.mavlink_map[name].unpacker.pack for name in self.names}
        self._frequent: dict[tuple[str, str, int], list[list[Any]]] = {}
        for message in (message for messages in conversations for message in messages):
            for field, values in self._values(message):
                found = self._frequent.setdefault(field, [])
                if values not in found:
                    found.append(values)

    def payload(self, name: int) -> bytes:
        """Return a whole payload of a message."""
        values: list[Any] = []
        for field in self._shapes[name]:
            values += self._drawn(field)
        packed: bytes = self._pack[name](*values)
        return packed

    def _drawn(self, field: PayloadField) -> list[Any]:
        rng = self._rng
        frequent = self._frequent.get(field)
        if frequent is not None and rng.random() < (_MOSTLY if field.name in _LOOKED_AT else _OFTEN):
            return frequent[int(rng.random() * len(frequent))]
        if field.code == "s":
            return [_TEXTS[int(rng.random() * len(_TEXTS))]]
        if field.code == "B" and field.length > 1 and rng.random() < 0.5:
            return list(rng.randbytes(field.length))
        return [_DRAWS[field.code](rng)] * field.length

    def _values(self, message: Message) -> Iterator[tuple[PayloadField, list[Any]]]:
        for field in self._shapes[message.get_msgId()]:
            value = getattr(message, field.name)
            if field.code == "s":
                yield field, [value.encode() if isinstance(value, str) else bytes(value)]
            else:
                yield field, list(value) if field.length > 1 else [value]


def _integer(bits: int) -> Callable[[random.Random], int]:
    low, high = (0, (1 << bits) - 1) if bits > 0 else (-(1 << -bits - 1), (1 << -bits - 1) - 1)
    ends = (low, low + 1, high, high - 1, high // 2, high // 2 + 1, 0, 1, 2)

    def draw(rng: random.Random) -> int:
        share = rng.random()
        return ends[int(share * 12.0)] if share < 0.75 else low + int(rng.random() * (high - low))

    return draw


def _number(rng: random.Random) -> float:
    return _NUMBERS[int(rng.random() * len(_NUMBERS))]


_DRAWS: dict[str, Callable[[random.Random], Any]] = {code: _integer(bits) for code, bits in _INTEGERS.items()}
_DRAWS |= {"f": _number, "d": _number, "c": lambda _: b"\xff"}
