"""Runs all cases in two processes, with a bar. What comes out does not hang on which process was faster."""

from __future__ import annotations

from concurrent.futures import as_completed

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

from sternplane.cli.workers import workers
from sternplane.study.cases import CASES
from sternplane.study.rows import RunArrays

PROCESSES = 2


def run_case(index: int, seed: int, k: int) -> RunArrays:
    """The k-th run of a case; called in another process."""
    return CASES[index].run(seed, k)


def run_all(seeds: range, short: bool, console: Console) -> list[list[RunArrays]]:
    """Every run of every case, in their order.

    Args:
        seeds: the k-th run takes the k-th; a case makes no more runs than there are seeds, unless its runs are all
            different, as those with several starts: these always make all.
        short: the form for CI.
        console: where the bar is drawn; where it is no terminal, a line says each tenth.
    """
    jobs = [
        (index, seeds.start + k, k)
        for index, case in enumerate(CASES)
        for k in range(case.runs if case.runs == case.short else min(case.short if short else case.runs, len(seeds)))
    ]
    found: dict[tuple[int, int], RunArrays] = {}
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with workers(PROCESSES, console, *columns, transient=True) as (bar, pool):
        task = bar.add_task("study", total=len(jobs))
        waiting = {pool.submit(run_case, *job): job for job in jobs}
        for tenth, future in enumerate(as_completed(waiting), 1):
            index, _, k = waiting[future]
            found[index, k] = future.result()
            bar.update(task, advance=1, description=CASES[index].name)
            if not console.is_terminal and 10 * tenth // len(jobs) > 10 * (tenth - 1) // len(jobs):
                console.print(f"{tenth} of {len(jobs)} runs", highlight=False)
    return [[found[i, k] for j, _, k in jobs if j == i] for i in range(len(CASES))]
