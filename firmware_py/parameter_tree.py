"""The parameters of a configuration as a tree: listed for the reference, named for ground stations, changed singly."""

from __future__ import annotations

import dataclasses
import enum
import math
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from firmware_py.params import (
    Declaration,
    ParamError,
    TakesEffect,
    choice_names,
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
from firmware_py.part_name import PartName
from firmware_py.units import UNITS

T = TypeVar("T")


def describe_keys(cls: type[Any], table: str = "", name: str = "") -> Iterator[tuple[str, Declaration, Any]]:
    """Yield (dotted key, declaration, default in its unit or MISSING) of every parameter in and below a dataclass.

    The declarations carry the full MAVLink name; for a list, without the number of the entry. `table` and `name` are
    the prefixes of key and MAVLink name, for the recursion.
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
            doc=_doc_of(declaration, hint),
            mav=declaration.mav and name + declaration.mav,
        )
        if field.default_factory is not dataclasses.MISSING:
            default = field.default_factory()
        elif default is not dataclasses.MISSING:
            default = to_toml_value(default, UNITS[declaration.unit][1])
        yield table + toml_key(field), declaration, default


def _doc_of(declaration: Declaration, hint: Any) -> str:
    """Return the help text: the declared one, else one for the type; with the choices, if it is an enum."""
    choices = next(
        (a for a in (hint, *typing.get_args(hint)) if isinstance(a, type) and issubclass(a, enum.Enum)), None
    )
    if choices is None:
        return declaration.doc or {str: "Text.", bool: "true or false."}.get(hint, "")
    others = ", or the name of one's own" if PartName in typing.get_args(hint) else ""
    return f"{declaration.doc or _first_line(choices)} One of {choices_text(choices, declaration)}{others}."


def _first_line(cls: type[Any]) -> str:
    return (cls.__doc__ or "").partition("\n")[0]


def with_values(record: T, values: Mapping[str, Any], where: str) -> T:
    """Return a copy of a record with other values, checked as `params.load` does. Unchanged tables are shared.

    Args:
        record: made by `params.load`.
        values: dotted key, as in TOML, to value in the unit of the key.
        where: the file, for error texts.

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
            raise ParamError(f"{where}: {key} is not a table")
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


def value_text(record: Any, dotted: str) -> str:
    """Return the value of a dotted key as TOML has it, a number to six digits."""
    key, _, rest = dotted.partition(".")
    field = next(f for f in dataclasses.fields(record) if toml_key(f) == key)
    value, declaration = getattr(record, field.name), declaration_of(field)
    if rest:
        return value_text(value, rest)
    return plain_text(to_toml_value(value, UNITS[declaration.unit][1] if declaration else 1.0))


def plain_text(value: Any) -> str:
    """Return a value of a TOML file as it has it, a number to six digits."""
    return str(value).lower() if isinstance(value, bool) else f"{value:g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number, truth value or choice that a ground station may see and change.

    Attributes:
        name: MAVLink name, at most 16 characters.
        key: dotted key, as in TOML.
        index: index in a list, from 0; -1 for a value that is not in a list.
        value: present value, in `unit`; true is 1, a choice is its index in `choices`.
        base: value in the configuration's files, without changes by ground stations.
        default: value if no file gives one; None if a file must.
        unit: of value, base, default and bounds.
        low: least value; -inf for none.
        high: greatest value; inf for none.
        is_integer: true for a count, a truth value or a choice.
        choices: names of the values 0, 1, ...; empty for numbers.
        refused: those of them that cannot be chosen.
        group: table that the key is in.
        doc: help text.
        when: when a change takes effect.
    """

    name: str
    key: str
    index: int
    value: float
    base: float
    default: float | None
    unit: str
    low: float
    high: float
    is_integer: bool
    choices: tuple[str, ...]
    refused: tuple[str, ...]
    group: str
    doc: str
    when: TakesEffect

    @property
    def allowed(self) -> Iterator[tuple[int, str]]:
        """Yield value and name of each choice that can be made."""
        return ((i, choice) for i, choice in enumerate(self.choices) if choice not in self.refused)


def list_parameters(record: Any, base: Any = None, group: str = "", name: str = "") -> Iterator[Parameter]:
    """Yield the parameters in and below a record that `params.load` made; `base` is it before stations changed it."""
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
        kind = type(default if isinstance(value, PartName) else value)
        choices = choice_names(kind) if issubclass(kind, enum.Enum) else ()
        choices += tuple(dict.fromkeys(str(one) for one in (was, now) if isinstance(one, PartName)))
        low, high = (0.0, len(choices) - 1.0) if choices else (declaration.low, declaration.high)
        if kind is bool:
            low, high = 0.0, 1.0
        before, first = (_entry(x, i, listed) for x in (was, default))
        yield Parameter(
            name=f"{name}{i + 1}" if listed else name,
            key=f"{group}.{toml_key(field)}",
            index=i if listed else -1,
            value=_as_number(value, declaration, choices),
            base=_as_number(before, declaration, choices),
            default=None if first is None else _as_number(first, declaration, choices),
            unit=declaration.unit,
            low=low,
            high=high,
            is_integer=kind is not float,
            choices=("false", "true") if kind is bool else choices,
            refused=choice_names(declaration.refused),
            group=group,
            doc=declaration.doc or _first_line(kind),
            when=declaration.when,
        )


def _entry(value: Any, i: int, listed: bool) -> Any:
    if not listed or value is None:
        return value
    return value[i] if i < len(value) else None


def _as_number(value: Any, declaration: Declaration, choices: tuple[str, ...]) -> float:
    if isinstance(value, enum.Enum | PartName):
        return float(choices.index(value if isinstance(value, PartName) else value.name.lower()))
    return float(to_toml_value(value, UNITS[declaration.unit][1]))
