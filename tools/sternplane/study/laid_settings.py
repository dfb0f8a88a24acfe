"""The settings of the study whose runs are made now: each of its cases flies with them."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from contextvars import ContextVar
from typing import Any

from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.settings import lay_settings, of_file
from sternplane.sitl.request import CONFIG, FILES, parse_settings
from sternplane.study.rows import RunArrays

_laid: ContextVar[tuple[str, ...]] = ContextVar("laid", default=())


@contextlib.contextmanager
def laid(texts: Sequence[str]) -> Iterator[None]:
    """Lay settings upon the files that a study reads within the block.

    They are no argument of every case, since a case says what it flies and a setting is what all of them have.
    """
    token = _laid.set(tuple(texts))
    try:
        yield
    finally:
        _laid.reset(token)


def settings_now() -> tuple[str, ...]:
    """Return the settings that are laid."""
    return _laid.get()


def run_laid(texts: Sequence[str], run: Callable[[int, int], RunArrays], seed: int, k: int) -> RunArrays:
    """Make a run of a case with settings, in whatever process."""
    with laid(texts):
        return run(seed, k)


def table_now(file: str) -> dict[str, Any]:
    """Return the table of a file of the studies' configuration, with the settings that are laid."""
    cls, settings = FILES[file], of_file(parse_settings(settings_now()), file)
    return lay_settings(cls, read_toml(CONFIG / f"{file}.toml"), settings, file)[0]
