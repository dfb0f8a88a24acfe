"""What was done of a campaign, in a file of lines: one JSON object for each job, written when the job is done."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from firmware_py.run.usage_error import UsageError

Row = dict[str, Any]


class LineStore:
    """A file of rows, each with a "key" of its own: added one at a time, never changed.

    A kill at any time loses at most the line that was being written, and its job is done again. Rows are read from the
    file when they are asked for: what is kept in memory are their keys.

    Args:
        path: of the file; it is made if there is none.

    Attributes:
        keys: of the rows that are there.

    Raises:
        UsageError: the file cannot be read or written, or another process is writing it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.keys: set[str] = set()
        try:
            self._file = path.open("r+b" if path.exists() else "w+b")
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # given up when the process ends, however it does
        except BlockingIOError:
            raise UsageError(
                f"{path}: another process is writing it; wait for its end, or choose another --out"
            ) from None
        except OSError as error:
            raise UsageError(f"{path}: cannot be written ({error.strerror}); choose another --out") from None
        end = 0
        for line in self._file:
            if not line.endswith(b"\n"):
                break
            try:
                self.keys.add(json.loads(line)["key"])
            except (ValueError, KeyError, TypeError, RecursionError):
                raise UsageError(f"{path}: a line of it is no row ({line[:40]!r}); choose another --out") from None
            end += len(line)
        self._file.seek(end)
        self._file.truncate()  # a line that a killed process had begun

    def add(self, row: Row) -> None:
        """Keep a row, to the disk; one whose key is there already is the same again, and left out.

        Raises:
            UsageError: it cannot be written.
        """
        if row["key"] in self.keys:
            return
        try:
            self._file.write(json.dumps(row, allow_nan=False).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise UsageError(f"{self.path}: cannot be written ({error.strerror}); start it again to go on") from None
        self.keys.add(row["key"])

    def rows(self) -> Iterator[Row]:
        """Yield every row, in the order in which they were added."""
        with self.path.open("rb") as file:
            for line in file:
                yield json.loads(line)

    def of(self, keys: Iterable[str]) -> list[Row]:
        """Return the rows with these keys, in the order of the keys; one that is not there is left out."""
        wanted = dict.fromkeys(keys)
        found = {row["key"]: row for row in self.rows() if row["key"] in wanted}
        return [found[key] for key in wanted if key in found]

    def close(self) -> None:
        """Close the file; what `add` could not write is lost, and was told."""
        with contextlib.suppress(OSError):
            self._file.close()
