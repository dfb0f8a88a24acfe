"""Does the jobs of a campaign that are not done yet, with a bar, and keeps each as soon as it is done."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

from sternplane.campaign.crew import Crew, Died, LocalCrew
from sternplane.campaign.workers import progress_bar

Job = TypeVar("Job")
Result = TypeVar("Result")


class JobDied(RuntimeError):
    """A job that ended every process that began it, of a campaign that cannot do without."""


def complete(
    work: Callable[..., Result],
    jobs: Sequence[Job] | Mapping[Job, Any],
    arguments: Callable[[Job], tuple[Any, ...]],
    take: Callable[[Job, Result], None],
    what: str,
    console: Console,
    *,
    parts: int = 10,
    done: int = 0,
    place: object = "",
    crew: Crew | None = None,
    died: Callable[[Job, Died], None] | None = None,
) -> None:
    """Do all jobs.

    The time that is left is told from each worker's second job on: with its first it has started, and perhaps compiled.

    Args:
        work: a function of a module.
        jobs: those that are not done yet.
        arguments: of `work`, for a job; asked for when its turn comes.
        take: gets each job and what came of it, in the order in which they come to an end.
        what: the jobs are, for the bar.
        console: where the bar is drawn.
        parts: where the console is no terminal, a line says each of so many parts.
        done: how many other jobs of the campaign were done before, and
        place: where these are, for a line that says so.
        crew: does them; None are processes of this computer, one for each processor.
        died: gets a job that no process survives; without it that is an error.
    """
    total = done + len(jobs)
    if done:
        console.print(f"{done} of {total} {what} are in {place} already", highlight=False, soft_wrap=True)
    if not jobs:
        return
    crew = crew or LocalCrew(min(LocalCrew().size, len(jobs)))
    columns, began, first = (TextColumn(what), BarColumn(), MofNCompleteColumn()), 0.0, crew.size
    todo = ((job, arguments(job)) for job in jobs)
    with (
        progress_bar(console, *columns, transient=True) as bar,
        contextlib.closing(crew.results(work, todo)) as found,
    ):
        task = bar.add_task(what, total=total, completed=done)
        for count, (job, result) in enumerate(found, 1):
            if not isinstance(result, Died):
                take(job, result)
            elif died is not None:
                died(job, result)
            else:
                raise JobDied(f"{job}: {result}")
            bar.update(task, advance=1)
            if count <= first:
                began = time.monotonic()
            if not console.is_terminal and parts * count // len(jobs) > parts * (count - 1) // len(jobs):
                each = (time.monotonic() - began) / (count - first) if count >= 2 * first else 0.0
                console.print(f"{done + count} of {total} {what}{_left(each * (len(jobs) - count))}", highlight=False)


def _left(seconds: float) -> str:
    """Return how long it still takes, to a precision that it may have."""
    if seconds < 1.0:
        return ""
    minutes, hours = round(seconds / 60.0), seconds / 3600.0
    return (
        f", about {f'{seconds:.0f} s' if minutes < 2 else f'{minutes} min' if minutes < 120 else f'{hours:.1f} h'} left"
    )
