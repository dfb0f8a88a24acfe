"""The fast codec: from a layout, an encoder and a decoder that let `struct` do the work.

The functions know the usual case only. Everything else (an integer that must saturate, an array of an odd type that is
not empty, a malformed payload) they leave to `bitwise_codec`, which also raises the errors.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from itertools import chain
from typing import Any

from firmware_py.wire.code_generator import Names, compile_function, function_source, with_guard
from firmware_py.wire.dronecan import bitwise_codec
from firmware_py.wire.dronecan.dsdl_types import DsdlArray, Float, Integer, Layout, Struct
from firmware_py.wire.dronecan.struct_plan import (
    CODES,
    FLOAT_CODES,
    DynamicArray,
    StructPlan,
    Unfit,
    overflow,
    put,
    signed_value,
    take,
)


def codec_of(layout: Struct) -> tuple[Callable[[Any], bytes], Callable[[bytes], Any]]:
    """Return an encoder and a decoder that do what those of `bitwise_codec` do; these themselves if none is faster."""

    def exact_encode(record: Any) -> bytes:
        return bitwise_codec.encode(layout, record)

    def exact_decode(payload: bytes) -> Any:
        return bitwise_codec.decode(layout, payload)

    try:
        encoder, decoder, names = sources(layout)
    except Unfit:
        return exact_encode, exact_decode
    names.objects |= {"exact_encode": exact_encode, "exact_decode": exact_decode}
    return compile_function(encoder, "encode", names), compile_function(decoder, "decode", names)


def sources(layout: Struct) -> tuple[str, str, Names]:
    """Return the source of encode(record) and of decode(payload), and the objects they name.

    Raises:
        Unfit: if the layout is not made of whole bytes between its arrays, or has a union.
    """
    names = Names(
        UNUSUAL=(struct.error, OverflowError, TypeError, ValueError),
        chain=chain.from_iterable,
        halves=_halves,
        new=tuple.__new__,
        number=int.from_bytes,
        pack=struct.pack,
        unpack=struct.unpack,
        iter_unpack=struct.iter_unpack,
    )
    plan = StructPlan(layout, names)
    encoder = with_guard(_encoder(plan), "UNUSUAL", "exact_encode(record)")
    decoder = with_guard(_decoder(plan), "UNUSUAL", "exact_decode(payload)")
    return function_source("encode", "record", encoder), function_source("decode", "payload", decoder), names


_FORMATS = tuple((struct.Struct(f"<{n}f"), struct.Struct(f"<{n}e"), struct.Struct(f"<{n}H")) for n in range(256))
_INFINITE, _FRACTION = 0x7C00, 0x03FF
_NAN = _INFINITE | _FRACTION


def _halves(values: Sequence[float], nudge: float = bitwise_codec.NUDGE) -> Sequence[int]:
    """Return the bits of float16 values, all at once.

    Raises:
        OverflowError: if a finite one is out of range.
    """
    singles, halves, integers = _FORMATS[len(values)]
    rounded = singles.unpack(singles.pack(*values))
    total = sum(rounded)
    found = integers.unpack(halves.pack(*[value * nudge for value in rounded]))
    if total - total:  # not finite: NaN has all bits set but its sign, and an infinity is the largest (see `half`)
        return [h if h & _INFINITE != _INFINITE else h | _NAN if h & _FRACTION else h - 1 for h in found]
    return found


def _encoder(plan: StructPlan) -> list[str]:
    lines, checks, pieces = [f"{plan.left} = record"] if plan.left != "()" else [], [*plan.refused], []
    if plan.outside:
        checks.append(" | ".join(f"({e})" for e in plan.outside))
    if plan.singles:
        lines.append(f"total = {' + '.join(plan.singles)}")
        checks.append("total - total")
    if checks:
        lines.append(f"if {' or '.join(checks)}: return exact_encode(record)")
    if plan.halves:
        taken, given = ("".join(f"{prefix}{name}, " for name in plan.halves) for prefix in ("h_", ""))
        lines.append(f"{taken} = halves(({given}))")
    for step in plan.steps:
        if isinstance(step, DynamicArray):
            pieces.append(_array_given(plan, lines, step))
        elif step.given:
            pack = plan.names.constant("S", struct.Struct(step.code.replace("e", "H")).pack)
            pieces.append(f"{pack}({', '.join(step.given)})")
    lines.append(f"return {' + '.join(pieces) or repr(b'')}")
    return lines


def _array_given(plan: StructPlan, lines: list[str], dynamic: DynamicArray) -> str:
    """Add what prepares a dynamic array; return the expression for its bytes."""
    array, name = dynamic.array, dynamic.name
    if array.bytelike:
        return name
    codes = _item_codes(array.item)
    if not codes:
        if isinstance(array.item, Integer) and dynamic.unsent:
            return _integers_given(plan, lines, array.item, name)
        lines.append(f"if {name}: return exact_encode(record)")
        return "b''"
    flat = plan.names.variable("f")
    lines.append(f"{flat} = list({f'chain({name})' if isinstance(array.item, Struct) else name})")
    for i, code in enumerate(codes):
        column = f"{flat}[{i}::{len(codes)}]"
        if code == "e":
            lines.append(f"if {name}: {column} = halves({column})")
        elif code in "fd":
            lines += [f"total = sum({column})", "if total - total: return exact_encode(record)"]
    return f"pack({_formats(plan, codes.replace('e', 'H'), array.length)}[len({name})], *{flat})"


def _integers_given(plan: StructPlan, lines: list[str], item: Integer, name: str) -> str:
    """Add what packs integers that do not fill bytes (int14, int18) into one big-endian number, padded at its end."""
    number, value = plan.names.variable("r"), plan.names.variable("v")
    lines += [f"{number} = 0", f"for {value} in {name}:"]
    lines += [f"    if {expression}: return exact_encode(record)" for expression in overflow(item, value)]
    lines += [
        f"    {number} = {number} << {item.bits} | {put(item.bits, value, 0)}",
        f"bits = {item.bits} * len({name})",
    ]
    return f"({number} << -bits % 8).to_bytes((bits + 7) // 8, 'big')"


def _decoder(plan: StructPlan) -> list[str]:
    lines: list[str] = []
    base, offset = "", 0  # where we are: a variable, if any, and a constant
    steps = [step for step in plan.steps if isinstance(step, DynamicArray) or step.taken]
    for step in steps:
        at = f"{base}{offset}"
        if isinstance(step, DynamicArray):
            base, offset = f"{_array_taken(plan, lines, step, at)} + ", 0
            continue
        whole = struct.Struct(step.code)
        if len(steps) == 1:
            lines.append(f"{', '.join(step.taken)}, = {plan.names.constant('S', whole.unpack)}(payload)")
        else:
            lines.append(f"{', '.join(step.taken)}, = {plan.names.constant('S', whole.unpack_from)}(payload, {at})")
        lines += step.undo
        offset += whole.size
    last = steps[-1] if steps else None
    if len(steps) != 1 and not (isinstance(last, DynamicArray) and last.unsent):
        lines.append(f"if len(payload) != {base}{offset}: return exact_decode(payload)")
    lines.append(f"return {plan.right}")
    return lines


def _array_taken(plan: StructPlan, lines: list[str], dynamic: DynamicArray, at: str) -> str:
    """Add what reads a dynamic array that begins at `at`; return the variable that says where it ends."""
    array, name, count, end = dynamic.array, dynamic.name, f"n_{dynamic.name}", f"e_{dynamic.name}"
    codes = _item_codes(array.item)
    if not codes and isinstance(array.item, Integer) and dynamic.unsent:
        _integers_taken(plan, lines, array, name, at)
        return end
    size = struct.calcsize("<" + codes) or 1
    if dynamic.unsent:
        lines += [f"{name} = payload[{at}:]", f"{count} = len({name}) // {size}"]
    else:
        lines += [f"{end} = {at} + {count} * {size}", f"{name} = payload[{at}:{end}]"]
    odd = f"{count} > {array.length} or len({name}) != {count} * {size}" if codes else count
    lines.append(f"if {odd}: return exact_decode(payload)")
    if not codes:
        lines.append(f"{name} = ()")
    elif array.bytelike:
        lines.append(f"{name} = bytes({name})")
    elif isinstance(array.item, Struct):
        make = plan.names.constant("M", array.item.record._make)
        lines.append(f"{name} = tuple(map({make}, iter_unpack('<{codes}', {name})))")
    else:
        lines.append(f"{name} = unpack({_formats(plan, codes, array.length)}[{count}], {name})")
    return end


def _integers_taken(plan: StructPlan, lines: list[str], array: DsdlArray, name: str, at: str) -> None:
    """Add what reads integers that do not fill their bytes, to the end of the payload; the rest is padding."""
    item, number, piece = array.item, plan.names.variable("r"), plan.names.variable("v")
    assert isinstance(item, Integer)
    width = item.bits
    value = signed_value(item, take(width, piece, 0))
    lines += [
        f"bits = 8 * len(payload) - 8 * ({at})",
        f"spare = bits % {width}",
        f"if spare > 7 or bits > {8 * -(-width * array.length // 8)}: return exact_decode(payload)",
        f"{number} = number(payload[{at}:], 'big') >> spare",
        f"places = range(bits - spare - {width}, -1, -{width})",
        f"{name} = tuple([{value} for {piece} in [{number} >> place for place in places]])",
    ]


def _formats(plan: StructPlan, codes: str, length: int) -> str:
    """Return the name of a table: the format of an array of 0 to `length` items."""
    return plan.names.constant("F", tuple("<" + codes * n for n in range(length + 1)))


def _item_codes(item: Layout) -> str:
    """Return the codes of an array's item, "" if `struct` cannot pack it as it is."""
    match item:
        case Integer(bits, signed, False) if bits in CODES:
            return CODES[bits].lower() if signed else CODES[bits]
        case Float(bits):
            return FLOAT_CODES[bits]
        case Struct(_, parts):
            codes = ["" if isinstance(part, Struct) else _item_codes(part) for part in parts]
            return "".join(codes) if all(codes) else ""
    return ""
