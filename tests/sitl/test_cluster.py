"""A campaign on a Dask cluster: which workers get jobs, and what is told of those that go, come, or cannot do them."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console
from sternplane.campaign.crew import Died
from sternplane.campaign.dask_crew import DaskCrew

from firmware_py.run.usage_error import UsageError
from tests.cluster import BARE, OLD, dask, scheduler_in, until, worker
from tests.unit.sternplane.campaign_jobs import held, squared


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a scheduler, of which every test ends its workers."""
    with scheduler_in(tmp_path_factory.mktemp("cluster")) as (address, _):
        yield address


def console() -> Console:
    return Console(file=StringIO(), width=1000)


def begin(results: Iterator, into: list) -> threading.Thread:
    """Collect results in a thread."""
    thread = threading.Thread(target=lambda: into.extend(results), daemon=True)
    thread.start()
    return thread


@pytest.mark.parametrize(("first", "said"), [(BARE, "lacks sternplane "), (OLD, "has sternplane 0.0.1")])
def test_a_cluster_of_workers_that_cannot_do_it_is_refused(cluster: str, tmp_path: Path, first: str, said: str) -> None:
    told = console()
    with worker(cluster, tmp_path, first), pytest.raises(UsageError) as refused:
        DaskCrew(cluster, told)
    assert "gets no job" not in told.file.getvalue()
    assert f"--dask {cluster}: no worker can do it: tcp://" in str(refused.value)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_worker_that_cannot_do_it_and_joins_later_gets_no_job_and_costs_none(cluster: str, tmp_path: Path) -> None:
    told, found = console(), []
    (hold := tmp_path / "hold").touch()
    with (
        worker(cluster, tmp_path),
        DaskCrew(cluster, told) as crew,
        worker(cluster, tmp_path, BARE) as bare,
    ):
        thread = begin(crew.results(held, ((k, (k, str(tmp_path))) for k in range(20))), found)
        until(lambda: "it gets no job" in told.file.getvalue(), thread.is_alive)
        hold.unlink()
        thread.join(60.0)
        assert bare.poll() is None
    assert sorted(found) == [(k, k) for k in range(20)]
    assert told.file.getvalue().count("it gets no job") == 1


def test_where_no_worker_is_left_that_is_told_and_one_that_comes_goes_on(cluster: str, tmp_path: Path) -> None:
    told, found = console(), []
    with contextlib.ExitStack() as stack:
        first = stack.enter_context(worker(cluster, tmp_path))
        crew = stack.enter_context(DaskCrew(cluster, told))
        (hold := tmp_path / "hold").touch()
        thread = begin(crew.results(held, ((k, (k, str(tmp_path))) for k in range(5))), found)
        until((tmp_path / "begun").exists, thread.is_alive)
        first.kill()
        until(lambda: f"no worker left at {cluster}; waits for one" in told.file.getvalue(), thread.is_alive)
        stack.enter_context(worker(cluster, tmp_path, BARE))
        until(lambda: "it gets no job" in told.file.getvalue(), thread.is_alive)
        hold.unlink()
        stack.enter_context(worker(cluster, tmp_path))
        thread.join(60.0)
        assert not thread.is_alive()
    assert sorted(found) == [(k, k) for k in range(5)]
    lines = told.file.getvalue().splitlines()
    assert [line for line in lines if line.endswith(("again", "for one"))] == [
        f"no worker left at {cluster}; waits for one",
        f"a worker is at {cluster} again",
    ]


def test_of_the_jobs_of_a_worker_that_dies_again_and_again_the_deadly_one_alone_is_given_up(
    cluster: str, tmp_path: Path
) -> None:
    words = ("--nthreads", "1", "--local-directory", tmp_path)  # with a nanny, which starts it again
    with dask("worker", cluster, *words, cwd=tmp_path), DaskCrew(cluster, console()) as crew:
        found = dict(crew.results(squared, ((k, (k, str(tmp_path), 1, False)) for k in range(5))))
    assert isinstance(found.pop(1), Died)
    assert found == {k: k * k for k in (0, 2, 3, 4)}


def test_a_worker_that_goes_after_the_last_result_is_not_waited_for(
    cluster: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sternplane.campaign.dask_crew._LOOK", 0.0)
    told, rest = console(), []
    with worker(cluster, tmp_path) as only, DaskCrew(cluster, told) as crew:
        results = crew.results(held, ((k, (k, str(tmp_path))) for k in range(2)))
        assert sorted([next(results), next(results)]) == [(0, 0), (1, 1)]
        only.kill()
        until(lambda: not crew._there(), lambda: True)
        thread = begin(results, rest)
        thread.join(20.0)
        assert not thread.is_alive()
    assert rest == []
