"""The files that stations may fetch: files generated on request, and the logs on disk.

A disk may take longer than a cycle, so a `LogStorage` without the data at hand returns None and is asked again in the
next tick.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol

LOGS = "logs"
"""The folder of the logs."""


class LogFile(NamedTuple):
    """A log: name without a slash, size in bytes, time of the last write (s since 1970), whether it still grows."""

    name: str
    size: int
    written: int
    growing: bool


class LogStorage(Protocol):
    """The logs on a disk."""

    def logs(self) -> Sequence[LogFile] | None:
        """Return all logs, the oldest first; None if not known yet: ask again.

        Raises:
            OSError: they cannot be listed.
        """

    def read(self, name: str, offset: int, n: int) -> bytes | None:
        """Return at most `n` bytes, fewer only at the end; None if not read yet: ask again.

        Raises:
            OSError: they cannot be read.
        """

    def erase(self) -> bool:
        """Remove all logs that are no longer written; return whether that is done: if not, ask again.

        Raises:
            OSError: they cannot be removed.
        """


class Entry(NamedTuple):
    """An entry of a folder's listing; a folder has no size."""

    name: str
    size: int | None


class File(Protocol):
    """An open file."""

    size: int

    def read(self, offset: int, n: int) -> bytes | None:
        """As `LogStorage.read`."""


class MemoryFile:
    """A generated file; its content does not change while it is open."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self.size = len(content)

    def read(self, offset: int, n: int) -> bytes | None:
        """See `LogStorage.read`."""
        return self._content[offset : offset + n]


class LogSnapshot:
    """A log up to its size when it was opened; a growing log might never end on a slow link."""

    def __init__(self, log_storage: LogStorage, log: LogFile) -> None:
        self._log_storage, self._name = log_storage, log.name
        self.size = log.size

    def read(self, offset: int, n: int) -> bytes | None:
        """See `LogStorage.read`."""
        n = min(n, self.size - offset)
        return self._log_storage.read(self._name, offset, n) if n > 0 else b""


class Wait(Exception):
    """The data is not here yet; ask again in the next tick."""


class FileTree:
    """Generated files and logs as one tree; a leading slash is ignored."""

    def __init__(self, generated: Mapping[str, Callable[[], bytes]], log_storage: LogStorage | None = None) -> None:
        """`generated` has who makes which file; what is behind a "?" in a name is how to ask for it, and not listed."""
        self._generated = generated
        self.log_storage = log_storage
        """The storage of the logs, once it is known."""

    def list(self, path: str) -> list[Entry] | None:
        """Return the entries of a folder by name; None if there is no such folder.

        Raises:
            Wait: not known yet.
            OSError: it cannot be listed.
        """
        folder = path.strip("/.")
        if folder == LOGS and self.log_storage is not None:
            return [Entry(log.name, log.size) for log in self.logs()]
        begin = f"{folder}/" if folder else ""
        found: dict[str, Entry] = {}
        for name, make in self._generated.items():
            if name.startswith(begin) and "?" not in name:
                first, _, rest = name[len(begin) :].partition("/")
                found[first] = Entry(first, None if rest else len(make()))
        if not folder and self.log_storage is not None:
            found[LOGS] = Entry(LOGS, None)
        return [found[name] for name in sorted(found)] if found or not folder else None

    def open(self, path: str) -> File | None:
        """Open a file; None if there is no such file.

        Raises:
            Wait: not known yet.
            OSError: it cannot be read.
        """
        name = path.lstrip("/")
        if name in self._generated:
            return MemoryFile(self._generated[name]())
        folder, _, rest = name.partition("/")
        if folder != LOGS or self.log_storage is None:
            return None
        return next((LogSnapshot(self.log_storage, log) for log in self.logs() if log.name == rest), None)

    def logs(self) -> Sequence[LogFile]:
        """Return the logs, the oldest first.

        Raises:
            Wait: not known yet.
            OSError: they cannot be listed.
        """
        logs = self.log_storage.logs() if self.log_storage is not None else ()
        if logs is None:
            raise Wait
        return logs
