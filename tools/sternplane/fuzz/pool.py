"""Flies all flights in a few processes, with a bar. What is found does not hang on which process was faster."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait

from rich.console import Console
from rich.progress import BarColumn, TextColumn

from sternplane.campaign.workers import workers
from sternplane.fuzz.flight import PACKETS, FuzzResult, Job, flown

MOST_FAILURES = 20
"""After so many the rest is not flown."""


def jobs(seed: int, packets: int) -> Iterator[Job]:
    """Yield the flights that take so many packets; all but the last take as many each."""
    for flight, first in enumerate(range(0, packets, PACKETS)):
        yield Job(seed, flight, min(PACKETS, packets - first))


def run_all(seed: int, packets: int, seconds: float | None, processes: int, console: Console) -> list[FuzzResult]:
    """Fly every flight; return the results in their order.

    Args:
        seed: of all that is random.
        packets: how many, over all flights.
        seconds: after which no further flight is begun; None for no limit.
        processes: that fly at once.
        console: where the bar is drawn; where it is no terminal, a line says each tenth.
    """
    waiting: dict[Future[FuzzResult], Job] = {}
    found: dict[int, FuzzResult] = {}
    todo = jobs(seed, packets)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed:,} of {task.total:,}"))
    with workers(processes, console, *columns) as (bar, pool):
        task, done, tenth, began = bar.add_task("packets", total=packets), 0, 0, time.monotonic()
        while True:
            over = seconds is not None and time.monotonic() - began >= seconds
            failed = sum(one.failure is not None for one in found.values())
            while not over and failed < MOST_FAILURES and len(waiting) < processes:
                job = next(todo, None)
                if job is None:
                    break
                waiting[pool.submit(flown, job)] = job
            if not waiting:
                break
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                job = waiting.pop(future)
                found[job.flight] = future.result()
                done += job.packets
            bar.update(task, completed=done, description="packets" if not failed else f"packets, {failed} failures")
            if not console.is_terminal and 10 * done // packets > tenth:
                tenth = 10 * done // packets
                console.print(f"{done:,} of {packets:,} packets, {failed} failures", highlight=False)
    return [found[flight] for flight in sorted(found)]
