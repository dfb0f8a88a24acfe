"""`sternplane export`: converts a log for other tools."""

from __future__ import annotations

import argparse
import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

from rich.console import Console
from rich.progress import Progress

from firmware_py.run.usage_error import UsageError
from sternplane.logs.export import messages, table
from sternplane.logs.reading import find
from sternplane.logs.run import Run
from sternplane.logs.streaming import stream


def command(options: argparse.Namespace) -> int:
    """Write the file and print where it is."""
    path = find(options.log)
    log = stream(path)
    out = options.out or path.with_suffix(f".{options.format}")
    if out.exists() and out.samefile(path):
        raise UsageError(f"--out {out}: is the log itself; choose another file")
    total = log.count
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("export", total=total)
        write_export(log, out, options.format, lambda done: bar.update(task, completed=done))
    if log.lost:
        console.print(f"sternplane: {log.lost}", highlight=False, soft_wrap=True)
    console.print(f"  {out}", highlight=False, soft_wrap=True)
    return 0


def write_export(log: Run, out: Path, form: str, step: Callable[[int], None] = lambda _: None) -> None:
    """Write a log to a file as "bin" or "csv", whole or not at all.

    Raises:
        LogError: there is nothing to write.
        UsageError: the file cannot be written, or is there and not a regular file.
    """
    try:
        replaced = _file_to_replace(out)
        if form == "bin":
            with _whole(replaced, mode="wb") as file:
                messages.export(log, file, step)
        else:
            with _whole(replaced, mode="w", encoding="utf-8", newline="") as file:
                table.export(log, file, step)
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written ({error.strerror}); choose another file") from None


def _file_to_replace(out: Path) -> Path:
    """Return the file itself, or the regular file that it is a link to: devices, FIFOs and links are not replaced."""
    if os.path.lexists(out) and not out.is_file():
        raise UsageError(f"--out {out}: is not a regular file; choose another file")
    return out.resolve()


@contextlib.contextmanager
def _whole(out: Path, **how: Any) -> Iterator[IO[Any]]:
    """Open a file that takes its place when it is whole."""
    fresh = out.with_name(f".{out.name}.{os.getpid()}")
    try:
        with fresh.open(**how) as file:
            yield file
        fresh.replace(out)
    finally:
        fresh.unlink(missing_ok=True)
