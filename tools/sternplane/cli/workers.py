"""Worker processes with a progress bar."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor

from rich.console import Console
from rich.progress import Progress, ProgressColumn, TimeElapsedColumn, TimeRemainingColumn

_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>


def end_with_parent() -> None:
    """Ask Linux to kill this process when the one that started it is killed: it would else wait for work forever.

    A flight takes a milder signal for its own end, and the process would go on to the next.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


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
        ProcessPoolExecutor(
            processes, mp_context=multiprocessing.get_context("spawn"), initializer=end_with_parent
        ) as pool,
    ):
        try:
            yield bar, pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in multiprocessing.active_children():
                if process not in others:
                    process.kill()  # what is begun would else be worked on to its end
            raise
