"""Who does the jobs of a campaign: processes of this computer. One that dies costs no job."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from typing import Any, NamedTuple, Protocol, TypeVar

from sternplane.campaign.workers import pool_of

Job = TypeVar("Job")
Result = TypeVar("Result")
_AHEAD = 2
"""Jobs that are handed out for each worker: it has the next one when it is done with one, and memory stays flat."""
_TRIES = 2
"""So often a job may end the process that does it alone."""


class Died(Exception):
    """A job that ended every process that began it."""


class Crew(Protocol):
    """Does jobs, each once, in any order."""

    @property
    def size(self) -> int:
        """Return how many jobs are done at once."""

    def results(
        self, work: Callable[..., Result], jobs: Iterable[tuple[Job, tuple[Any, ...]]]
    ) -> Generator[tuple[Job, Result | Died]]:
        """Yield each job with what came of it, as they come to an end.

        Args:
            work: a function of a module; an exception of it ends all.
            jobs: each with the arguments of `work`; they are taken when there is room for them.
        """


def processors() -> int:
    """Return on how many processors this process may run."""
    return len(os.sched_getaffinity(0))


class _Handed(NamedTuple):
    job: Any
    arguments: tuple[Any, ...]
    tries: int = 0


class LocalCrew:
    """Worker processes of this computer.

    If one dies, say for want of memory, the others end with it; all that was begun is begun again, one job at a time:
    so the one whose fault it is is known.

    Args:
        size: how many; None is one for each processor.
    """

    def __init__(self, size: int | None = None) -> None:
        self.size = size or processors()

    def results(
        self, work: Callable[..., Result], jobs: Iterable[tuple[Job, tuple[Any, ...]]]
    ) -> Generator[tuple[Job, Result | Died]]:
        """See `Crew`."""
        waiting, suspects = (_Handed(*one) for one in jobs), deque[_Handed]()
        while True:
            broken: list[_Handed] = []
            yield from self._while_whole(work, waiting, suspects, broken)
            if not (broken or suspects):
                return
            if len(broken) == 1:
                [one] = broken
                broken = [one._replace(tries=one.tries + 1)]
                if broken[0].tries >= _TRIES:
                    yield one.job, Died(f"every process that began it died ({_TRIES} of them)")
                    continue
            suspects.extendleft(reversed(broken))

    def _while_whole(
        self, work: Callable[..., Result], waiting: Iterator[_Handed], suspects: deque[_Handed], broken: list[_Handed]
    ) -> Generator[tuple[Any, Result]]:
        """Yield results until all is done, or a process has died: what was begun then stands in `broken`.

        What was to be begun just then is among the `suspects` again.
        """
        begun: dict[Future[Result], _Handed] = {}
        with pool_of(self.size) as pool:
            while True:
                ready: Iterable[_Handed] = ()
                if not suspects:
                    ready = islice(waiting, _AHEAD * self.size - len(begun))
                elif not begun:
                    ready = (suspects.popleft(),)
                for one in ready:
                    try:
                        begun[pool.submit(work, *one.arguments)] = one
                    except BrokenProcessPool:  # a process has died since the last result
                        suspects.appendleft(one)
                        break
                if not begun:
                    return
                done = wait(begun, return_when=FIRST_COMPLETED).done
                for future in [one for one in begun if one in done]:  # in the order in which they were begun
                    one = begun.pop(future)
                    try:
                        result = future.result()
                    except BrokenProcessPool:
                        broken.append(one)
                    else:
                        yield one.job, result
                if broken:
                    broken.extend(begun.values())
                    return
