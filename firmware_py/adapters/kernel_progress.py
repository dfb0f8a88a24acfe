"""How far the compiling of kernels is: on a terminal one line that changes, elsewhere a line for each fifth."""

from __future__ import annotations

import shutil
import sys
import time
from types import TracebackType
from typing import TextIO

_STEPS = 5
_CLEAR = "\r\x1b[K"
"""To the first column, and nothing behind it."""


class KernelProgress:
    """Says which kernel is compiled, how many there are, and for how long it has gone on.

    Args:
        out: where to; stderr if it is not given.
    """

    def __init__(self, out: TextIO | None = None) -> None:
        self._out = out or sys.stderr
        self._terminal = self._out.isatty()
        self._began = time.monotonic()
        self._count = self._told = 0

    def update(self, count: int, total: int, name: str) -> None:
        """Say that the kernel `name`, the `count`-th of `total`, is about to be compiled."""
        self._count = count
        line = f"sternplane: compiling kernels, once: {count} of {total}, {self._seconds}"
        if self._terminal:
            room = shutil.get_terminal_size().columns - 1
            self._write(f"{_CLEAR}{f'{line}  {name}'[:room]}")
        elif count == 1 or count * _STEPS // total > self._told:
            self._told = count * _STEPS // total
            self._write(f"{line}\n")

    def __enter__(self) -> KernelProgress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._count and self._terminal:
            self._write(_CLEAR)
        if self._count and error is None:
            self._write(f"sternplane: {self._count} kernels compiled in {self._seconds}\n")

    @property
    def _seconds(self) -> str:
        return f"{time.monotonic() - self._began:.0f} s"

    def _write(self, text: str) -> None:
        self._out.write(text)
        self._out.flush()
