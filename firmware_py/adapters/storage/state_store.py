"""What the vehicle keeps from one start to the next: bytes by name in a folder, each whole or not at all.

A disk may take many cycles until it says that it has written. So a child process writes, and the cycle only hands over
what fits into a pipe; the rest waits its turn. The child outlives a vehicle that is killed for as long as it takes to
write what it was handed.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import struct
import subprocess
import sys
from pathlib import Path
from types import TracebackType

_HEAD = struct.Struct("<HI")
"""Bytes of the name, bytes of the content; both follow."""
_PIPE_BYTES = 1 << 20
_CLOSE_S = 30.0
_GIVE_WAY = 10
"""Niceness of the child: the cycle goes first."""


class StateStoreError(Exception):
    """A folder that cannot be written or read; the text names it and what would be right."""


def write_atomically(folder: Path, name: str, content: bytes) -> None:
    """Writes a file so that there is always the old one or the new one, whatever ends the machine.

    Raises:
        OSError: it cannot be written; the old one stays.
    """
    fresh = folder / f"{name}.new"
    with fresh.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    fresh.replace(folder / name)
    entry = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(entry)
    finally:
        os.close(entry)


class StateStore:
    """The folder, made if it is not there, and the process that writes into it.

    Raises:
        StoreError: the folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StateStoreError(f"{folder}: cannot be made ({error.strerror}); choose another --state") from None
        if not os.access(folder, os.W_OK):
            raise StateStoreError(f"{folder}: cannot be written; choose another --state")
        self._child = subprocess.Popen(
            [sys.executable, "-I", __file__, str(folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C ends the flight, and only then this
        )
        assert self._child.stdin is not None
        assert self._child.stdout is not None
        self._to, self._from = self._child.stdin.fileno(), self._child.stdout.fileno()
        with contextlib.suppress(OSError):  # a smaller pipe makes it wait more often, no more
            fcntl.fcntl(self._to, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
        os.set_blocking(self._to, False)
        os.set_blocking(self._from, False)
        self._waiting = bytearray()

    def save(self, name: str, content: bytes) -> None:
        """Keeps `content` under a name, some time later, in place of what was kept under it before."""
        raw = name.encode()
        self._waiting += _HEAD.pack(len(raw), len(content)) + raw + content
        self.work()

    def work(self) -> None:
        """Hands over what the pipe has room for; to be called in every cycle."""
        if self._waiting:
            with contextlib.suppress(BlockingIOError, BrokenPipeError):
                del self._waiting[: os.write(self._to, self._waiting)]

    def complaints(self) -> list[str]:
        """What could not be written since this was asked last, a sentence each."""
        with contextlib.suppress(BlockingIOError):
            return os.read(self._from, 4096).decode(errors="replace").splitlines()
        return []

    def close(self) -> None:
        """Waits until all is written. A second call does nothing."""
        if self._child.stdin is None or self._child.stdin.closed:
            return
        os.set_blocking(self._to, True)
        with contextlib.suppress(BrokenPipeError):
            while self._waiting:
                self.work()
        self._child.stdin.close()
        try:
            self._child.wait(_CLOSE_S)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()
        if self._child.stdout is not None:
            self._child.stdout.close()

    def __enter__(self) -> StateStore:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _serve(folder: Path) -> None:
    """The child: of each name that has come it writes the newest, until nobody can send more."""
    os.nice(_GIVE_WAY)
    heard = bytearray()
    ended = False
    while not ended:
        newest: dict[str, bytes] = {}
        while not newest or select.select([0], [], [], 0.0)[0]:
            part = os.read(0, _PIPE_BYTES)
            heard += part
            newest |= _taken(heard)
            if not part:
                ended = True
                break
        for name, content in newest.items():
            try:
                write_atomically(folder, name, content)
            except OSError as error:
                with contextlib.suppress(OSError):
                    os.write(1, f"{folder / name}: cannot be written ({error.strerror})\n".encode())


def _taken(heard: bytearray) -> dict[str, bytes]:
    """Takes off what is whole."""
    whole: dict[str, bytes] = {}
    while len(heard) >= _HEAD.size:
        named, long = _HEAD.unpack_from(heard)
        begins, ends = _HEAD.size + named, _HEAD.size + named + long
        if len(heard) < ends:
            break
        whole[heard[_HEAD.size : begins].decode()] = bytes(heard[begins:ends])
        del heard[:ends]
    return whole


if __name__ == "__main__":
    _serve(Path(sys.argv[1]))
