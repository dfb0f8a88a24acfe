"""The fast codec: from a layout, the source of an encoder and of a decoder that let `struct` do the work.

The functions know only the usual case. For all else (an integer that must saturate, an array of an odd kind that is not
empty, a malformed payload) they hand over to `bits`, which also is the one to complain.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from itertools import chain
from typing import Any

from firmware_py.wire import bits
from firmware_py.wire.layout import Array, Float, Integer, Layout, Struct
from firmware_py.wire.plan import CODES, FLOAT_CODES, Plan, Tail, Unfit


def compiled(layout: Struct) -> tuple[Callable[[Any], bytes], Callable[[bytes], Any]]:
    """An encoder and a decoder that do what `bits.encode` and `bits.decode` do; these themselves if none is faster."""

    def exact_encode(record: Any) -> bytes:
        return bits.encode(layout, record)

    def exact_decode(payload: bytes) -> Any:
        return bits.decode(layout, payload)

    try:
        source, names = sources(layout)
    except Unfit:
        return exact_encode, exact_decode
    names |= {"exact_encode": exact_encode, "exact_decode": exact_decode}
    exec(source, names)
    return names["encode"], names["decode"]


def sources(layout: Struct) -> tuple[str, dict[str, Any]]:
    """Source of encode(record) and decode(payload), and the constants they name.

    Raises:
        Unfit: if the layout is not made of whole bytes between its arrays, or has a union.
    """
    plan = Plan(layout)
    source = f"{_encoder(plan)}\n\n{_decoder(plan)}\n"
    return source, {
        **plan.names,
        "UNUSUAL": (struct.error, OverflowError, TypeError, ValueError),
        "chain": chain.from_iterable,
        "halves": _halves,
        "new": tuple.__new__,
        "number": int.from_bytes,
        "pack": struct.pack,
        "unpack": struct.unpack,
        "iter_unpack": struct.iter_unpack,
    }


_FORMATS = tuple((struct.Struct(f"<{n}f"), struct.Struct(f"<{n}e"), struct.Struct(f"<{n}H")) for n in range(256))
_INFINITE, _FRACTION = 0x7C00, 0x03FF


def _spoken(half: int) -> int:
    """What goes out for NaN and the infinities: all bits set but the sign, and the largest; as `bits.half`."""
    return half | _INFINITE | _FRACTION if half & _FRACTION else half - 1


def _halves(values: Sequence[float], nudge: float = bits.NUDGE) -> Sequence[int]:
    """The bits of float16, all at once.

    Raises:
        OverflowError: if a finite one is out of range.
    """
    singles, halves, integers = _FORMATS[len(values)]
    rounded = singles.unpack(singles.pack(*values))
    total = sum(rounded)
    found = integers.unpack(halves.pack(*[value * nudge for value in rounded]))
    if total - total:  # not finite
        return [half if half & _INFINITE != _INFINITE else _spoken(half) for half in found]
    return found


def _encoder(plan: Plan) -> str:
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
        if isinstance(step, Tail):
            pieces.append(_array_given(plan, lines, step.array, step.name))
        elif step.given:
            pack = plan.name("S", struct.Struct(step.code.replace("e", "H")).pack)
            pieces.append(f"{pack}({', '.join(step.given)})")
    lines.append(f"return {' + '.join(pieces) or repr(b'')}")
    return _function("encode", "record", lines)


def _array_given(plan: Plan, lines: list[str], array: Array, name: str) -> str:
    """Adds what prepares a dynamic array; returns the expression for its bytes."""
    if array.bytelike:
        return name
    codes = _item_codes(array.item)
    if not codes:
        lines.append(f"if {name}: return exact_encode(record)")
        return "b''"
    flat = plan.name("f")
    lines.append(f"{flat} = list({f'chain({name})' if isinstance(array.item, Struct) else name})")
    for i, code in enumerate(codes):
        column = f"{flat}[{i}::{len(codes)}]"
        if code == "e":
            lines.append(f"if {name}: {column} = halves({column})")
        elif code in "fd":
            lines += [f"total = sum({column})", "if total - total: return exact_encode(record)"]
    return f"pack({_formats(plan, codes.replace('e', 'H'), array.length)}[len({name})], *{flat})"


def _decoder(plan: Plan) -> str:
    lines: list[str] = []
    base, offset = "", 0  # where we are: a variable, if any, and a constant
    steps = [step for step in plan.steps if isinstance(step, Tail) or step.taken]
    for step in steps:
        at = f"{base}{offset}"
        if isinstance(step, Tail):
            base, offset = f"{_array_taken(plan, lines, step, at)} + ", 0
            continue
        whole = struct.Struct(step.code)
        if len(steps) == 1:
            lines.append(f"{', '.join(step.taken)}, = {plan.name('S', whole.unpack)}(payload)")
        else:
            lines.append(f"{', '.join(step.taken)}, = {plan.name('S', whole.unpack_from)}(payload, {at})")
        lines += step.undo
        offset += whole.size
    last = steps[-1] if steps else None
    if len(steps) != 1 and not (isinstance(last, Tail) and last.unsent):
        lines.append(f"if len(payload) != {base}{offset}: return exact_decode(payload)")
    lines.append(f"return {plan.right}")
    return _function("decode", "payload", lines)


def _array_taken(plan: Plan, lines: list[str], tail: Tail, at: str) -> str:
    """Adds what reads a dynamic array that begins at `at`; returns the variable that says where it ends."""
    array, name, count, end = tail.array, tail.name, f"n_{tail.name}", f"e_{tail.name}"
    codes = _item_codes(array.item)
    size = struct.calcsize("<" + codes) or 1
    if tail.unsent:
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
        make = plan.name("M", array.item.record._make)
        lines.append(f"{name} = tuple(map({make}, iter_unpack('<{codes}', {name})))")
    else:
        lines.append(f"{name} = unpack({_formats(plan, codes, array.length)}[{count}], {name})")
    return end


def _formats(plan: Plan, codes: str, length: int) -> str:
    """The name of a table: the format of an array of 0 to `length` items."""
    return plan.name("F", tuple("<" + codes * n for n in range(length + 1)))


def _item_codes(item: Layout) -> str:
    """The codes of an array's item, "" if `struct` cannot pack it as it is."""
    match item:
        case Integer(bits, signed, False) if bits in CODES:
            return CODES[bits].lower() if signed else CODES[bits]
        case Float(bits):
            return FLOAT_CODES[bits]
        case Struct(_, parts):
            codes = ["" if isinstance(part, Struct) else _item_codes(part) for part in parts]
            return "".join(codes) if all(codes) else ""
    return ""


def _function(name: str, argument: str, lines: list[str]) -> str:
    body = "\n".join(f"        {line}" for line in lines)
    return f"def {name}({argument}):\n    try:\n{body}\n    except UNUSUAL:\n        return exact_{name}({argument})"
