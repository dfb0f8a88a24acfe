"""Declaration of parameters, and their conversion from and to TOML tables.

A parameter is declared once, beside the code that uses it, as a field of a frozen dataclass made by `param`. The TOML
loader, the reference in configs/README.md and the ground stations' parameter list follow from the declaration. The key
in TOML is the field's name with its unit appended (`delta_max_deg = 23`); inside, values are SI: radians, metres,
rev/s. Nothing here opens a file.
"""

from __future__ import annotations

import contextlib
import dataclasses
import enum
import functools
import math
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from firmware_py.error_text import did_you_mean, probably, quoted, shortened
from firmware_py.part_name import PartName, is_part_name
from firmware_py.units import UNITS, from_si, to_si

T = TypeVar("T")
_DECLARATION = "sternplane"
_PREFIX = "sternplane.prefix"
_MAVLINK_NAME_MAX = 16
"""Characters of param_id in PARAM_VALUE."""


class ParamError(ValueError):
    """A configuration that cannot be used. The text names the file, the key and what is expected."""


@contextlib.contextmanager
def prefix_errors(where: str) -> Iterator[None]:
    """Turn a ValueError raised inside into a ParamError that begins with `where`, the file the numbers came from."""
    try:
        yield
    except ValueError as error:
        raise ParamError(f"{where}: {error}") from None


class TakesEffect(enum.Enum):
    """When a change made by a ground station takes effect."""

    AT_ONCE = enum.auto()
    DISARMED = enum.auto()
    """At once, but refused while armed: a change in flight would jerk the fins."""
    RESTART = enum.auto()
    """At the next start, because array sizes depend on it; saved until then."""


@dataclass(frozen=True, slots=True)
class Declaration:
    """Declaration of one parameter, as given to `param`."""

    unit: str
    low: float
    high: float
    doc: str
    mav: str
    when: TakesEffect
    refused: tuple[enum.Enum, ...] = ()
    why: str = ""


def param(
    default: Any = dataclasses.MISSING,
    *,
    unit: str = "",
    low: float = -math.inf,
    high: float = math.inf,
    doc: str = "",
    mav: str = "",
    when: TakesEffect = TakesEffect.AT_ONCE,
    refused: tuple[enum.Enum, ...] = (),
    why: str = "",
) -> Any:
    """Declare a parameter: a field of a frozen dataclass.

    Args:
        default: in `unit`, not in SI; without one the parameter is required.
        unit: one of `units.UNITS`.
        low: least value, in `unit`.
        high: greatest value, in `unit`.
        doc: what it does, and what a larger or smaller value changes.
        mav: end of its MAVLink name, after the prefixes that `table` gives; without one ground stations do not see it.
            Each entry of a list has a name of its own, with a number from 1 appended.
        when: when a change by a ground station takes effect.
        refused: members of its enum that cannot be chosen, and
        why: they cannot, for error texts.

    Raises:
        ValueError: unknown unit, or a MAVLink name that is too long.
    """
    if unit not in UNITS:
        raise ValueError(f"unit {unit!r} is not declared in units.UNITS")
    if len(mav) > _MAVLINK_NAME_MAX:
        raise ValueError(f"MAVLink name {mav!r} is longer than {_MAVLINK_NAME_MAX} characters")
    metadata = {_DECLARATION: Declaration(unit, low, high, doc, mav, when, refused, why)}
    if default is dataclasses.MISSING:
        return dataclasses.field(metadata=metadata)
    return dataclasses.field(default=to_si(default, UNITS[unit][1]), metadata=metadata)


def table(cls: type[Any], mav: str = "") -> Any:
    """Declare a table of parameters with the defaults of `cls`; their MAVLink names begin with `mav`."""
    return dataclasses.field(default_factory=cls, metadata={_PREFIX: mav})


def named_values(doc: str) -> Any:
    """Declare a table whose keys are not fixed; empty by default."""
    metadata = {_DECLARATION: Declaration("", -math.inf, math.inf, doc, "", TakesEffect.AT_ONCE)}
    return dataclasses.field(default_factory=dict, metadata=metadata)


def declaration_of(field: dataclasses.Field[Any]) -> Declaration | None:
    """Return the declaration of a field, or None for a field that `param` did not make."""
    return typing.cast("Declaration | None", field.metadata.get(_DECLARATION))


def mavlink_prefix(field: dataclasses.Field[Any]) -> str:
    """Return what the MAVLink names of the parameters in a table begin with."""
    return str(field.metadata.get(_PREFIX, ""))


def toml_key(field: dataclasses.Field[Any]) -> str:
    """Return the key of a field in TOML: its name with its unit appended."""
    declaration = declaration_of(field)
    return field.name + (UNITS[declaration.unit][0] if declaration else "")


def load(cls: type[T], table: Mapping[str, Any], where: str) -> T:
    """Return a `cls` made from a TOML table.

    Args:
        cls: a dataclass whose fields are parameters, nested dataclasses, tuples of them, enums, str, bool, int, float.
        table: what `tomllib` read.
        where: file and path of the table in it, for error texts.

    Raises:
        ParamError: unknown key, missing key, wrong unit, wrong type or out of bounds.
    """
    hints = field_types(cls)
    fields = {toml_key(f): f for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    for key in table:
        if key not in fields:
            told = getattr(cls, "ELSEWHERE", {}).get(key)  # where it belongs
            raise ParamError(f"{where}: {key} {told}" if told else unknown_key_text(where, key, fields))
    values: dict[str, Any] = {}
    for key, field in fields.items():
        if key in table:
            values[field.name] = parse_value(hints[field.name], declaration_of(field), table[key], f"{where}: {key}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ParamError(f"{where}: {key} is missing ({_expected(hints[field.name], declaration_of(field))})")
    try:
        return cls(**values)
    except ParamError as error:
        raise ParamError(f"{where}: {error}") from None


def dump(record: Any) -> dict[str, Any]:
    """Return the TOML (and JSON) table from which `load` makes exactly this record again."""
    table: dict[str, Any] = {}
    for field in dataclasses.fields(record):
        declaration = declaration_of(field)
        factor = UNITS[declaration.unit][1] if declaration else 1.0
        table[toml_key(field)] = to_toml_value(getattr(record, field.name), factor)
    return table


field_types = typing.cast("Callable[[type[Any]], dict[str, Any]]", functools.cache(typing.get_type_hints))
"""Return the types of a dataclass's fields. Cached: resolving them takes as long as a cycle."""


def choices_text(choices: type[enum.Enum], declaration: Declaration | None) -> str:
    """Return those of an enum's members that a declaration leaves, as they are written in TOML, between commas."""
    return ", ".join(f'"{name}"' for name in choice_names(choices, declaration.refused if declaration else ()))


def choice_names(choices: Iterable[enum.Enum], refused: Sequence[enum.Enum] = ()) -> tuple[str, ...]:
    """Return members of an enum as they are written in TOML, without those that are refused."""
    return tuple(member.name.lower() for member in choices if member not in refused)


def is_table(hint: Any) -> bool:
    """Return whether a field of this type holds a table."""
    return isinstance(hint, type) and dataclasses.is_dataclass(hint)


def to_toml_value(value: Any, factor: float) -> Any:
    """Return a value as TOML has it, in a unit of `factor` SI units."""
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
    return from_si(value, factor)


def parse_value(hint: Any, declaration: Declaration | None, raw: Any, where: str) -> Any:
    """Return the value of a field of type `hint` from its TOML value `raw`; raises as `load`."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if is_table(hint):
        if not isinstance(raw, Mapping):
            raise ParamError(f"{where} must be a table")
        return load(hint, raw, where)
    if origin in (typing.Union, types.UnionType):
        first = next(a for a in args if a is not type(None))
        if PartName in args and is_part_name(raw, choice_names(first)):
            return PartName(raw)
        return parse_value(first, declaration, raw, where)
    if hint is Any:
        return raw
    if origin is tuple:
        if not isinstance(raw, list | tuple):
            raise ParamError(f"{where} = {quoted(raw)}: must be a list")
        length = None if args[-1] is Ellipsis else len(args)
        if length is not None and len(raw) != length:
            raise ParamError(f"{where} = {quoted(raw)}: must have {length} entries")
        return tuple(parse_value(args[0], declaration, item, f"{where}[{i}]") for i, item in enumerate(raw))
    if origin in (dict, Mapping) or (origin is not None and issubclass(origin, Mapping)):
        if not isinstance(raw, Mapping):
            raise ParamError(f"{where} must be a table")
        return {str(k): parse_value(args[1], declaration, v, f"{where}.{shortened(str(k))}") for k, v in raw.items()}
    if isinstance(hint, type) and issubclass(hint, enum.Enum):
        taken = _expected(hint, declaration)
        for member in hint:
            if member.name.lower() == raw:
                if declaration and member in declaration.refused:
                    raise ParamError(f'{where} = "{raw}": {declaration.why}; must be {taken}')
                return member
        meant = did_you_mean(raw, choice_names(hint))
        raise ParamError(f"{where} = {quoted(raw)}: must be {taken}{meant and f'; {meant}'}")
    if hint in (bool, str):
        if not isinstance(raw, hint):
            raise ParamError(f"{where} = {quoted(raw)}: must be {_expected(hint, declaration)}")
        return raw
    return _parse_number(hint, declaration, raw, where)


def _parse_number(hint: Any, declaration: Declaration | None, raw: Any, where: str) -> Any:
    expected = _expected(hint, declaration)
    if isinstance(raw, bool) or not isinstance(raw, int | float) or (hint is int and not isinstance(raw, int)):
        raise ParamError(f"{where} = {quoted(raw)}: must be {expected}")
    if not _is_finite(raw):
        raise ParamError(f"{where} = {quoted(raw)}: must be finite, {expected}")
    if declaration is None:
        return hint(raw)
    if not declaration.low <= raw <= declaration.high:
        raise ParamError(f"{where} = {quoted(raw)}: out of bounds, must be {expected}")
    return raw if hint is int else float(to_si(float(raw), UNITS[declaration.unit][1]))


def _is_finite(raw: float) -> bool:
    """Return whether a number is finite as a double; an integer may be too large for one."""
    try:
        return math.isfinite(raw)
    except OverflowError:
        return False


def _expected(hint: Any, declaration: Declaration | None) -> str:
    """Return what a field accepts, as words for an error text."""
    if is_table(hint):
        return "a table"
    if isinstance(hint, type) and issubclass(hint, enum.Enum):
        return f"one of {choices_text(hint, declaration)}"
    if typing.get_origin(hint) is tuple:
        args = typing.get_args(hint)
        each = "tables" if is_table(args[0]) else f"{len(args)} entries, each {_expected(args[0], declaration)}"
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
    """Return the error text for a key that is not one of `fields`, with the key that was probably meant."""
    key, suffixes = shortened(key), sorted((s for s, _ in UNITS.values()), key=len, reverse=True)
    stem = next((key[: -len(s)] for s in suffixes if s and key.endswith(s)), key)
    for right, field in fields.items():
        declaration = declaration_of(field)
        if field.name in (stem, key) and declaration is not None:
            return f"{where}: {key} has the wrong unit; write {right} (unit {declaration.unit or 'none'})"
    return f"{where}: {key} is unknown; {probably(key, sorted(fields))}"
