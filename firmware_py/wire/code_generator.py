"""Functions made from source text: the one module of `wire` that compiles Python.

A codec knows its layout long before the first message, and a cycle is too short to walk a tree of fields for each
message. Both codecs, DroneCAN's and the log's, therefore write the code that one would write by hand for one layout:
one unpacking assignment for each record, one `struct` call for each block of bytes.

The functions are made at start-up, not committed as files: the layout of the log depends on the vehicle (its fins and
coefficients), all DroneCAN types take 6 ms of processor time, and code from a file runs exactly as fast.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from typing import Any


class Names:
    """The names that a piece of generated source may use; `objects` holds those that stand for an object."""

    __slots__ = ("_numbers", "objects")

    def __init__(self, **objects: Any) -> None:
        self.objects: dict[str, Any] = objects
        self._numbers = itertools.count()

    def variable(self, prefix: str) -> str:
        """Return a new name for a local variable."""
        return f"{prefix}{next(self._numbers)}"

    def constant(self, prefix: str, value: Any) -> str:
        """Return a new name for `value`."""
        name = self.variable(prefix)
        self.objects[name] = value
        return name


def function_source(name: str, argument: str, lines: Iterable[str]) -> str:
    """Return the source of a function of one argument with these lines as its body."""
    return f"def {name}({argument}):\n" + "".join(f"    {line}\n" for line in lines)


def with_guard(lines: Iterable[str], errors: str, instead: str) -> list[str]:
    """Return the lines of a body that returns the value of `instead` when its own lines raise one of `errors`."""
    return ["try:", *(f"    {line}" for line in lines), f"except {errors}:", f"    return {instead}"]


def compile_function(source: str, name: str, names: Names) -> Callable[[Any], Any]:
    """Compile source and return the function `name` that it defines."""
    scope = dict(names.objects)
    exec(compile(source, f"<generated {name}>", "exec"), scope)
    function: Callable[[Any], Any] = scope[name]
    return function
