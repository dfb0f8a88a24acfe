"""A run as it is compared: what it is called, how it was steered, its summary, and its figures up to a time."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firmware_py.run.usage_error import UsageError
from sternplane.logs.reading import LARGE, Columns, Piece, find
from sternplane.logs.run import Run
from sternplane.logs.streaming import StreamedLog, stream
from sternplane.logs.summary import Summary, summarise

LEAST, MOST = 2, 8
"""So many runs are compared; more have no colours that anybody could tell apart."""


@dataclass(frozen=True)
class ComparedRun:
    """One of the runs.

    Attributes:
        name: what it is called on the page.
        log: the log.
        summary: as summary.json has it.
    """

    name: str
    log: StreamedLog
    summary: Summary

    @property
    def has_truth(self) -> bool:
        """Whether its figures are against the truth."""
        return bool(self.summary["against"] == "truth")

    @property
    def length(self) -> float:
        """How much of it was logged, s."""
        return float(self.summary["logged_s"])


def open_runs(words: Sequence[str], tell: Callable[[str], None] = lambda _: None) -> list[ComparedRun]:
    """Read the runs of a command line: each a folder or a log, or NAME=LOG; `tell` hears of those that take a while.

    Raises:
        UsageError: too few or too many, or two of one name.
        LogError: one cannot be read.
    """
    if not LEAST <= len(words) <= MOST:
        raise UsageError(f"{len(words)} run{'s' * (len(words) != 1)}: give {LEAST} to {MOST} runs to compare")
    named = [_named(word) for word in words]
    paths = [path for _, path in named]
    names = [name or default for (name, _), default in zip(named, _short_names(paths), strict=True)]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise UsageError(f"two runs are called {twice}: give each a name of its own, such as first=LOG")
    return [_opened(name, find(path), tell) for name, path in zip(names, paths, strict=True)]


def _opened(name: str, path: Path, tell: Callable[[str], None]) -> ComparedRun:
    if path.exists() and (size := path.stat().st_size) > LARGE:
        tell(f"reading {name}, a log of {size / 1e6:.0f} MB")
    log = stream(path)
    return ComparedRun(name, log, summarise(log))


def _named(word: str) -> tuple[str, Path]:
    name, equals, rest = word.partition("=")
    return (name, Path(rest)) if equals and name and not Path(word).exists() else ("", Path(word))


def _short_names(paths: Sequence[Path]) -> list[str]:
    """Return the ends of paths, as long as it takes for each to be another one."""
    parts = [[one for one in Path(os.path.realpath(path)).parts if one != "log.mcap"] for path in paths]
    for length in range(1, max(map(len, parts)) + 1):
        names = ["/".join(one[-length:]) for one in parts]
        if len(set(names)) == len(names):
            return names
    return ["/".join(one[-1:]) for one in parts]


def until(log: Run, t_end: float) -> Run:
    """Return the first part of a run, up to a time, s."""
    return _FirstPart(log, t_end)


class _FirstPart:
    """A run of which only the first cycles count; all else is the run's."""

    def __init__(self, log: Run, t_end: float) -> None:
        self._log, self._t_end = log, t_end

    def __getattr__(self, name: str) -> Any:
        return getattr(self._log, name)

    def pieces(self, multiple: int = 1) -> Iterator[Piece]:
        """Yield the cycles that count."""
        whole = self._log.pieces(multiple)
        for begin, columns, truth in itertools.takewhile(lambda piece: piece.columns["t"][0] < self._t_end, whole):
            count = int((columns["t"] < self._t_end).sum())
            yield Piece(begin, _first(columns, count), _first(truth, count))


def _first(columns: Columns, count: int) -> Columns:
    return {name: values[:count] for name, values in columns.items()}
