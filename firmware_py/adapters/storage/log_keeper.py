"""Brings the log that is written to the disk, and removes the oldest logs when they take more room than they may.

A disk may take many cycles for either. So a child process does it, and the cycle only tells it which log is written. It
ends with the flight, however that ends, and then brings to the disk what the kernel has.
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import sys
import time
from collections.abc import Callable
from pathlib import Path

from firmware_py.adapters.storage.atomic_file import to_disk
from firmware_py.adapters.storage.child_process import ChildProcess
from firmware_py.adapters.storage.log_names import NamedLog, logs_below
from firmware_py.adapters.storage.log_params import LogParams

_NICENESS = 10
"""Of the child: the cycle has priority."""
_BOUNDS_S = 60.0
"""How often the room is looked at, besides at each new part."""
_GROWING_S = 60.0
"""A log that changed less long ago may still be written, perhaps by another process."""
_AGAIN_S = 60.0
"""When a log that could not be brought to the disk is tried again."""
_PIPE_READ = 1 << 16
_CLOSE_S = 10.0
"""How long `close` waits for the child: a disk that takes longer does not keep a vehicle from starting again."""


class LogKeeper:
    """The child process.

    Args:
        root: the folder of all flights, whose oldest logs may be removed; None where nothing may.
        params: how much room logs may take, and how often one is brought to the disk.
    """

    def __init__(self, root: Path | None, params: LogParams) -> None:
        bounds = params.total_size, params.free_size, params.sync_interval
        words = ["" if root is None else str(root.resolve()), *map(str, bounds)]
        ended = "the process that brings the log to the disk has ended; a power cut may cost more of it"
        self._child = ChildProcess(__name__, *words, ended=ended)

    def written(self, path: Path) -> None:
        """Tell which log is written from now on; return at once."""
        with contextlib.suppress(BlockingIOError, BrokenPipeError):  # of the latter `said` tells
            os.write(self._child.stdin, f"{path.resolve()}\n".encode())

    def said(self) -> list[str]:
        """Return what it has to say since the last call, one sentence each; mostly nothing."""
        return self._child.said(_PIPE_READ)

    def close(self) -> None:
        """Wait until the log is on the disk. A second call does nothing."""
        self._child.close(_CLOSE_S)


def remove_oldest(root: Path, written: list[Path], total: float, free: float) -> list[NamedLog]:
    """Remove the oldest logs until the others take no more than they may; return those that were removed.

    Args:
        root: the folder of all flights.
        written: logs that are being written, which stay.
        total: bytes that logs may take.
        free: bytes that are to stay free.

    Raises:
        OSError: the folder cannot be listed, or a log not be removed.
    """
    logs, taken = logs_below(root), {}
    for log in logs:
        with contextlib.suppress(FileNotFoundError):
            taken[log] = log.path.stat()
    size, removed = sum(stat.st_size for stat in taken.values()), []
    for log, stat in taken.items():
        if size <= total and _free(root) >= free:
            break
        if log.path in written or abs(time.time() - stat.st_mtime) < _GROWING_S:
            continue
        log.path.unlink(missing_ok=True)
        size -= stat.st_size
        removed.append(log)
        with contextlib.suppress(OSError):  # it holds something else
            log.path.parent.rmdir()
    return removed


def _free(folder: Path) -> int:
    disk = os.statvfs(folder)
    return disk.f_bavail * disk.f_frsize


class DiskSync:
    """Brings the logs that are written to the disk; one that cannot be is told, and tried again later.

    Attributes:
        written: the last two that were begun, without those that are gone: of the one before the index may not be
            written yet.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self.written: list[Path] = []
        self._begun: set[Path] = set()
        """Those whose place in the folder is not on the disk yet."""
        self._again: dict[Path, float] = {}
        """When to try those again that could not be brought to the disk, s."""

    def begin(self, path: Path) -> None:
        """Note that a log is written from now on."""
        self.written = [*self.written, path][-2:]
        self._begun.add(path)

    def sync(self, t: float) -> None:
        """Bring all of them to the disk, at time t, s."""
        for path in [path for path in self.written if t >= self._again.get(path, -math.inf)]:
            try:
                _to_disk(path, path in self._begun)
                self._begun.discard(path)
            except OSError as error:
                self._say(f"{path}: cannot be brought to the disk ({error.strerror})")
                self._again[path] = t + _AGAIN_S
                if isinstance(error, FileNotFoundError):
                    self.written.remove(path)


def _to_disk(path: Path, begun: bool) -> None:
    """Bring a log to the disk; at its begin its place in the folder too."""
    for one in (path, path.parent) if begun else (path,):
        to_disk(one, data_only=not begun)


def _say(sentence: str) -> None:
    with contextlib.suppress(OSError):
        os.write(1, f"{sentence}\n".encode())


def _bound(root: Path, written: list[Path], total: float, free: float) -> None:
    try:
        removed = remove_oldest(root, written, total, free)
        left = _free(root)
    except OSError as error:
        _say(f"old logs below {root} cannot be removed ({error.strerror})")
        return
    if removed:
        logs = "1 old log" if len(removed) == 1 else f"{len(removed)} old logs"
        _say(f"{logs} removed to make room, up to {removed[-1].path}")
    if left < free:
        _say(f"{root}: {left / 1e6:.0f} MB are free and no old logs are left to remove; make room")


def _serve(root: Path | None, total: float, free: float, interval: float) -> None:
    """Run the child, until the pipe is closed."""
    os.nice(_NICENESS)
    logs = DiskSync(_say)
    bounded = -_BOUNDS_S
    while True:
        told = select.select([0], [], [], interval)[0]
        lines = os.read(0, _PIPE_READ) if told else b""
        begun = [Path(line) for line in lines.decode().splitlines()]
        for path in begun:
            logs.begin(path)
        over = bool(told) and not lines
        logs.sync(math.inf if over else time.monotonic())
        if over:
            return
        if root is not None and (begun or time.monotonic() - bounded > _BOUNDS_S):
            bounded = time.monotonic()
            _bound(root, logs.written, total, free)


if __name__ == "__main__":
    _serve(Path(sys.argv[1]) if sys.argv[1] else None, *map(float, sys.argv[2:]))
