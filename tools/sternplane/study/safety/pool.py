"""Flies the jobs of a campaign on all cores, with a bar, and keeps each flight as soon as it is over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console

from sternplane.campaign.engine import complete
from sternplane.study.safety.campaign import Job
from sternplane.study.safety.flight import run
from sternplane.study.safety.store import Store
from sternplane.study.safety.verdict import is_unsafe


def fly_all(jobs: Sequence[Job], store: Store, revision: str, console: Console, settings: tuple[str, ...] = ()) -> None:
    """Fly every job that the store does not have; where the console is no terminal, a line says each twentieth."""
    missing = store.missing(jobs)

    def keep(_: Job, flight: dict[str, Any]) -> None:
        store.add(flight)
        if is_unsafe(flight):
            console.print(f"{flight['ending']}: {flight['key']}: {flight['outcome']}", highlight=False, soft_wrap=True)

    def arguments(job: Job) -> tuple[Job, str, str, tuple[str, ...]]:
        return job, str(store.logs), revision, settings

    done = len(jobs) - len(missing)
    complete(run, missing, arguments, keep, "flights", console, parts=20, done=done, place=store.path)
