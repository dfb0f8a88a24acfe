"""Worker processes with a progress bar."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import multiprocessing.util
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import (
    Progress,
    ProgressColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

Result = TypeVar("Result")
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
_LAST = -1000
"""The priority of what is done last; multiprocessing itself joins its queues with -5."""


def end_with_parent(parent: int) -> None:
    """Ask Linux to kill this process when the one that started it is killed: it would else wait for work forever.

    A flight takes a milder signal for its own end, and the process would go on to the next. Of a parent that is dead
    already Linux tells nothing.

    Args:
        parent: the process that started this one.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def end_with_work() -> None:
    """Let this process end with its work: threads that somebody's code has started would be waited for.

    What multiprocessing itself does at the end comes before.
    """
    multiprocessing.util.Finalize(None, _end, exitpriority=_LAST)


def _end() -> None:
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    os._exit(0)


def _begin(parent: int) -> None:
    end_with_parent(parent)
    end_with_work()


@contextlib.contextmanager
def _interrupt_held() -> Iterator[None]:
    """Let an interrupt wait for the end of the block: only the main thread gets any."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: held.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if held:
            signal.raise_signal(signal.SIGINT)


@contextlib.contextmanager
def terminated_like_interrupted() -> Iterator[None]:
    """Let SIGTERM do what Ctrl-C does, and end what was started: who just died would leave processes and semaphores."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


class _Workers(ProcessPoolExecutor):
    """Starts no process that nobody knows: an interrupt between its start and its entry would leave it to work on."""

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        with _interrupt_held():
            return super().submit(fn, *args, **kwargs)


@contextlib.contextmanager
def pool_of(processes: int) -> Iterator[ProcessPoolExecutor]:
    """Start worker processes; on an exception, Ctrl-C and SIGTERM among them, they are ended at once."""
    others = multiprocessing.active_children()
    context = multiprocessing.get_context("spawn")
    with (
        terminated_like_interrupted(),
        _Workers(processes, mp_context=context, initializer=_begin, initargs=(os.getpid(),)) as pool,
    ):
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in multiprocessing.active_children():
                if process not in others:
                    process.kill()  # what is begun would else be worked on to its end
            raise


def progress_bar(console: Console, *columns: ProgressColumn, transient: bool = False) -> Progress:
    """Return a bar with the time that has passed and that is left, which is drawn if the console is a terminal."""
    times = (TimeElapsedColumn(), TimeRemainingColumn())
    return Progress(*columns, *times, console=console, transient=transient, disable=not console.is_terminal)


@contextlib.contextmanager
def workers(
    processes: int, console: Console, *columns: ProgressColumn
) -> Iterator[tuple[Progress, ProcessPoolExecutor]]:
    """Start a progress bar and worker processes, as `progress_bar` and `pool_of`."""
    with progress_bar(console, *columns) as bar, pool_of(processes) as pool:
        yield bar, pool
