"""Flies the jobs of a campaign on all cores, with a bar, and keeps each flight as soon as it is over."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import as_completed

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

from sternplane.cli.workers import workers
from sternplane.study.safety.campaign import Job
from sternplane.study.safety.flight import run
from sternplane.study.safety.judge import Ending
from sternplane.study.safety.store import Store


def fly_all(jobs: Sequence[Job], store: Store, revision: str, console: Console) -> None:
    """Fly every job that the store does not have; where the console is no terminal, a line says each twentieth."""
    missing = store.missing(jobs)
    if len(missing) < len(jobs):
        console.print(f"{len(jobs) - len(missing)} of {len(jobs)} flights are in {store.path} already", soft_wrap=True)
    if not missing:
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    processes = min(len(os.sched_getaffinity(0)), len(missing))
    with workers(processes, console, *columns, transient=True) as (bar, pool):
        task = bar.add_task("flights", total=len(missing))
        waiting = {pool.submit(run, job, str(store.logs), revision): job for job in missing}
        for done, future in enumerate(as_completed(waiting), 1):
            flight = future.result()
            store.add(flight)
            bar.update(task, advance=1)
            if Ending(flight["ending"]).unsafe:
                console.print(
                    f"{flight['ending']}: {flight['key']}: {flight['outcome']}", highlight=False, soft_wrap=True
                )
            if not console.is_terminal and 20 * done // len(missing) > 20 * (done - 1) // len(missing):
                console.print(f"{done} of {len(missing)} flights", highlight=False)
