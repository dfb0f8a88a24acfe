"""The state folder: files that the vehicle keeps from one start to the next, each written whole or not at all.

A disk may take many cycles to complete a write. So a child process writes, and the cycle only passes on what fits into
a pipe; the rest is queued. If the vehicle's process is killed, the child first writes what it has received.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import struct
import sys
from pathlib import Path
from types import TracebackType

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.child_process import ChildProcess
from firmware_py.adapters.storage.regular_file import FolderError, make_folder

_FRAME_HEADER = struct.Struct("<HI")
"""Lengths of name and content in bytes; both follow."""
_PIPE_BYTES = 1 << 20
_CLOSE_S = 30.0
"""How long `close` waits for the child to take more, and then to end."""
_ERRORS_READ = 4096
_NICENESS = 10
"""Of the child: the cycle has priority."""


class StateStoreError(Exception):
    """A state folder that cannot be written. The text names it and what to do."""


class StateStore:
    """The state folder, created if it is missing, and the child process that writes into it.

    Raises:
        StateStoreError: the folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            make_folder(folder)
        except FolderError as error:
            raise StateStoreError(f"{error}; choose another --state") from None
        if not os.access(folder, os.W_OK):
            raise StateStoreError(f"{folder}: cannot be written; choose another --state")
        ended = f"{folder}: the process that writes it has ended; what is changed from now on is not kept"
        self._child = ChildProcess(__name__, str(folder), ended=ended)
        with contextlib.suppress(OSError):  # with a smaller pipe more is queued, nothing else changes
            fcntl.fcntl(self._child.stdin, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
        self._queued = bytearray()

    def save(self, name: str, content: bytes) -> None:
        """Queue `content` for writing to the file `name`, in place of what is there."""
        raw = name.encode()
        self._queued += _FRAME_HEADER.pack(len(raw), len(content)) + raw + content
        self.work()

    def work(self) -> None:
        """Pass on what fits into the pipe. Call it in every cycle."""
        if self._queued:
            try:
                del self._queued[: os.write(self._child.stdin, self._queued)]
            except BlockingIOError:
                pass
            except BrokenPipeError:  # `errors` tells it
                self._queued.clear()

    def errors(self) -> list[str]:
        """Return which files cannot be written since the last call, and which are again, one sentence each."""
        return self._child.said(_ERRORS_READ)

    def close(self) -> None:
        """Wait until everything is written. A second call does nothing."""
        if self._child.closed:
            return
        while self._queued and select.select([], [self._child.stdin], [], _CLOSE_S)[1]:
            self.work()
        self._child.close(_CLOSE_S, kill=True)

    def __enter__(self) -> StateStore:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _serve(folder: Path) -> None:
    """Run the child: write the newest content of each name received, until the pipe is closed."""
    os.nice(_NICENESS)
    received = bytearray()
    refused: dict[str, str] = {}
    ended = False
    while not ended:
        newest: dict[str, bytes] = {}
        while not newest or select.select([0], [], [], 0.0)[0]:
            part = os.read(0, _PIPE_BYTES)
            received += part
            newest |= _take_complete(received)
            if not part:
                ended = True
                break
        for name, content in newest.items():
            why = _written(folder / name, content)
            if why != refused.get(name, ""):  # navigation comes every few seconds: said once
                said = f"cannot be written ({why})" if why else "is written again"
                with contextlib.suppress(OSError):
                    os.write(1, f"{folder / name}: {said}\n".encode())
            refused[name] = why


def _written(path: Path, content: bytes) -> str:
    """Write a file, and return why it cannot be; "" where it was."""
    try:
        write_atomically(path, content)
    except OSError as error:
        return error.strerror or type(error).__name__
    return ""


def _take_complete(received: bytearray) -> dict[str, bytes]:
    """Remove the complete frames from `received` and return the newest content of each name."""
    complete: dict[str, bytes] = {}
    while len(received) >= _FRAME_HEADER.size:
        name_length, length = _FRAME_HEADER.unpack_from(received)
        begins = _FRAME_HEADER.size + name_length
        ends = begins + length
        if len(received) < ends:
            break
        complete[received[_FRAME_HEADER.size : begins].decode()] = bytes(received[begins:ends])
        del received[:ends]
    return complete


if __name__ == "__main__":
    _serve(Path(sys.argv[1]))
