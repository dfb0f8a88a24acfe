"""Many jobs on many processors: each done once, whoever dies, and kept at once."""

from __future__ import annotations

import json
import multiprocessing
import threading
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console
from sternplane.campaign.crew import Died, LocalCrew
from sternplane.campaign.engine import JobDied, complete
from sternplane.campaign.line_store import LineStore

from firmware_py.run.usage_error import UsageError
from tests.command import no_file_larger_than
from tests.unit.sternplane.campaign_jobs import squared, with_thread

QUIET = Console(file=StringIO())


def test_a_worker_that_is_killed_costs_no_job_and_none_counts_twice(tmp_path: Path) -> None:
    found = list(LocalCrew(2).results(squared, ((k, (k, str(tmp_path), 3, True)) for k in range(8))))
    assert sorted(found) == [(k, k * k) for k in range(8)]


def test_a_thread_that_a_job_has_left_does_not_keep_a_campaign_from_its_end() -> None:
    found: list[tuple[int, int]] = []
    jobs = ((k, (k,)) for k in range(4))
    campaign = threading.Thread(target=lambda: found.extend(LocalCrew(2).results(with_thread, jobs)), daemon=True)
    others = multiprocessing.active_children()
    campaign.start()
    campaign.join(60.0)
    ended = not campaign.is_alive()
    for process in multiprocessing.active_children():
        if process not in others:
            process.kill()
    assert ended
    assert sorted(found) == [(k, k) for k in range(4)]


@pytest.mark.parametrize("taken", [1, 2, 3, 7])
def test_a_worker_that_dies_while_a_result_is_kept_costs_no_job(taken: int) -> None:
    """So the next job is handed to workers of which one is dead already."""
    children, threads = multiprocessing.active_children(), threading.enumerate()
    results = LocalCrew(1).results(divmod, ((k, (k, 3)) for k in range(8)))
    found = [next(results) for _ in range(taken)]
    for process in multiprocessing.active_children():
        if process not in children:
            process.kill()
    for thread in threading.enumerate():
        if thread not in threads and thread.name != "QueueFeederThread":
            thread.join(60.0)
            assert not thread.is_alive()
    assert sorted([*found, *results]) == [(k, divmod(k, 3)) for k in range(8)]


def test_a_job_that_no_process_survives_is_told_and_the_others_are_done(tmp_path: Path) -> None:
    found = dict(LocalCrew(2).results(squared, ((k, (k, str(tmp_path), 1, False)) for k in range(5))))
    assert isinstance(found.pop(1), Died)
    assert found == {k: k * k for k in (0, 2, 3, 4)}


def test_a_campaign_that_cannot_do_without_it_says_which(tmp_path: Path) -> None:
    with pytest.raises(JobDied, match=r"^0: every process that began it died"):
        complete(squared, [0], lambda k: (k, str(tmp_path), 0, False), lambda *_: None, "squares", QUIET)


class OneByOne:
    """Does jobs in this process; counts those that are handed out."""

    size = 1

    def results(self, work, jobs):
        for job, arguments in jobs:
            yield job, work(*arguments)


def test_jobs_are_handed_out_as_there_is_room_so_that_memory_stays_flat() -> None:
    taken: list[int] = []
    results = LocalCrew(1).results(divmod, ((k, (taken.append(k) or k, 3)) for k in range(50)))
    assert [next(results)[0] for _ in range(3)] == [0, 1, 2]
    assert len(taken) <= 5
    results.close()


def test_what_was_done_before_is_told_and_counts() -> None:
    told = Console(file=StringIO(), width=200)
    complete(divmod, [3], lambda k: (k, 3), lambda *_: None, "divisions", told, done=4, place="there", crew=OneByOne())
    assert told.file.getvalue().splitlines() == ["4 of 5 divisions are in there already", "5 of 5 divisions"]


class Compiling:
    """Two workers, each of which takes two minutes to begin, and then three seconds for a job."""

    size = 2

    def __init__(self) -> None:
        self.now = 0.0

    def results(self, work, jobs):
        for i, (job, arguments) in enumerate(jobs):
            self.now += (120.0 if i < self.size else 3.0) if i % self.size == 0 else 0.0
            yield job, work(*arguments)


def test_the_time_that_is_left_does_not_count_what_workers_took_to_begin(monkeypatch: pytest.MonkeyPatch) -> None:
    told, crew = Console(file=StringIO(), width=200), Compiling()
    monkeypatch.setattr("sternplane.campaign.engine.time.monotonic", lambda: crew.now)
    complete(divmod, [*range(12)], lambda k: (k, 3), lambda *_: None, "divisions", told, parts=6, crew=crew)
    assert told.file.getvalue().splitlines() == [
        "2 of 12 divisions",
        *[f"{k} of 12 divisions, about {(12 - k) * 3 / 2:.0f} s left" for k in (4, 6, 8, 10)],
        "12 of 12 divisions",
    ]


def test_a_line_that_was_being_written_is_lost_and_no_other(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    store = LineStore(path)
    for key in "ab":
        store.add({"key": key, "x": 1})
    store.add({"key": "a", "x": 2})
    store.close()
    whole = path.read_bytes()
    path.write_bytes(whole + b'{"key": "c", "x"')
    again = LineStore(path)
    assert again.keys == {"a", "b"}
    again.add({"key": "c", "x": 3})
    assert [row["x"] for row in again.of("cab")] == [3, 1, 1]
    again.close()
    assert path.read_bytes() == whole + json.dumps({"key": "c", "x": 3}).encode() + b"\n"


def test_on_a_full_disk_the_error_is_that_of_the_row_and_what_was_kept_stays(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    store = LineStore(path)
    store.add({"key": "a"})
    with no_file_larger_than(path.stat().st_size + 4):
        with pytest.raises(UsageError, match=r"cannot be written .* start it again to go on"):
            store.add({"key": "b"})
        store.close()
    again = LineStore(path)
    assert again.keys == {"a"}
    again.close()


def test_two_processes_do_not_write_one_file(tmp_path: Path) -> None:
    store = LineStore(tmp_path / "rows.jsonl")
    with pytest.raises(UsageError, match="another process is writing it"):
        LineStore(tmp_path / "rows.jsonl")
    store.close()
    LineStore(tmp_path / "rows.jsonl").close()


def test_a_file_of_something_else_is_refused_and_kept(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text("[1, 2]\n")
    with pytest.raises(UsageError, match="is no row"):
        LineStore(path)
    assert path.read_text() == "[1, 2]\n"
