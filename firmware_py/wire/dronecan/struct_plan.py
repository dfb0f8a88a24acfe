"""A layout taken apart for `struct`: blocks of fixed size, and the dynamic arrays between them.

Fields that share bytes with others are shifted together into a run of whole bytes, which to `struct` is one value. All
expressions are Python source, from which `struct_codec` makes functions.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from firmware_py.wire.code_generator import Names
from firmware_py.wire.dronecan.dsdl_types import (
    Boolean,
    DsdlArray,
    Float,
    Integer,
    Layout,
    Struct,
    Union,
    Void,
    length_in_tail,
)

CODES = {8: "B", 16: "H", 32: "I", 64: "Q"}
FLOAT_CODES = {16: "e", 32: "f", 64: "d"}


class Unfit(Exception):
    """A layout with something that `struct` cannot do; `bitwise_codec` can."""


@dataclass
class Block:
    """What lies between two dynamic arrays: one Struct."""

    code: str = "<"
    given: list[str] = field(default_factory=list)
    """One expression for each value that the Struct packs."""
    taken: list[str] = field(default_factory=list)
    """One name for each value that the Struct unpacks."""
    undo: list[str] = field(default_factory=list)
    """Lines that make fields of the unpacked values."""
    run: list[tuple[Integer | Boolean | Void, str, str]] = field(default_factory=list)
    """Fields that share bytes, until a whole byte is reached: layout, name, value given."""


@dataclass
class DynamicArray:
    """A dynamic array; `unsent` if its length follows from that of the payload."""

    array: DsdlArray
    name: str
    unsent: bool


class StructPlan:
    """The blocks and arrays of a payload in order, and what an encoder must check before it packs them."""

    def __init__(self, layout: Struct, names: Names) -> None:
        self.names = names
        self.steps: list[Block | DynamicArray] = []
        self.block = self._next_block()
        self.halves: list[str] = []
        """Names of the float16 in blocks; a block is given h_name, the bits."""
        self.singles: list[str] = []
        """Names of the float32 and float64 in blocks."""
        self.refused: list[str] = []
        """Conditions on which an encoder leaves the record to `bitwise_codec`."""
        self.outside: list[str] = []
        """Expressions that are not 0 if an integer of a run needs more bits than it has."""
        self.left, self.right = self._take(layout, tail=True)
        """The pattern that takes a record apart, the expression that puts it together."""
        self._close(final=True)

    def _next_block(self) -> Block:
        block = self.block = Block()
        self.steps.append(block)
        return block

    def _take(self, layout: Layout, tail: bool) -> tuple[str, str]:
        names = self.names
        match layout:
            case Struct(record, parts):
                both = [self._take(part, tail and i == len(parts)) for i, part in enumerate(parts, 1)]
                left, right = ("".join(f"{sides[k]}, " for sides in both if sides[k]) for k in (0, 1))
                return f"({left})", f"new({names.constant('R', record)}, ({right}))"
            case DsdlArray(item, length, dynamic=False) if not layout.bytelike:
                both = [self._take(item, tail and i == length) for i in range(1, length + 1)]
                left, right = ("".join(f"{sides[k]}, " for sides in both) for k in (0, 1))
                return f"({left})", f"({right})"
            case DsdlArray(dynamic=True):
                name = self._dynamic(layout, length_in_tail(layout, tail))
            case Void():
                self._share(layout, "", "0")
                return "", ""
            case Union():
                raise Unfit
            case Boolean():
                self._share(layout, name := names.variable("v"), name)
            case Integer(bits) if self.block.run or bits % 8:
                self._share(layout, name := names.variable("v"), name)
            case _:
                self._whole(layout, name := names.variable("v"))
        return name, name

    def _dynamic(self, array: DsdlArray, unsent: bool) -> str:
        name = self.names.variable("a")
        if not unsent:
            self._share(Integer(array.length.bit_length(), truncated=True), f"n_{name}", f"len({name})")
        self._close()
        self.refused.append(f"len({name}) > {array.length}")
        self.steps.append(DynamicArray(array, name, unsent))
        self._next_block()
        return name

    def _whole(self, layout: Integer | Float | DsdlArray, name: str) -> None:
        """Add a field of whole bytes."""
        if self.block.run:
            raise Unfit
        block, given = self.block, name
        match layout:
            case Integer(bits, signed, truncated):
                size = bits // 8
                given = f"{name} & {(1 << bits) - 1}" if truncated else name
                block.code += CODES.get(bits, f"{size}s").lower() if signed else CODES.get(bits, f"{size}s")
                if bits not in CODES:
                    given = f"({given}).to_bytes({size}, 'little', signed={signed})"
                    block.undo.append(f"{name} = number({name}, 'little', signed={signed})")
            case Float(bits):
                block.code += FLOAT_CODES[bits]
                (self.halves if bits == 16 else self.singles).append(name)
                given = f"h_{name}" if bits == 16 else name
            case DsdlArray(_, length):
                block.code += f"{length}s"
                self.refused.append(f"len({name}) != {length}")
        block.given.append(given)
        block.taken.append(name)

    def _share(self, layout: Integer | Boolean | Void, name: str, given: str) -> None:
        """Add a field that shares bytes with its neighbours."""
        self.block.run.append((layout, name, given))
        if sum(part.bits for part, _, _ in self.block.run) % 8 == 0:
            self._close()

    def _close(self, final: bool = False) -> None:
        """End a run: it is a byte, or the bytes of a big-endian number."""
        block = self.block
        width = sum(part.bits for part, _, _ in block.run)
        if width % 8 and not final:
            raise Unfit  # an array would begin within a byte
        if not width:
            return
        size, run = -(-width // 8), self.names.variable("r")
        place = 8 * size
        terms: list[str] = []
        undo: list[str] = []
        for part, name, given in block.run:
            place -= part.bits
            if isinstance(part, Void):
                continue
            terms.append(put(part.bits, given, place))
            taken = take(part.bits, run, place)
            if isinstance(part, Boolean):
                undo.append(f"{name} = ({taken}) != 0")
            else:
                undo.append(f"{name} = {signed_value(part, taken)}")
                self.outside += overflow(part, given)
        number = " | ".join(terms) or "0"
        block.code += "B" if size == 1 else f"{size}s"
        block.given.append(number if size == 1 else f"({number}).to_bytes({size}, 'big')")
        block.taken.append(run)
        block.undo += ([f"{run} = number({run}, 'big')"] if size > 1 else []) + undo
        block.run = []


def put(bits: int, value: str, place: int) -> str:
    """Return the source of an integer's bits in the order of the wire, the last of them at bit `place`."""
    pieces = _pieces(bits)
    return " | ".join(_moved(value, low, width, place + wire) for low, width, wire in pieces)


def take(bits: int, run: str, place: int) -> str:
    """Return the source that takes back from `run` what `put` has put there."""
    return " | ".join(_moved(run, place + wire, width, low) for low, width, wire in _pieces(bits))


def signed_value(part: Integer, taken: str) -> str:
    """Return the source of an integer whose bits are `taken`."""
    sign = 1 << part.bits - 1
    return f"(({taken}) ^ {sign}) - {sign}" if part.signed else taken


def overflow(part: Integer, given: str) -> list[str]:
    """Return the expressions (one or none) that are not 0 if a value needs more bits than its field has."""
    if part.truncated:
        return []
    return [f"{given} + {1 << part.bits - 1} >> {part.bits}" if part.signed else f"{given} >> {part.bits}"]


def _pieces(bits: int) -> list[tuple[int, int, int]]:
    """Cut an integer as DSDL does: for each piece its lowest bit, its width, and where it stands on the wire."""
    return [(low, min(8, bits - low), max(0, bits - low - 8)) for low in range(0, bits, 8)]


def _moved(value: str, down: int, bits: int, up: int) -> str:
    """Return the source of: `bits` bits of a value from bit `down` on, put at bit `up`."""
    masked = f"{value} >> {down} & {(1 << bits) - 1}" if down else f"{value} & {(1 << bits) - 1}"
    return f"({masked}) << {up}" if up else f"({masked})"
