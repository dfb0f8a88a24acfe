"""A number is declared once, beside what uses it; the TOML loader and the reference table follow from that.

A parameter is a field of a frozen dataclass, made by `param`. In TOML its key is the field's name with the unit behind
it (`delta_max_deg = 23`), and inside it is SI: radians, metres, rev/s. Nothing here opens a file.
"""

from __future__ import annotations

import contextlib
import dataclasses
import difflib
import enum
import functools
import math
import types
import typing
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

T = TypeVar("T")
_KEY = "sternplane"
_PREFIX = "sternplane.prefix"

UNITS: dict[str, tuple[str, float]] = {
    # unit: (suffix of the TOML key, factor to SI)
    "": ("", 1.0),
    "m": ("_m", 1.0),
    "m/s": ("_m_s", 1.0),
    "m/s^2": ("_m_s2", 1.0),
    "m^2": ("_m2", 1.0),
    "s": ("_s", 1.0),
    "ms": ("_ms", 1e-3),
    "1/s": ("_1_s", 1.0),
    "Hz": ("_hz", 1.0),
    "deg": ("_deg", math.pi / 180),
    "deg/s": ("_deg_s", math.pi / 180),
    "deg/m": ("_deg_m", math.pi / 180),
    "rad": ("_rad", 1.0),
    "rpm": ("_rpm", 1.0 / 60.0),
    "rpm/s": ("_rpm_s", 1.0 / 60.0),
    "kg": ("_kg", 1.0),
    "kg/m^3": ("_kg_m3", 1.0),
    "kg m^2": ("_kg_m2", 1.0),
    "N": ("_n", 1.0),
    "Pa": ("_pa", 1.0),
    "V": ("_v", 1.0),
    "A": ("_a", 1.0),
    "W": ("_w", 1.0),
    "Wh": ("_wh", 3600.0),
    "K": ("_k", 1.0),
    "%": ("_pct", 0.01),
}


class ParamError(ValueError):
    """A configuration that cannot be used; the text names the file and the key, and what would be right."""


@contextlib.contextmanager
def prefix_errors(where: str) -> Iterator[None]:
    """Puts `where` in front of a ValueError of what is made within: for who knows which file the numbers came from."""
    try:
        yield
    except ValueError as error:
        raise ParamError(f"{where}: {error}") from None


class TakesEffect(enum.Enum):
    """When what a ground station changes may take effect."""

    AT_ONCE = enum.auto()
    DISARMED = enum.auto()
    """The vehicle would start or stumble if it came in flight; it is refused while armed."""
    RESTART = enum.auto()
    """Memory has other sizes with it; it is kept for the next start."""


@dataclass(frozen=True, slots=True)
class Declaration:
    """What `param` was told about one number."""

    unit: str
    low: float
    high: float
    doc: str
    mav: str
    when: TakesEffect


def param(
    default: Any = dataclasses.MISSING,
    *,
    unit: str = "",
    low: float = -math.inf,
    high: float = math.inf,
    doc: str = "",
    mav: str = "",
    when: TakesEffect = TakesEffect.AT_ONCE,
) -> Any:
    """Declares a parameter: default and bounds in `unit` (as in TOML, not SI), one sentence, the end of a MAVLink name.

    Stations see it if it has such an end; the beginning is what `table` says of the tables it is in. A list has a name
    for each entry, counted from 1.
    """
    if unit not in UNITS:
        raise ValueError(f"unit {unit!r} is not declared in params.UNITS")
    if len(mav) > 16:
        raise ValueError(f"MAVLink name {mav!r} is longer than 16 characters")
    metadata = {_KEY: Declaration(unit, low, high, doc, mav, when)}
    if default is dataclasses.MISSING:
        return dataclasses.field(metadata=metadata)
    return dataclasses.field(default=_to_si(default, UNITS[unit][1]), metadata=metadata)


def table(cls: type[Any], mav: str = "") -> Any:
    """Declares a table of parameters, all as `cls` has them, whose MAVLink names begin with `mav`."""
    return dataclasses.field(default_factory=cls, metadata={_PREFIX: mav})


def declaration_of(field: dataclasses.Field[Any]) -> Declaration | None:
    """What `param` was told about a field; None if it was not made by `param`."""
    return typing.cast("Declaration | None", field.metadata.get(_KEY))


def mavlink_prefix(field: dataclasses.Field[Any]) -> str:
    """What the MAVLink names below a table begin with."""
    return str(field.metadata.get(_PREFIX, ""))


def toml_key(field: dataclasses.Field[Any]) -> str:
    """The key of a field in TOML: its name, and its unit behind it."""
    declaration = declaration_of(field)
    return field.name + (UNITS[declaration.unit][0] if declaration else "")


def load(cls: type[T], table: Mapping[str, Any], where: str) -> T:
    """Makes `cls` from a TOML table.

    Args:
        cls: a dataclass whose fields are parameters, nested dataclasses, tuples of them, enums, str, bool, int, float.
        table: what `tomllib` read.
        where: file, and path of the table in it, for the error.

    Raises:
        ParamError: unknown key, missing key, wrong unit, wrong type or out of bounds.
    """
    hints = field_types(cls)
    fields = {toml_key(f): f for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    for key in table:
        if key not in fields:
            raise ParamError(unknown_key_text(where, key, fields))
    values: dict[str, Any] = {}
    for key, field in fields.items():
        if key in table:
            values[field.name] = parse_value(hints[field.name], declaration_of(field), table[key], f"{where}: {key}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ParamError(f"{where}: {key} is missing ({_wanted(hints[field.name], declaration_of(field))})")
    try:
        return cls(**values)
    except ParamError as error:
        raise ParamError(f"{where}: {error}") from None


def dump(record: Any) -> dict[str, Any]:
    """The TOML table (also JSON-able) that `load` makes the record from again, exactly."""
    table: dict[str, Any] = {}
    for field in dataclasses.fields(record):
        declaration = declaration_of(field)
        factor = UNITS[declaration.unit][1] if declaration else 1.0
        table[toml_key(field)] = to_toml_value(getattr(record, field.name), factor)
    return table


field_types = typing.cast("Callable[[type[Any]], dict[str, Any]]", functools.cache(typing.get_type_hints))
"""The types of a dataclass's fields; to find them anew each time takes as long as a cycle may."""


def choices_text(choices: type[enum.Enum]) -> str:
    """An enum's members as TOML has them, for people."""
    return ", ".join(f'"{member.name.lower()}"' for member in choices)


def is_table(hint: Any) -> bool:
    """True for the type of a field that holds a table."""
    return isinstance(hint, type) and dataclasses.is_dataclass(hint)


def _to_si(value: Any, factor: float) -> Any:
    if isinstance(value, tuple):
        return tuple(_to_si(v, factor) for v in value)
    if isinstance(value, bool | str | enum.Enum) or factor == 1.0:
        return value
    return value * factor


def to_toml_value(value: Any, factor: float) -> Any:
    """What TOML says of a value, whose unit is `factor` times that of SI."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dump(value)
    if isinstance(value, tuple | list):
        return [to_toml_value(v, factor) for v in value]
    if isinstance(value, enum.Enum):
        return value.name.lower()
    if value is None or isinstance(value, Mapping):
        return value
    if isinstance(value, bool | str) or factor == 1.0:
        return value
    return _inverse(value, factor)


def _inverse(value: float, factor: float) -> float:
    """The number whose product with `factor` is `value` to the last bit, where there is one."""
    guess = value / factor
    for candidate in (round(guess, 12), guess, math.nextafter(guess, math.inf), math.nextafter(guess, -math.inf)):
        if candidate * factor == value:
            return candidate
    return guess


def parse_value(hint: Any, declaration: Declaration | None, raw: Any, where: str) -> Any:
    """What a field of that type is given for what TOML says of it; see `load`."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if is_table(hint):
        if not isinstance(raw, Mapping):
            raise ParamError(f"{where} must be a table")
        return load(hint, raw, where)
    if origin in (typing.Union, types.UnionType):
        return parse_value(next(a for a in args if a is not type(None)), declaration, raw, where)
    if origin is tuple:
        if not isinstance(raw, list | tuple):
            raise ParamError(f"{where} = {raw!r}: must be a list")
        length = None if args[-1] is Ellipsis else len(args)
        if length is not None and len(raw) != length:
            raise ParamError(f"{where} = {raw!r}: must have {length} entries")
        return tuple(parse_value(args[0], declaration, item, f"{where}[{i}]") for i, item in enumerate(raw))
    if origin in (dict, Mapping) or (origin is not None and issubclass(origin, Mapping)):
        if not isinstance(raw, Mapping):
            raise ParamError(f"{where} must be a table")
        return {str(k): parse_value(args[1], declaration, v, f"{where}.{k}") for k, v in raw.items()}
    if isinstance(hint, type) and issubclass(hint, enum.Enum):
        for member in hint:
            if member.name.lower() == raw:
                return member
        raise ParamError(f"{where} = {raw!r}: must be {_wanted(hint, declaration)}")
    if hint in (bool, str):
        if not isinstance(raw, hint):
            raise ParamError(f"{where} = {raw!r}: must be {_wanted(hint, declaration)}")
        return raw
    return _number(hint, declaration, raw, where)


def _number(hint: Any, declaration: Declaration | None, raw: Any, where: str) -> Any:
    wanted = _wanted(hint, declaration)
    if isinstance(raw, bool) or not isinstance(raw, int | float) or (hint is int and not isinstance(raw, int)):
        raise ParamError(f"{where} = {raw!r}: must be {wanted}")
    if not math.isfinite(raw):
        raise ParamError(f"{where} = {raw!r}: must be finite, {wanted}")
    if declaration is None:
        return hint(raw)
    if not declaration.low <= raw <= declaration.high:
        raise ParamError(f"{where} = {raw!r}: out of bounds, must be {wanted}")
    return raw if hint is int else float(_to_si(float(raw), UNITS[declaration.unit][1]))


def _wanted(hint: Any, declaration: Declaration | None) -> str:
    """What a field takes, in words."""
    if is_table(hint):
        return "a table"
    if isinstance(hint, type) and issubclass(hint, enum.Enum):
        return f"one of {choices_text(hint)}"
    if typing.get_origin(hint) is tuple:
        args = typing.get_args(hint)
        each = "tables" if is_table(args[0]) else f"{len(args)} entries, each {_wanted(args[0], declaration)}"
        return f"a list of {each}"
    if hint not in (int, float):
        return {str: "a text", bool: "true or false"}.get(hint, "a table")
    text = "a whole number" if hint is int else "a number"
    if declaration is not None:
        if declaration.unit:
            text += f" in {declaration.unit}"
        if math.isfinite(declaration.low) or math.isfinite(declaration.high):
            text += f" in [{declaration.low:g}, {declaration.high:g}]"
    return text


def unknown_key_text(where: str, key: str, fields: Mapping[str, dataclasses.Field[Any]]) -> str:
    """The sentence for a key that is not one of `fields`, with what may have been meant."""
    suffixes = sorted((s for s, _ in UNITS.values()), key=len, reverse=True)
    stem = next((key[: -len(s)] for s in suffixes if s and key.endswith(s)), key)
    for right, field in fields.items():
        declaration = declaration_of(field)
        if field.name in (stem, key) and declaration is not None:
            return f"{where}: {key} has the wrong unit; write {right} (unit {declaration.unit or 'none'})"
    close = difflib.get_close_matches(key, fields, n=1)
    hint = f"did you mean {close[0]}?" if close else f"known here: {', '.join(sorted(fields))}"
    return f"{where}: {key} is unknown; {hint}"
