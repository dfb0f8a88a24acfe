"""Runs all cases on all cores, with a bar. What comes out does not hang on which process was faster."""

from __future__ import annotations

import operator
from collections.abc import Sequence

from rich.console import Console

from sternplane.cli.workers import complete
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
    jobs = {
        (index, k): (case.run, seeds.start + k, k)
        for index, case in enumerate(cases)
        for k in range(case.runs if case.runs == case.short else min(case.short if short else case.runs, len(seeds)))
    }
    found: dict[tuple[int, int], RunArrays] = {}
    complete(operator.call, jobs, found.__setitem__, "runs", 10, console)
    return [[found[job] for job in jobs if job[0] == index] for index in range(len(cases))]
