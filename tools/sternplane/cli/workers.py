"""Worker processes with a progress bar."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

Job = TypeVar("Job")
Result = TypeVar("Result")
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>


def end_with_parent() -> None:
    """Ask Linux to kill this process when the one that started it is killed: it would else wait for work forever.

    A flight takes a milder signal for its own end, and the process would go on to the next.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


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


class _Workers(ProcessPoolExecutor):
    """Starts no process that nobody knows: an interrupt between its start and its entry would leave it to work on."""

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        with _interrupt_held():
            return super().submit(fn, *args, **kwargs)


@contextlib.contextmanager
def workers(
    processes: int, console: Console, *columns: ProgressColumn, transient: bool = False
) -> Iterator[tuple[Progress, ProcessPoolExecutor]]:
    """Start a progress bar and worker processes; on an exception, Ctrl-C among them, they are ended at once.

    Args:
        processes: how many.
        console: where the bar is drawn, if it is a terminal.
        columns: of the bar, before the times.
        transient: the bar is gone in the end.
    """
    times = (TimeElapsedColumn(), TimeRemainingColumn())
    others = multiprocessing.active_children()
    with (
        Progress(*columns, *times, console=console, transient=transient, disable=not console.is_terminal) as bar,
        _Workers(processes, mp_context=multiprocessing.get_context("spawn"), initializer=end_with_parent) as pool,
    ):
        try:
            yield bar, pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in multiprocessing.active_children():
                if process not in others:
                    process.kill()  # what is begun would else be worked on to its end
            raise


def complete(
    work: Callable[..., Result],
    jobs: Mapping[Job, tuple[Any, ...]],
    take: Callable[[Job, Result], None],
    what: str,
    parts: int,
    console: Console,
) -> None:
    """Do all jobs on all cores.

    Args:
        work: a function of a module.
        jobs: the arguments of each.
        take: gets each job and what came of it, in the order in which they come to an end.
        what: the jobs are, for the bar.
        parts: where the console is no terminal, a line says each of so many parts.
        console: where the bar is drawn.
    """
    columns, processes = (TextColumn(what), BarColumn(), MofNCompleteColumn()), len(os.sched_getaffinity(0))
    with workers(min(processes, len(jobs)), console, *columns, transient=True) as (bar, pool):
        task = bar.add_task(what, total=len(jobs))
        waiting = {pool.submit(work, *arguments): job for job, arguments in jobs.items()}
        for done, future in enumerate(as_completed(waiting), 1):
            take(waiting[future], future.result())
            bar.update(task, advance=1)
            if not console.is_terminal and parts * done // len(jobs) > parts * (done - 1) // len(jobs):
                console.print(f"{done} of {len(jobs)} {what}", highlight=False)
