"""The logs on the disk, for stations that fetch them while the vehicle goes on.

A disk may take many cycles until it has read. So a child process reads, a block at a time, and the cycle only looks
whether a block has come; see `mavlink.shelf.Shelf`, which this is.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from firmware_py.mavlink.files.tree import LogFile

_BLOCK = 1 << 16
_MOST_BLOCKS = 8
_PIPE_READ = 1 << 17
_FRESH_S = 60.0
"""A log that was written less long ago may still be written, by whomever."""
_NAME = "log.mcap"
_GIVE_WAY = 10
"""Niceness of the child: the cycle goes first."""

_Key = tuple[str, str, int]
_LIST: _Key = ("list", "", 0)


class DiskLogStorage:
    """The logs of a run's folder, and with `beside` those of the folders beside it, each by its folder's name."""

    def __init__(self, folder: Path, beside: bool) -> None:
        self._child = subprocess.Popen(
            [sys.executable, "-m", __name__, str(folder.resolve()), str(int(beside))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C ends the flight, and only then this
        )
        assert self._child.stdin is not None
        assert self._child.stdout is not None
        self._to, self._from = self._child.stdin.fileno(), self._child.stdout.fileno()
        os.set_blocking(self._to, False)
        os.set_blocking(self._from, False)
        self._heard = bytearray()
        self._asked: set[_Key] = set()
        self._answers: dict[_Key, bytes | OSError] = {}
        """What has come, the oldest first; a block stays until others take its place."""
        self._used: set[_Key] = set()
        """Of those, what was read from before: its end may no longer be the log's."""

    def logs(self) -> Sequence[LogFile] | None:
        """See `Shelf`; each answer is a new look at the disk."""
        content = self._answer(_LIST)
        if content is None:
            return None
        del self._answers[_LIST]
        return [LogFile(*fields) for fields in json.loads(content)]

    def read(self, name: str, offset: int, n: int) -> bytes | None:
        """See `Shelf`."""
        block, begin = divmod(offset, _BLOCK)
        key = ("read", name, block)
        content = self._answer(key)
        if content is None:
            return None
        used = key in self._used
        self._used.add(key)
        part = content[begin : begin + n]
        if len(part) == n:
            return part
        if len(content) < _BLOCK:
            del self._answers[key]
            return self.read(name, offset, n) if used else part
        rest = self.read(name, (block + 1) * _BLOCK, n - len(part))
        return None if rest is None else part + rest

    def erase(self) -> None:
        """See `Shelf`."""
        self._answers.clear()
        self._say(("erase", "", 0))

    def close(self) -> None:
        """Ends the child. A second call does nothing."""
        if self._child.stdin is not None and not self._child.stdin.closed:
            self._child.stdin.close()
            self._child.wait()
            if self._child.stdout is not None:
                self._child.stdout.close()

    def _answer(self, key: _Key) -> bytes | None:
        """What has come for it; None, and it is asked for, if nothing has."""
        self._hear()
        answer = self._answers.get(key)
        if isinstance(answer, OSError):
            del self._answers[key]
            raise answer
        if answer is None and key not in self._asked:
            self._say(key)
            self._asked.add(key)
        return answer

    def _say(self, key: _Key) -> None:
        """A line is shorter than what a pipe takes as a whole; where it is full, it is asked again later."""
        line = json.dumps(key).encode() + b"\n"
        try:
            os.write(self._to, line)
        except BlockingIOError:
            return
        except BrokenPipeError:
            raise OSError(errno.EIO, "the process that reads them has ended") from None

    def _hear(self) -> None:
        with contextlib.suppress(BlockingIOError):
            self._heard += os.read(self._from, _PIPE_READ)
        while True:
            end = self._heard.find(b"\n")
            if end < 0:
                return
            head = json.loads(bytes(self._heard[:end]))
            after = end + 1 + head["bytes"]
            if len(self._heard) < after:
                return
            key = tuple(head["key"])
            number = head["errno"]
            self._asked.discard(key)
            self._used.discard(key)
            self._answers[key] = OSError(number, os.strerror(number)) if number else bytes(self._heard[end + 1 : after])
            del self._heard[:after]
            while len(self._answers) > _MOST_BLOCKS:
                del self._answers[next(iter(self._answers))]


def _found(folder: Path, beside: bool) -> dict[str, tuple[Path, os.stat_result]]:
    """The logs by name, the oldest first; what is only a link to a folder is not counted twice."""
    folders = [path for path in folder.parent.iterdir() if not path.is_symlink()] if beside else [folder]
    found: dict[str, tuple[Path, os.stat_result]] = {}
    for path in sorted(folders):
        with contextlib.suppress(OSError):
            found[f"{path.name}.mcap"] = path / _NAME, (path / _NAME).stat()
    return found


def _growing(folder: Path, path: Path, stat: os.stat_result) -> bool:
    return path.parent == folder or time.time() - stat.st_mtime < _FRESH_S


def _do(folder: Path, beside: bool, key: Any) -> bytes:
    what, name, block = key
    if what == "read":
        found = _found(folder, beside).get(name)
        if found is None:
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
        with found[0].open("rb") as file:
            file.seek(block * _BLOCK)
            return file.read(_BLOCK)
    logs = _found(folder, beside)
    if what == "erase":
        for path, stat in logs.values():
            if not _growing(folder, path, stat):
                path.unlink(missing_ok=True)
        return b""
    listed = [
        (name, stat.st_size, int(stat.st_mtime), _growing(folder, path, stat)) for name, (path, stat) in logs.items()
    ]
    return json.dumps(listed).encode()


def _serve(folder: Path, beside: bool) -> None:
    """The child: answers line by line, until nobody can ask any more."""
    os.nice(_GIVE_WAY)
    for line in sys.stdin.buffer:
        key, content, number = json.loads(line), b"", 0
        try:
            content = _do(folder, beside, key)
        except OSError as error:
            number = error.errno or errno.EIO
        head = json.dumps({"key": key, "bytes": len(content), "errno": number}).encode()
        with contextlib.suppress(BrokenPipeError):
            sys.stdout.buffer.write(head + b"\n" + content)
            sys.stdout.buffer.flush()


if __name__ == "__main__":
    _serve(Path(sys.argv[1]), sys.argv[2] == "1")
