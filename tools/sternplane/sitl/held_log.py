"""The log of a simulated flight, held open: where its file is removed in flight, what is written is still read."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import TracebackType

from firmware_py.adapters.storage.recorder import LogError
from firmware_py.records.cycle import Cycle
from firmware_py.tick import Rate


class HeldLog:
    """Creates the log, empty; of two runs that began in the same moment only one can.

    Attributes:
        removed: whether the file was found to be gone; it is told once, as it is found.

    Raises:
        LogError: another run has created it, or the folder cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.removed = False
        try:
            self._descriptor = os.open(path, os.O_RDONLY | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            raise LogError(f"{path}: another flight has begun to write it; choose another --out") from None
        except OSError as error:
            raise LogError(f"{path}: cannot be written ({error.strerror}); choose another --out") from None

    def update(self, cycle: Cycle) -> None:
        """Look once a second whether the file is still there."""
        if cycle.tick.every(Rate.HZ_1):
            self._look()

    @property
    def readable(self) -> Path:
        """Return where the log can be read as long as it is held: its own place, or that of the kernel."""
        self._look()
        return Path(f"/proc/self/fd/{self._descriptor}") if self.removed else self._path

    def __enter__(self) -> HeldLog:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._descriptor)

    def _look(self) -> None:
        if self.removed:
            return
        try:
            self.removed = not os.path.samestat(os.stat(self._path), os.fstat(self._descriptor))
        except OSError:
            self.removed = True
        if self.removed:
            why = "was removed, and will be lost; the flight goes on, and its summary comes at its end"
            print(f"sternplane: {self._path}: {why}", file=sys.stderr)
