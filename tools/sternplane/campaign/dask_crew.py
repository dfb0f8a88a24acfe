"""Who does the jobs of a campaign: the workers of a Dask cluster. One that dies costs no job."""

from __future__ import annotations

import contextlib
import logging
import time
import uuid
from collections import deque
from collections.abc import Callable, Generator, Iterable
from importlib import import_module
from typing import Any, NamedTuple, TypeVar
from urllib.parse import urlsplit

from rich.console import Console

from firmware_py.error_text import one_line, shortened
from firmware_py.foreign_text import visible
from firmware_py.run.usage_error import UsageError
from sternplane.campaign.crew import Died
from sternplane.campaign.dask_workers import DaskWorkers
from sternplane.campaign.remote_job import call_packed, packed

Job = TypeVar("Job")
Result = TypeVar("Result")
_AHEAD = 2
_TRIES = 4
"""So often a job is handed out whose workers have all gone; of those that go singly Dask counts `allowed-failures`."""
_LOGGERS = ("distributed", "distributed.client", "tornado.application", "asyncio")
"""They print what goes wrong with the scheduler, page by page; the command says it in a line."""
_LOOK, _MOMENT = 1.0, 0.02
"""Between two looks for workers, and for what has come, s."""
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


class _Handed(NamedTuple):
    """A job, its call, and once it was handed out what will come of it, to which workers, and how often until now."""

    job: Any
    call: bytes
    future: Any = None
    fit: frozenset[str] = frozenset()
    tries: int = 0


def _result(future: Any, result: Any) -> Any:
    """Return what came of a job."""
    distributed: Any = import_module("distributed")
    if isinstance(result, distributed.CancelledError):
        raise result
    if future.status != "error":
        return result
    _, error, traceback = result
    if isinstance(error, distributed.KilledWorker):
        return Died(one_line(error)[:200])
    raise error.with_traceback(traceback)


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
        for name in _LOGGERS:
            logging.getLogger(name).setLevel(logging.CRITICAL)
        told = f"--dask {shortened(address)}"
        try:
            self._client = distributed.Client(address, timeout=_CONNECT, set_as_default=False)
        except (OSError, ValueError) as error:
            why = f"no scheduler answers ({one_line(error)[:80]})"
            raise UsageError(f"{told}: {why}; start one with `dask scheduler`") from None
        self._workers = DaskWorkers(self._client, address, console)
        try:
            if not self._there():
                console.print(f"{address}: waiting for workers", highlight=False)
                self._client.wait_for_workers(1, timeout=_WORKERS)
            self._workers.look()
            if not self.size and (unfit := self._workers.unfit):
                raise UsageError(f"{told}: no worker can do it: {unfit[0]}")
            self._workers.tell()
        except TimeoutError:
            self._client.close()
            start = f"dask worker {address} --nworkers auto --nthreads 1"
            raise UsageError(f"{told}: no worker came for {_WORKERS:g} s; start some with `{start}`") from None
        except BaseException:
            self._client.close()
            raise

        if threaded := [name for name, one in self._there().items() if one["nthreads"] > 1]:
            advice = "start it with --nworkers N --nthreads 1 to use N processors"
            console.print(f"{threaded[0]} has several threads, and does one job at a time; {advice}", highlight=False)

    @property
    def size(self) -> int:
        """Return how many workers do jobs, one at a time each."""
        return len(self._workers.fit)

    def _there(self) -> dict[str, Any]:
        found: dict[str, Any] = self._client.scheduler_info(n_workers=-1)["workers"]
        return found

    def results(
        self, work: Callable[..., Result], jobs: Iterable[tuple[Job, tuple[Any, ...]]]
    ) -> Generator[tuple[Job, Result | Died]]:
        """See `crew.Crew`.

        Each job is bound to the workers that were found fit when it was handed out; if all of these have gone, it is
        handed out again, with no other behind it: so the one whose fault it is is known. What still comes of it from
        before is dropped.
        """
        distributed: Any = import_module("distributed")
        finished = distributed.as_completed(loop=self._client.loop, with_results=True, raise_errors=False)
        waiting, again = (_Handed(job, packed(work, arguments)) for job, arguments in jobs), deque[_Handed]()
        begun: dict[str, _Handed] = {}
        looked = time.monotonic()
        try:
            while True:
                while len(begun) < (1 if again else _AHEAD) * self.size:
                    if not (one := again.popleft() if again else next(waiting, None)):
                        break
                    handed = self._hand_out(one)
                    begun[handed.future.key] = handed
                    finished.add(handed.future)
                if not (begun or again):
                    if (one := next(waiting, None)) is None:
                        return
                    again.append(one)  # nobody is there who could take it
                for future, result in self._arrived(finished):
                    if done := begun.pop(future.key, None):
                        yield done.job, _result(future, result)
                if time.monotonic() - looked < _LOOK:
                    continue
                self._workers.watch()
                looked = time.monotonic()
                for key in [key for key, one in begun.items() if self._is_stranded(one)]:
                    one = begun.pop(key)
                    one.future.cancel()
                    if one.tries < _TRIES:
                        again.append(one)
                    else:
                        yield one.job, Died(f"every worker that began it died ({_TRIES} times)")
        except (distributed.CancelledError, OSError) as error:
            raise UsageError(f"the cluster has gone ({type(error).__name__}); start it again to go on") from None

    def _hand_out(self, one: _Handed) -> _Handed:
        fit, key = self._workers.fit, f"sternplane-{uuid.uuid4().hex}"
        future = self._client.submit(call_packed, one.call, key=key, pure=False, workers=fit)
        return one._replace(future=future, fit=frozenset(fit), tries=one.tries + 1)

    def _is_stranded(self, one: _Handed) -> bool:
        """Return whether nobody does a job, and there is somebody who could.

        Not done is "lost" too: what had come of it has gone with its worker.
        """
        return bool(self.size) and not one.future.done() and one.fit.isdisjoint(self._workers.fit)

    def _arrived(self, finished: Any) -> list[tuple[Any, Any]]:
        """Return what has come of jobs; where nothing has, a moment later."""
        if self._client.status not in ("running", "connecting"):
            raise ConnectionError
        if not (found := finished.next_batch(block=False)):
            time.sleep(_MOMENT)
        return list(found)

    def close(self) -> None:
        """Leave the cluster; what it was to do for us is forgotten."""
        self._client.close()

    def __exit__(self, *_: object) -> None:
        self.close()
