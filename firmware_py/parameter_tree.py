"""The parameters of a configuration as one tree: listed for people, named for ground stations, changed one by one."""

from __future__ import annotations

import dataclasses
import enum
import math
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from firmware_py.params import (
    UNITS,
    Declaration,
    ParamError,
    TakesEffect,
    choices_text,
    declaration_of,
    field_types,
    is_table,
    mavlink_prefix,
    parse_value,
    to_toml_value,
    toml_key,
    unknown_key_text,
)

T = TypeVar("T")


def describe_keys(cls: type[Any], table: str = "", name: str = "") -> Iterator[tuple[str, Declaration, Any]]:
    """Every number, choice and text below a dataclass: (dotted key, declaration, default in its unit or MISSING).

    The declarations have the whole of the MAVLink name, as far as it is the same for all entries of a list.
    """
    hints = field_types(cls)
    for field in dataclasses.fields(cls):
        hint, default = hints[field.name], field.default
        inner = next((a for a in (hint, *typing.get_args(hint)) if is_table(a)), None)
        if inner is not None:
            repeated = "[]" if typing.get_origin(hint) is tuple else ""
            yield from describe_keys(inner, f"{table}{field.name}{repeated}.", name + mavlink_prefix(field))
            continue
        declaration = declaration_of(field) or Declaration("", -math.inf, math.inf, "", "", TakesEffect.AT_ONCE)
        declaration = dataclasses.replace(
            declaration,
            doc=declaration.doc or _said_of(hint),
            mav=declaration.mav and name + declaration.mav,
        )
        if default is not dataclasses.MISSING:
            default = to_toml_value(default, UNITS[declaration.unit][1])
        yield table + toml_key(field), declaration, default


def _said_of(hint: Any) -> str:
    """A sentence for a field that has none: the choices of an enum, else its type."""
    choices = next(
        (a for a in (hint, *typing.get_args(hint)) if isinstance(a, type) and issubclass(a, enum.Enum)), None
    )
    if choices is None:
        return {str: "A text.", bool: "true or false."}.get(hint, "")
    return f"{(choices.__doc__ or '').partition(chr(10))[0]} One of {choices_text(choices)}."


def with_values(record: T, values: Mapping[str, Any], where: str) -> T:
    """The record with other values, checked as `params.load` does; what it has in common with the old one is shared.

    Args:
        record: made by `params.load`.
        values: dotted key, as in TOML, to the value in the unit of the key.
        where: the file, for the error.

    Raises:
        ParamError: as `params.load`.
    """
    fields = {toml_key(f): f for f in dataclasses.fields(record)}  # type: ignore[arg-type]
    hints = field_types(type(record))
    inner: dict[str, dict[str, Any]] = {}
    new: dict[str, Any] = {}
    for dotted, value in values.items():
        key, _, rest = dotted.partition(".")
        if key not in fields:
            raise ParamError(unknown_key_text(where, key, fields))
        if rest and not is_table(hints[fields[key].name]):
            raise ParamError(f"{where}: {key} is no table")
        if rest:
            inner.setdefault(key, {})[rest] = value
        else:
            field = fields[key]
            new[field.name] = parse_value(hints[field.name], declaration_of(field), value, f"{where}: {key}")
    for key, below in inner.items():
        new[key] = with_values(getattr(record, key), below, f"{where}: {key}")
    try:
        changed: T = dataclasses.replace(record, **new)  # type: ignore[type-var]
    except ParamError as error:
        raise ParamError(f"{where}: {error}") from None
    return changed


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number, truth or choice that a ground station may see and change; numbers are in the unit of the key.

    Attributes:
        name: MAVLink's, of at most 16 characters.
        key: dotted, as in TOML.
        place: which of a list, counted from 0; -1 if the value is none.
        value: as it stands; true is 1, a choice is its place among `choices`.
        base: as the configuration's files have it, without what stations have changed.
        default: as it is where no file says anything; None if a file must.
        unit: of all these.
        low: least value, -inf none; `high` greatest.
        high: see low.
        whole: no fractions: a count, a truth or a choice.
        choices: what 0, 1, ... stand for, empty for numbers.
        group: of the key: the table it is in.
        doc: a sentence.
        when: a change may take effect.
    """

    name: str
    key: str
    place: int
    value: float
    base: float
    default: float | None
    unit: str
    low: float
    high: float
    whole: bool
    choices: tuple[str, ...]
    group: str
    doc: str
    when: TakesEffect


def list_parameters(record: Any, base: Any = None, group: str = "", name: str = "") -> Iterator[Parameter]:
    """What a station may change below a record that `params.load` made; `base` is the one before it was changed."""
    base = record if base is None else base
    for field in dataclasses.fields(record):
        declaration = declaration_of(field)
        now, was = getattr(record, field.name), getattr(base, field.name)
        if dataclasses.is_dataclass(now):
            inner = f"{group}.{field.name}" if group else field.name
            yield from list_parameters(now, was, inner, name + mavlink_prefix(field))
        elif declaration is not None and declaration.mav:
            yield from _entries(field, declaration, now, was, group, name + declaration.mav)


def _entries(
    field: dataclasses.Field[Any], declaration: Declaration, now: Any, was: Any, group: str, name: str
) -> Iterator[Parameter]:
    listed = isinstance(now, tuple)
    default = None if field.default is dataclasses.MISSING else field.default
    for i, value in enumerate(now if listed else (now,)):
        kind = type(value)
        choices = tuple(m.name.lower() for m in kind) if issubclass(kind, enum.Enum) else ()
        low, high = (0.0, len(choices) - 1.0) if choices else (declaration.low, declaration.high)
        if kind is bool:
            low, high = 0.0, 1.0
        before, first = (_entry(x, i, listed) for x in (was, default))
        yield Parameter(
            name=f"{name}{i + 1}" if listed else name,
            key=f"{group}.{toml_key(field)}",
            place=i if listed else -1,
            value=_as_number(value, declaration),
            base=_as_number(before, declaration),
            default=None if first is None else _as_number(first, declaration),
            unit=declaration.unit,
            low=low,
            high=high,
            whole=kind is not float,
            choices=("false", "true") if kind is bool else choices,
            group=group,
            doc=declaration.doc or (kind.__doc__ or "").partition("\n")[0],
            when=declaration.when,
        )


def _entry(value: Any, i: int, listed: bool) -> Any:
    if not listed or value is None:
        return value
    return value[i] if i < len(value) else None


def _as_number(value: Any, declaration: Declaration) -> float:
    if isinstance(value, enum.Enum):
        return float(list(type(value)).index(value))
    return float(to_toml_value(value, UNITS[declaration.unit][1]))
