"""Who does the jobs of a campaign: the workers of a Dask cluster. One that dies costs no job."""

from __future__ import annotations

import contextlib
import uuid
from collections.abc import Callable, Generator, Iterable
from importlib import import_module
from itertools import islice
from typing import Any, TypeVar
from urllib.parse import urlsplit

from rich.console import Console

from firmware_py.error_text import one_line, shortened
from firmware_py.foreign_text import visible
from firmware_py.run.usage_error import UsageError
from sternplane.campaign.crew import Died
from sternplane.campaign.remote_job import call_packed, packed

Job = TypeVar("Job")
Result = TypeVar("Result")
_AHEAD = 2
_CONNECT, _WORKERS = 10.0, 60.0
"""How long a scheduler, and then a worker, may take to be there, s."""


def check_address(address: str) -> None:
    """Refuse what is no address of a scheduler, before anything waits for it.

    Raises:
        UsageError: neither tcp://HOST:PORT nor tls://HOST:PORT, or TLS without a certificate of one's own.
    """
    told = f"--dask {visible(shortened(address))}"
    try:
        parts = urlsplit(address)
        whole = parts.scheme in ("tcp", "tls") and parts.hostname and parts.port and not parts.username
        whole = whole and address.isprintable() and not (parts.path or parts.query or parts.fragment)
    except ValueError:  # a port beyond 65535, or brackets that do not close
        whole = False
    if not whole:
        raise UsageError(f"{told}: write tcp://HOST:PORT, such as tcp://10.0.0.1:8786 (tls:// where Dask has that)")
    if parts.scheme == "tls":
        distributed: Any = import_module("distributed")
        try:
            context = distributed.Security().get_connection_args("client").get("ssl_context")
        except (OSError, ValueError, TypeError) as error:
            raise UsageError(f"{told}: the certificates cannot be used ({one_line(error)[:80]})") from None
        if context is None:
            raise UsageError(f"{told}: set distributed.comm.tls in Dask's configuration first: ca-file and client")


class DaskCrew(contextlib.AbstractContextManager["DaskCrew"]):
    """The workers of a cluster, those too that come later.

    Args:
        address: of the scheduler, such as tcp://10.0.0.1:8786.
        console: for what is going on.

    Raises:
        UsageError: it is no address, no scheduler is there, or no worker comes.
    """

    def __init__(self, address: str, console: Console) -> None:
        check_address(address)
        distributed: Any = import_module("distributed")
        told = f"--dask {shortened(address)}"
        try:
            self._client = distributed.Client(address, timeout=_CONNECT, set_as_default=False)
        except (OSError, ValueError) as error:
            why = f"no scheduler answers ({one_line(error)[:80]})"
            raise UsageError(f"{told}: {why}; start one with `dask scheduler`") from None
        try:
            if not self.size:
                console.print(f"{address}: waiting for workers", highlight=False)
                self._client.wait_for_workers(1, timeout=_WORKERS)
        except TimeoutError:
            self._client.close()
            start = f"dask worker {address} --nworkers auto --nthreads 1"
            raise UsageError(f"{told}: no worker came for {_WORKERS:g} s; start some with `{start}`") from None
        except BaseException:
            self._client.close()
            raise

        if threaded := [name for name, one in self._workers().items() if one["nthreads"] > 1]:
            advice = "start it with --nworkers N --nthreads 1 to use N processors"
            console.print(f"{threaded[0]} has several threads, and does one job at a time; {advice}", highlight=False)

    @property
    def size(self) -> int:
        """Return how many workers there are; each does one job at a time."""
        return len(self._workers())

    def _workers(self) -> dict[str, Any]:
        found: dict[str, Any] = self._client.scheduler_info(n_workers=-1)["workers"]
        return found

    def results(
        self, work: Callable[..., Result], jobs: Iterable[tuple[Job, tuple[Any, ...]]]
    ) -> Generator[tuple[Job, Result | Died]]:
        """See `crew.Crew`."""
        distributed: Any = import_module("distributed")
        waiting, finished = iter(jobs), distributed.as_completed(loop=self._client.loop)
        begun: dict[str, Job] = {}

        def hand_out() -> None:
            for job, arguments in islice(waiting, max(_AHEAD * self.size - len(begun), 0)):
                call, key = packed(work, arguments), f"sternplane-{uuid.uuid4().hex}"
                future = self._client.submit(call_packed, call, key=key, pure=False)
                begun[future.key] = job
                finished.add(future)

        hand_out()
        for future in finished:
            job = begun.pop(future.key)
            try:
                yield job, future.result()
            except distributed.KilledWorker as error:
                yield job, Died(one_line(error)[:200])
            except (distributed.CancelledError, OSError) as error:
                raise UsageError(f"the cluster has gone ({type(error).__name__}); start it again to go on") from None
            future.release()
            hand_out()

    def close(self) -> None:
        """Leave the cluster; what it was to do for us is forgotten."""
        self._client.close()

    def __exit__(self, *_: object) -> None:
        self.close()
