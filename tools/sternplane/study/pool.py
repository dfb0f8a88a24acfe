"""Makes all runs of a study on all cores, with a bar, and keeps each. No result depends on which process was faster."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console

from sternplane.campaign.engine import complete
from sternplane.study.kept_runs import KeptRuns
from sternplane.study.laid_settings import run_laid
from sternplane.study.rows import Case, RunArrays


def run_all(
    cases: Sequence[Case],
    seeds: range,
    short: bool,
    kept: KeptRuns,
    console: Console,
    settings: Sequence[str] = (),
) -> list[list[RunArrays]]:
    """Return every run of every case, in their order; what was kept is not made again.

    They are made seed by seed, so that a study that was broken off has all cases.

    Args:
        cases: of the study.
        seeds: the k-th run takes the k-th; a case makes no more runs than there are seeds, unless its runs are all
            different, as those with several starts: these always make all.
        short: the form for CI.
        kept: the runs of this study that were made before, and where new ones go.
        console: where the bar is drawn; where it is no terminal, a line says each tenth.
        settings: what `--set` lays upon the files of every run.
    """
    counts = [
        case.runs if case.runs == case.short else min(case.short if short else case.runs, len(seeds)) for case in cases
    ]
    wanted = [(index, k) for k in range(max(counts, default=0)) for index, count in enumerate(counts) if k < count]
    runs: dict[tuple[int, int], RunArrays] = {}
    for index, k in wanted:
        if (run := kept.found(cases[index], seeds.start + k, k)) is not None:
            runs[index, k] = run
    missing = [job for job in wanted if job not in runs]

    def keep(job: tuple[int, int], run: RunArrays) -> None:
        index, k = job
        kept.keep(cases[index], seeds.start + k, k, run)
        runs[job] = run

    def arguments(job: tuple[int, int]) -> tuple[Any, ...]:
        index, k = job
        return settings, cases[index].run, seeds.start + k, k

    complete(run_laid, missing, arguments, keep, "runs", console, done=len(runs), place=kept.folder)
    return [[runs[index, k] for k in range(count)] for index, count in enumerate(counts)]
