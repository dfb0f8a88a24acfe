"""A crew of a campaign that works in the test's own process: what comes of a job does not hang on where it is done."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from typing import Any


class Here:
    """In place of a `LocalCrew`; does the last job first."""

    def __init__(self, size: int = 1) -> None:
        self.size = size

    def results(
        self, work: Callable[..., Any], jobs: Iterable[tuple[Any, tuple[Any, ...]]]
    ) -> Generator[tuple[Any, Any]]:
        yield from [(job, work(*arguments)) for job, arguments in reversed(list(jobs))]
