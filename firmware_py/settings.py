"""Single values of configuration files by their keys, `FILE.KEY=VALUE`: laid upon the tables of the files.

KEY is dotted as in the file, and the value has the unit that the key names. The tables before it and the unit behind it
may be left out where one key alone is meant: `vehicle.M_q` is `vehicle.coefficients.M_q`. An entry of a list is named
by its `name` or its number, from 0: `truth.fins.rudder_upper.effectiveness`. Nothing here opens a file.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from firmware_py.error_text import probably, quoted, shortened
from firmware_py.params import (
    ParamError,
    declaration_of,
    dump,
    field_types,
    is_table,
    to_toml_value,
    toml_key,
)
from firmware_py.toml_text import refuse_times, text_of, value_of
from firmware_py.units import UNITS

Files = Mapping[str, type[Any]]
"""What each file is loaded into, by the name that stands before the first dot."""
_ENTRY, _ANYTHING = "*", "**"
"""Of a pattern: an entry of a list; whatever keys a table has that are not fixed."""
_MOST_NAMED = 4


class Setting(NamedTuple):
    """One value: the file, the key in it as the file has it, and the value as TOML has it."""

    file: str
    path: tuple[str, ...]
    value: Any

    @property
    def key(self) -> str:
        """Return the whole key, with the file before it."""
        return ".".join((self.file, *self.path))


class _Part(NamedTuple):
    """One part of a key that can be set: as TOML has it, and without the unit."""

    key: str
    bare: str


_Pattern = tuple[_Part, ...]


def parse_setting(text: str, files: Files) -> Setting:
    """Return the setting of `FILE.KEY=VALUE`; a value that is not TOML is a text.

    Raises:
        ParamError: not of this form, unknown or ambiguous, or a date; the text says what is meant probably.
    """
    key, equals, value = text.partition("=")
    if not equals or not value.strip():
        raise ParamError(f"--set {shortened(text)}: write FILE.KEY=VALUE, such as vehicle.M_q=-0.05")
    file, path = resolve_key(key.strip(), files)
    found = value_of(value)
    refuse_times(found, f"--set {shortened(text)}")
    return Setting(file, path, found)


def setting_text(key: str, value: Any) -> str:
    """Return the text from which `parse_setting` makes a value again.

    Raises:
        ParamError: no file can have such a value.
    """
    try:
        return f"{key}={text_of(value)}"
    except ParamError as error:
        raise ParamError(f"--set {key} = {error}") from None


def resolve_key(key: str, files: Files) -> tuple[str, tuple[str, ...]]:
    """Return the file of a key, and the key in it as the file has it.

    Raises:
        ParamError: unknown or ambiguous; the text says what is meant probably.
    """
    file, _, rest = key.partition(".")
    if file not in files:
        raise ParamError(
            f"--set {shortened(key)}: write FILE.KEY; {quoted(file)} is no file, {probably(file, [*files])}"
        )
    given, patterns = tuple(rest.split(".")), _patterns(files[file])
    for fits in (_fits, _fits_end):
        found = [path for pattern in patterns if (path := fits(given, pattern))]
        if len(found) == 1:
            return file, found[0]
        if found:
            meant = [f"{file}.{'.'.join(path)}" for path in found[:_MOST_NAMED]]
            more = " and others" if len(found) > _MOST_NAMED else ""
            raise ParamError(f"--set {key}: may be {', '.join(meant)}{more}; write which")
    raise ParamError(f"--set {shortened(key)}: is unknown; {_meant(file, given, patterns)}")


def lay_settings(
    cls: type[Any], table: Mapping[str, Any], settings: Sequence[Setting], where: str
) -> tuple[dict[str, Any], str]:
    """Return a file's table with settings laid upon it, to be loaded, and what to call it in errors.

    Args:
        cls: what the table is loaded into.
        table: what the file says.
        settings: of this file.
        where: the file, for error texts.

    Raises:
        ParamError: an entry of a list that is not there.
    """
    laid = dict(table)
    for setting in settings:
        laid = _put(cls, laid, setting.path, setting.value, f"--set {setting.key}")
    if settings:
        named = ", ".join([setting.key for setting in settings[:_MOST_NAMED]])
        where = f"{where} with {named}{', ...' if len(settings) > _MOST_NAMED else ''} set"
    return laid, where


def value_at(record: Any, path: Sequence[str], where: str) -> Any:
    """Return the value of a key as TOML has it, in a record that `params.load` made; None if there is none.

    Raises:
        ParamError: an entry of a list that is not there.
    """
    value: Any = dump(record)
    for part in path:
        if isinstance(value, list):
            value = value[_index(value, part, where)]
        else:
            value = value.get(part) if isinstance(value, Mapping) else None
    return value


def of_file(settings: Iterable[Setting], file: str) -> tuple[Setting, ...]:
    """Return the settings of one file."""
    return tuple([setting for setting in settings if setting.file == file])


def plain_settings(settings: Iterable[Setting]) -> dict[str, Any]:
    """Return settings as a log's header has them: whole key to value."""
    return {setting.key: setting.value for setting in settings}


def _walk(cls: type[Any]) -> Iterator[_Pattern]:
    for field in dataclasses.fields(cls):
        part, hint = _Part(toml_key(field), field.name), _hint(cls, field)
        if is_table(hint):
            yield from ((part, *below) for below in _walk(hint))
        elif typing.get_origin(hint) is tuple:
            inner, entry = typing.get_args(hint)[0], _Part(_ENTRY, _ENTRY)
            yield (part,)
            yield from ((part, entry, *below) for below in (_walk(inner) if is_table(inner) else [()]))
        elif _is_free(hint):
            yield (part, _Part(_ANYTHING, _ANYTHING))
        else:
            yield (part,)


_patterns = typing.cast("Callable[[type[Any]], tuple[_Pattern, ...]]", functools.cache(lambda cls: tuple(_walk(cls))))
"""Return every key that can be set in and below a dataclass."""


def _hint(cls: type[Any], field: dataclasses.Field[Any]) -> Any:
    """Return the type of a field; of one that may be None the other."""
    hint = field_types(cls)[field.name]
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return next(a for a in typing.get_args(hint) if a is not type(None))
    return hint


def _is_free(hint: Any) -> bool:
    origin = typing.get_origin(hint)
    return isinstance(origin, type) and issubclass(origin, Mapping)


def _fits(given: Sequence[str], pattern: _Pattern) -> tuple[str, ...]:
    """Return a whole key as the file has it; () if it is another."""
    free = bool(pattern) and pattern[-1].key == _ANYTHING
    fixed = pattern[:-1] if free else pattern
    if len(given) < len(pattern) if free else len(given) != len(pattern):
        return ()
    path = []
    for word, part in zip(given, fixed, strict=False):
        if not word or (part.key != _ENTRY and word not in part):
            return ()
        path.append(word if part.key == _ENTRY else part.key)
    return (*path, *given[len(fixed) :])


def _fits_end(given: Sequence[str], pattern: _Pattern) -> tuple[str, ...]:
    """Return the key whose end is given, from a name that is fixed on; () if it is another."""
    for i, part in enumerate(pattern[1:], 1):
        before = pattern[:i]
        fixed = part.key not in (_ENTRY, _ANYTHING) and all(one.key != _ENTRY for one in before)
        if fixed and (path := _fits(given, pattern[i:])):
            return (*(one.key for one in before), *path)
    return ()


def _meant(file: str, given: Sequence[str], patterns: Sequence[_Pattern]) -> str:
    """Return what is meant probably: of the keys that end so, or nearly so, the one most like all that is given."""
    word, whole = given[-1], shortened(".".join(given)).lower()
    found = [pattern for pattern in patterns if word in pattern[-1]]
    if not found:
        names = {name.lower() for pattern in patterns for name in pattern[-1]}
        close = difflib.get_close_matches(shortened(word).lower(), sorted(names), n=1)
        found = [pattern for pattern in patterns if close and close[0] in [name.lower() for name in pattern[-1]]]
    if not found:
        return "configs/README.md has all keys"
    like = difflib.SequenceMatcher(None, b=whole)

    def likeness(pattern: _Pattern) -> float:
        like.set_seq1(".".join([part.bare for part in pattern]).lower())
        return like.ratio()

    pattern = max(found, key=likeness)
    meant = ".".join("NAME" if part.key in (_ENTRY, _ANYTHING) else part.key for part in pattern)
    return f"did you mean {file}.{meant}?"


def _put(cls: type[Any], table: Mapping[str, Any], path: Sequence[str], value: Any, where: str) -> dict[str, Any]:
    """Return a table with a value in it or below it."""
    key, *below = path
    if not below:
        return {**table, key: value}
    field = next(one for one in dataclasses.fields(cls) if toml_key(one) == key)
    hint, now = _hint(cls, field), table.get(key, _default(field))
    if is_table(hint):
        return {**table, key: _put(hint, now or {}, below, value, where)}
    if _is_free(hint):
        return {**table, key: _put_free(now or {}, below, value)}
    entries = list(now or ())
    i = _index(entries, below[0], where)
    entries[i] = _put(typing.get_args(hint)[0], entries[i], below[1:], value, where) if below[1:] else value
    return {**table, key: entries}


def _put_free(table: Any, path: Sequence[str], value: Any) -> dict[str, Any]:
    key, *below = path
    table = table if isinstance(table, Mapping) else {}
    return {**table, key: _put_free(table.get(key), below, value) if below else value}


def _default(field: dataclasses.Field[Any]) -> Any:
    """Return what a key has, as TOML has it, that is not given."""
    declaration = declaration_of(field)
    default = field.default if field.default_factory is dataclasses.MISSING else field.default_factory()
    if default is dataclasses.MISSING:
        return None
    return to_toml_value(default, UNITS[declaration.unit][1] if declaration else 1.0)


def _index(entries: Sequence[Any], word: str, where: str) -> int:
    """Return the number of an entry, given by its name or its number."""
    names = [entry.get("name") for entry in entries if isinstance(entry, Mapping)]
    if word in names:
        return names.index(word)
    if word.isdecimal() and len(word) < 10 and int(word) < len(entries):  # thousands of digits are no number
        return int(word)
    known = [name for name in names if name] or ([f"0 to {len(entries) - 1}"] if entries else ["none"])
    raise ParamError(f"{where}: there is no entry {quoted(word)}; there: {', '.join(known)}")
