"""Runs all cases on all cores, with a bar. What comes out does not hang on which process was faster."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import as_completed

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

from sternplane.cli.workers import workers
from sternplane.study.rows import Case, RunArrays


def run_all(cases: Sequence[Case], seeds: range, short: bool, console: Console) -> list[list[RunArrays]]:
    """Every run of every case, in their order.

    Args:
        cases: of the study.
        seeds: the k-th run takes the k-th; a case makes no more runs than there are seeds, unless its runs are all
            different, as those with several starts: these always make all.
        short: the form for CI.
        console: where the bar is drawn; where it is no terminal, a line says each tenth.
    """
    jobs = [
        (index, seeds.start + k, k)
        for index, case in enumerate(cases)
        for k in range(case.runs if case.runs == case.short else min(case.short if short else case.runs, len(seeds)))
    ]
    found: dict[tuple[int, int], RunArrays] = {}
    processes = min(len(os.sched_getaffinity(0)), len(jobs))
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with workers(processes, console, *columns, transient=True) as (bar, pool):
        task = bar.add_task("study", total=len(jobs))
        waiting = {pool.submit(cases[index].run, seed, k): (index, seed, k) for index, seed, k in jobs}
        for tenth, future in enumerate(as_completed(waiting), 1):
            index, _, k = waiting[future]
            found[index, k] = future.result()
            bar.update(task, advance=1, description=cases[index].name)
            if not console.is_terminal and 10 * tenth // len(jobs) > 10 * (tenth - 1) // len(jobs):
                console.print(f"{tenth} of {len(jobs)} runs", highlight=False)
    return [[found[i, k] for j, _, k in jobs if j == i] for i in range(len(cases))]
