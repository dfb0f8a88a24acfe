"""What a run leaves in its folder, undone if the flight is refused before its first cycle."""

from __future__ import annotations

import contextlib
from pathlib import Path
from types import TracebackType


class RunTraces:
    """Undoes them as its context ends with an error, if `flown` is False then.

    Only what was made after `follow` goes, and only once `claimed`: until then another run may be writing there.

    Attributes:
        claimed: whether the folder's log is this run's.
        flown: whether a cycle was flown.
    """

    def __init__(self) -> None:
        self.claimed = self.flown = False
        self._folder: Path | None = None
        self._made = False
        self._before: set[Path] = set()

    def follow(self, folder: Path, *, made: bool) -> None:
        """Follow what comes into a folder from now on; `made`: the folder is this run's too."""
        self._folder, self._made, self._before = folder, made, set(folder.rglob("*"))

    def __enter__(self) -> RunTraces:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None or self.flown or self._folder is None:
            return
        with contextlib.suppress(OSError):
            if self.claimed:
                self._undo(self._folder)
            if self._made:
                self._folder.rmdir()

    def _undo(self, folder: Path) -> None:
        for path in sorted(set(folder.rglob("*")) - self._before, reverse=True):  # what is in a folder before it
            if path.is_dir() and not path.is_symlink():
                path.rmdir()
            else:
                path.unlink()
