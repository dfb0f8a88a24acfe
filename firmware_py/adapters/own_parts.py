"""Finds the classes of parts of one's own: among the entry points of installed packages, or in a module.

| `control.law` in autopilot.toml | is |
|---|---|
| `"mine"` | the entry point `mine` of the group `sternplane.laws` |
| `"package.module:Class"` | that class; the module must be importable, as by `PYTHONPATH` |

To find one runs the code of its module, so only a configuration that one trusts may name it; a class that is no part of
the right kind is refused.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.metadata
import inspect
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeVar

from firmware_py.error_text import failure_text, probably, shortened
from firmware_py.params import ParamError

T = TypeVar("T")
_LOCAL = "<locals>"
_handed_in: dict[str, type[Any]] = {}
"""What this program handed in; like `sys.modules`, it only grows."""


def find(name: str, group: str, base: type[T], built_in: Iterable[str] = ()) -> type[T]:
    """Return the class that a name stands for.

    Args:
        name: of an entry point, or "module:Class".
        group: of the entry points.
        base: what the class must be derived from.
        built_in: the names of the built-in parts, for the error.

    Raises:
        ParamError: in one line, what is missing and how to get it.
    """
    found = _handed_in.get(name) or (_in_module(name) if ":" in name else _entry_point(name, group, tuple(built_in)))
    if not (isinstance(found, type) and issubclass(found, base)):
        raise ParamError(f"{name}: {shortened(repr(found))} is not derived from {called(base)}")
    return found


def hand_in(cls: type[Any]) -> str:
    """Make a class of the running program known to `find`; return the name that it is found by."""
    _handed_in[path_of(cls)] = cls
    return path_of(cls)


def path_of(cls: type[Any]) -> str:
    """Return the name by which a class is found again: "module:Class"; of a program, the name of its file."""
    module = cls.__module__
    if module == "__main__":
        file = getattr(importlib.import_module("__main__"), "__file__", None)
        module = Path(file).stem if file else module
    return f"{module}:{cls.__qualname__}"


def called(base: type[Any]) -> str:
    """Return what a base class is called in errors."""
    return f"sternplane.{base.__name__}"


def described(name: str, cls: type[Any]) -> dict[str, str]:
    """Return what a log's header says of a part: name, place, hash of its file, and the package that brought it."""
    try:
        source = hashlib.sha256(Path(inspect.getfile(cls)).read_bytes()).hexdigest()[:16]
    except (OSError, TypeError):
        source = "unknown"
    return {"name": name, "class": path_of(cls), "source": source, "package": _package(cls)}


def _package(cls: type[Any]) -> str:
    top = cls.__module__.partition(".")[0]
    names = importlib.metadata.packages_distributions().get(top, []) if top != "__main__" else []
    return ", ".join(f"{name} {importlib.metadata.version(name)}" for name in dict.fromkeys(names)) or "no package"


def _entry_point(name: str, group: str, built_in: tuple[str, ...]) -> Any:
    installed = {one.name: one for one in importlib.metadata.entry_points(group=group)}
    if name not in installed:
        known = sorted((*built_in, *installed))
        raise ParamError(
            f"{name}: no installed package has an entry point of this name in {group}; install the one that has, or "
            f'write "module:Class"; {probably(name, known)}'
        )
    try:
        return installed[name].load()
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever somebody's code may raise
        raise ParamError(f"{name}: {installed[name].value} cannot be imported ({failure_text(error)})") from error


def _in_module(name: str) -> Any:
    module, _, path = name.partition(":")
    if _LOCAL in path or module == "__main__":
        why = "inside a function" if _LOCAL in path else "in a program without a file"
        raise ParamError(
            f"{name}: was defined {why} and cannot be imported again; move it to a module, or hand it in again: "
            "sternplane.replay(log, [Class])"
        )
    try:
        found: Any = importlib.import_module(module)
        for step in path.split("."):
            found = getattr(found, step)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever somebody's code may raise
        missing = isinstance(error, ModuleNotFoundError) and error.name == module.partition(".")[0]
        remedy = "; install it, or name its folder: PYTHONPATH=DIR" if missing else ""
        raise ParamError(f"{name}: cannot be imported ({failure_text(error)}){remedy}") from error
    return found
