"""A flight's log in parts: each is a log of its own, which begins with what the autopilot remembers then.

So a part is replayed without those before it, which may have been removed, and a log that could not be written for a
while goes on with the next part. No cycle is lost between two parts.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.storage import memory_pickle
from firmware_py.adapters.storage.log_keeper import LogKeeper
from firmware_py.adapters.storage.log_names import part_file
from firmware_py.adapters.storage.log_params import LogParams
from firmware_py.adapters.storage.recorder import MEMORY, Codecs, LogError, LogRecorder, LogWriter
from firmware_py.adapters.storage.regular_file import FolderError, make_folder
from firmware_py.records.cycle import Cycle
from firmware_py.tick import NS_PER_S

_APART = 20
"""Cycles between the steps of a turn, so that one that was late has caught up."""


class PartedLog:
    """Writes it.

    Args:
        folder: of the flight; no log in it is overwritten.
        header: of every part, without what tells them apart.
        params: how long parts become.
        freeze: returns what the autopilot remembers after the cycle that was written last.
        keeper: is told which part is written.
        losses: what is lost, for the log.

    Attributes:
        path: of the part that is written.

    Raises:
        LogError: here and in `write` and `begin_next`: it cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        header: Mapping[str, Any],
        params: LogParams,
        freeze: Callable[[], Any],
        keeper: LogKeeper,
        losses: LossWatch | None = None,
    ) -> None:
        self._folder, self._header, self._freeze = folder, header, freeze
        self._keeper, self._losses = keeper, losses
        self._length_ns, self._size = round(params.part_time * NS_PER_S), params.part_size
        self._codecs: Codecs = {}
        self._part = self._begun = 0
        self._ends_ns = self._length_ns
        self._turning: Iterator[None] = iter(())
        self._standby: LogWriter | None = None
        self.path = folder / part_file(1)

    def begin(self) -> None:
        """Begin the first part, before the first cycle."""
        self._take(self._created({}))
        with contextlib.suppress(ValueError):
            memory_pickle.encode(self._freeze())  # what the first time imports takes ten cycles

    def write(self, cycle: Cycle) -> None:
        """Write one cycle, and do a step of the turn to the next part when it is time to."""
        self._recorder.write(cycle)
        self._t_ns = cycle.tick.t_ns
        if self._t_ns >= self._ends_ns or self._writer.size - self._begun >= self._size:
            self._ends_ns, self._begun = self._t_ns + self._length_ns, self._writer.size
            self._turning = self._turn(cycle.tick.k)
        next(self._turning, None)

    def begin_next(self, cycle: Cycle) -> None:
        """Begin the next part at once, with the cycle after this one: the part before cannot be written."""
        self._forget()
        self._t_ns = cycle.tick.t_ns
        self._ends_ns = self._t_ns + self._length_ns
        writer = self._created({"after_tick": cycle.tick.k})
        self._remember(writer)
        self._take(writer)

    def close(self, end: Mapping[str, Any]) -> None:
        """Write how the flight ended."""
        if self._standby is None:
            for _ in self._turning:
                pass
        self._forget()
        self._writer.close(end)

    def _turn(self, k: int) -> Iterator[None]:
        """Make the next part after cycle k, go over to it, and close the one before, in steps that a cycle can bear."""
        before = self._writer
        self._standby = self._created({"after_tick": k + _APART})
        for _ in range(_APART):
            yield
        next_part, self._standby = self._standby, None
        self._remember(next_part)
        self._take(next_part)
        for _ in range(_APART):
            yield
        yield from before.closing({"completed": None, "reason": f"goes on in {next_part.path.name}"})

    def _created(self, more: Mapping[str, Any]) -> LogWriter:
        path = self._folder / part_file(self._part + 1)
        there = os.path.lexists(path)
        try:
            make_folder(self._folder)
            header = {**self._header, "part": self._part + 1, **more}
            return LogWriter(path, header, exclusive=True, codecs=self._codecs)
        except FolderError as error:
            raise LogError(f"{error}; choose another folder") from None
        except LogError:
            if not there:  # a full disk takes the name, and not the content
                _remove(path)
            raise

    def _remember(self, writer: LogWriter) -> None:
        with contextlib.suppress(ValueError):  # a log that cannot be replayed is better than none
            writer.attach(MEMORY, self._t_ns, memory_pickle.encode(self._freeze()))

    def _take(self, writer: LogWriter) -> None:
        self._writer, self.path, self._begun = writer, writer.path, writer.size
        self._part += 1
        self._recorder = LogRecorder(writer, self._losses)
        self._keeper.written(writer.path)

    def _forget(self) -> None:
        """Remove a part that no cycle was written to."""
        self._turning = iter(())
        if self._standby is not None:
            with contextlib.suppress(LogError):
                self._standby.close()
            _remove(self._standby.path)
            self._standby = None


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):  # of a read-only file system even a name that is not there
        path.unlink()
