"""Which workers of a Dask cluster can do our jobs: those with the sternplane that is here."""

from __future__ import annotations

from typing import Any, NamedTuple

from rich.console import Console

from firmware_py.error_text import one_line, shortened
from firmware_py.foreign_text import visible
from firmware_py.run.version import version_line

_COMMIT = ", commit "


class _Known(NamedTuple):
    """A worker that was asked: who it is at its address, and why it gets no job; "" if it gets some."""

    identity: str
    unfit: str


class DaskWorkers:
    """The workers of a cluster, of which each is asked for its version before it gets a job.

    One that lacks a module of a job would end with it, and Dask would hand that job to the next.

    Args:
        client: of the cluster.
        address: of its scheduler, for people.
        console: where workers that get no job are told, and that there is none.
    """

    def __init__(self, client: Any, address: str, console: Console) -> None:
        self._client, self._address, self._console = client, address, console
        self._known: dict[str, _Known] = {}
        self._waits, self._untold = False, list[str]()
        self._here = version_line()

    @property
    def fit(self) -> list[str]:
        """Return the addresses of those that get jobs, as of the last look."""
        return [address for address, one in self._known.items() if not one.unfit]

    @property
    def unfit(self) -> list[str]:
        """Return of each of the others a sentence that says why."""
        return [f"{address} {one.unfit}" for address, one in self._known.items() if one.unfit]

    def look(self) -> None:
        """Ask who is there, and those that are new for their version.

        Raises:
            OSError: the cluster has gone.
        """
        there = {address: one["id"] for address, one in self._client.scheduler_info(n_workers=-1)["workers"].items()}
        self._known = {name: one for name, one in self._known.items() if there.get(name) == one.identity}
        if not (new := [name for name in there if name not in self._known]):
            return
        told = {}
        for name, answer in self._client.run(version_line, workers=new, on_error="return").items():
            if not isinstance(answer, OSError):  # it has gone meanwhile, or is asked again
                told[name] = _Known(there[name], _unfit(answer, self._here))
        self._known |= told
        self._untold += [f"{name} {one.unfit}" for name, one in told.items() if one.unfit]

    def tell(self) -> None:
        """Tell which workers get no job, of those that were not told yet."""
        if self._untold:
            more = f" (and {len(self._untold) - 1} more)" if len(self._untold) > 1 else ""
            self._console.print(f"{self._untold[0]}{more}; it gets no job", markup=False)
            self._untold.clear()

    def watch(self) -> None:
        """Look, tell what `tell` tells, and once that no worker is left, and that one is there again.

        Raises:
            OSError: the cluster has gone.
        """
        self.look()
        self.tell()
        if self._waits is not bool(self.fit):
            return
        self._waits = not self.fit
        said = (
            f"no worker left at {self._address}; waits for one"
            if self._waits
            else f"a worker is at {self._address} again"
        )
        self._console.print(said, markup=False)


def _unfit(answer: Any, here: str) -> str:
    """Return why a worker that gave this answer, where the version is `here`, gets no job; "" if it gets some."""
    if isinstance(answer, BaseException):
        return f"lacks {here} ({visible(shortened(one_line(answer)))}); install it there"
    theirs = str(answer)
    if theirs == here or (_one_untold(theirs, here) and theirs.split(_COMMIT)[0] == here.split(_COMMIT)[0]):
        return ""
    return f"has {visible(theirs[:100])}, and here is {here}; install the same there"


def _one_untold(*lines: str) -> bool:
    """Return whether one of two versions does not tell its commit."""
    return not all(_COMMIT in line for line in lines)
