"""The logs on the disk, for ground stations that download them during a flight.

A disk may take many cycles to complete a read. So a child process reads, one block at a time, and the cycle only checks
whether a block has arrived. Implements `LogStorage` of `mavlink.files.tree`.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.child_process import ChildProcess
from firmware_py.adapters.storage.log_names import parts_in
from firmware_py.mavlink.files.tree import LogFile

_BLOCK = 1 << 16
"""Bytes that the child reads at once."""
_MAX_ANSWERS = 8
_PIPE_READ = 1 << 17
_GROWING_S = 60.0
"""A log that changed less long ago may still be growing, perhaps by another process."""
_LISTED = re.compile(r"([^/]*?)((?:\.[1-9]\d*)?)\.mcap")
"""A log's name, as it is listed: the run's folder, and the part."""
_ENDED = "the process that reads the logs has ended"
_NICENESS = 10
"""Of the child: the cycle has priority."""

_Key = tuple[str, str, int]
"""Request: what to do, name of the log, number of the block."""
_LIST: _Key = ("list", "", 0)
_ERASE: _Key = ("erase", "", 0)


class DiskLogStorage:
    """The log in a run's folder and, with `beside`, those in the folders beside it; each is named after its folder.

    Further parts of a log have their number behind that: FOLDER.mcap, FOLDER.2.mcap.
    """

    def __init__(self, folder: Path, beside: bool) -> None:
        self._child = ChildProcess(__name__, str(folder.resolve()), str(int(beside)))
        self._received = bytearray()
        self._requested: set[_Key] = set()
        self._answers: dict[_Key, bytes | OSError] = {}
        """Answers received, the oldest first; a block stays until newer ones displace it."""
        self._used: set[_Key] = set()
        """Blocks that were read from before: the log may have grown since, beyond the block's end."""

    def logs(self) -> Sequence[LogFile] | None:
        """See `LogStorage`. Each answer is a new listing of the disk."""
        content = self._answer(_LIST)
        if content is None:
            return None
        del self._answers[_LIST]
        return [LogFile(*fields) for fields in json.loads(content)]

    def read(self, name: str, offset: int, n: int) -> bytes | None:
        """See `LogStorage`."""
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

    def erase(self) -> bool:
        """See `LogStorage`."""
        if self._answer(_ERASE) is None:
            return False
        self._answers.clear()  # of logs that were
        return True

    def close(self) -> None:
        """End the child. A second call does nothing."""
        self._child.close()

    def _answer(self, key: _Key) -> bytes | None:
        """Return the answer to a request; if there is none yet, send the request and return None."""
        self._receive()
        answer = self._answers.get(key)
        if isinstance(answer, OSError):
            del self._answers[key]
            raise answer
        if answer is None and key not in self._requested and self._sent(key):
            self._requested.add(key)
        return answer

    def _sent(self, key: _Key) -> bool:
        """Write one line, which a pipe takes whole or not at all; return whether it did: if not, it is sent later."""
        try:
            os.write(self._child.stdin, json.dumps(key).encode() + b"\n")
        except BlockingIOError:
            return False
        except BrokenPipeError:
            raise OSError(errno.EIO, _ENDED) from None
        return True

    def _receive(self) -> None:
        with contextlib.suppress(BlockingIOError):
            received = os.read(self._child.stdout, _PIPE_READ)
            if not received:
                raise OSError(errno.EIO, _ENDED)
            self._received += received
        while True:
            end = self._received.find(b"\n")
            if end < 0:
                return
            head = json.loads(bytes(self._received[:end]))
            after = end + 1 + head["bytes"]
            if len(self._received) < after:
                return
            key = tuple(head["key"])
            number = head["errno"]
            self._requested.discard(key)
            self._used.discard(key)
            self._answers[key] = (
                OSError(number, os.strerror(number)) if number else bytes(self._received[end + 1 : after])
            )
            del self._received[:after]
            while len(self._answers) > _MAX_ANSWERS:
                del self._answers[next(iter(self._answers))]


def _find_logs(folder: Path, beside: bool) -> dict[str, tuple[Path, os.stat_result]]:
    """Return the logs by name, the oldest first; links to folders are left out, so that no log counts twice."""
    folders = [path for path in folder.parent.iterdir() if not path.is_symlink()] if beside else [folder]
    found: dict[str, tuple[Path, os.stat_result]] = {}
    for path in sorted(folders):
        with contextlib.suppress(OSError):
            for _, log in parts_in(path):
                found[path.name + log.name.removeprefix("log")] = log, log.stat()
    return found


def _place(folder: Path, beside: bool, name: str) -> Path:
    """Return where the log of a name is, without looking at all others.

    Raises:
        FileNotFoundError: there is no log of this name.
    """
    found = _LISTED.fullmatch(name)
    for run, part in ((found[1] + found[2], ""), (found[1], found[2])) if found else ():
        place = folder.parent / run
        allowed = run not in ("", ".", "..") and not place.is_symlink() and (beside or place == folder)
        if allowed and (place / f"log{part}.mcap").exists():
            return place / f"log{part}.mcap"
    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))


def _may_grow(folder: Path, path: Path, stat: os.stat_result) -> bool:
    return path.parent == folder or time.time() - stat.st_mtime < _GROWING_S


def _execute(folder: Path, beside: bool, key: Any) -> bytes:
    what, name, block = key
    if what == "read":
        with _place(folder, beside, name).open("rb") as file:
            file.seek(block * _BLOCK)
            return file.read(_BLOCK)
    logs = _find_logs(folder, beside)
    if what == "erase":
        for path, stat in logs.values():
            if not _may_grow(folder, path, stat):
                path.unlink(missing_ok=True)
        return b""
    listed = [
        (name, stat.st_size, int(stat.st_mtime), _may_grow(folder, path, stat)) for name, (path, stat) in logs.items()
    ]
    return json.dumps(listed).encode()


def _serve(folder: Path, beside: bool) -> None:
    """Run the child: answer each line, until the pipe is closed."""
    os.nice(_NICENESS)
    for line in sys.stdin.buffer:
        key, content, number = json.loads(line), b"", 0
        try:
            content = _execute(folder, beside, key)
        except OSError as error:
            number = error.errno or errno.EIO
        head = json.dumps({"key": key, "bytes": len(content), "errno": number}).encode()
        with contextlib.suppress(BrokenPipeError):
            sys.stdout.buffer.write(head + b"\n" + content)
            sys.stdout.buffer.flush()


if __name__ == "__main__":
    _serve(Path(sys.argv[1]), sys.argv[2] == "1")
