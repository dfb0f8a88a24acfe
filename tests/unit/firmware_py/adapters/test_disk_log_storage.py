"""Logs on the disk, read by a child process: listing, reading while they grow, erasing."""

from __future__ import annotations

import errno
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import pytest

from firmware_py.adapters.storage.disk_log_storage import DiskLogStorage

T = TypeVar("T")
OLD, OWN = bytes(i * i % 251 for i in range(200_000)), b"begun"


def soon(ask: Callable[[], T | None]) -> T:
    """Return the answer once it has arrived."""
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        answer = ask()
        if answer is not None:
            return answer
        time.sleep(0.001)
    raise AssertionError("no answer arrived")


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    for name, content in (("a-old", OLD), ("b-new", b"new"), ("c-own", OWN)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "log.mcap").write_bytes(content)
    os.utime(tmp_path / "a-old" / "log.mcap", (1_700_000_000, 1_700_000_000))
    (tmp_path / "latest").symlink_to("a-old")
    (tmp_path / "empty").mkdir()
    return tmp_path


@pytest.fixture
def store(runs: Path) -> Iterator[DiskLogStorage]:
    store = DiskLogStorage(runs / "c-own", beside=True)
    yield store
    store.close()
    store.close()


def test_each_log_is_listed_once_by_its_run(store: DiskLogStorage, runs: Path) -> None:
    listed = soon(store.logs)
    assert [(log.name, log.size, log.growing) for log in listed] == [
        ("a-old.mcap", 200_000, False),
        ("b-new.mcap", 3, True),
        ("c-own.mcap", 5, True),
    ]
    assert listed[0].written == 1_700_000_000
    alone = DiskLogStorage(runs / "c-own", beside=False)
    assert [log.name for log in soon(alone.logs)] == ["c-own.mcap"]
    alone.close()


@pytest.mark.parametrize(("offset", "n"), [(0, 90), (65_500, 90), (199_990, 90), (0, 65_536), (100, 65_536)])
def test_any_part_is_read_also_across_blocks(store: DiskLogStorage, offset: int, n: int) -> None:
    assert soon(lambda: store.read("a-old.mcap", offset, n)) == OLD[offset : offset + n]
    assert soon(lambda: store.read("a-old.mcap", 200_000, n)) == b""


def test_a_growing_log_is_read_on_to_its_new_end(store: DiskLogStorage, runs: Path) -> None:
    assert soon(lambda: store.read("c-own.mcap", 0, 90)) == OWN
    assert soon(lambda: store.read("c-own.mcap", 0, 5)) == OWN
    with (runs / "c-own" / "log.mcap").open("ab") as file:
        file.write(b" and ended")
    assert soon(lambda: store.read("c-own.mcap", 0, 90)) == OWN + b" and ended"


@pytest.mark.parametrize("name", ["../c-own.mcap", "nothing.mcap", "latest.mcap", ""])
def test_what_is_not_a_log_is_not_read(store: DiskLogStorage, name: str) -> None:
    with pytest.raises(OSError, match="No such file") as raised:
        soon(lambda: store.read(name, 0, 10))
    assert raised.value.errno == errno.ENOENT


def test_erasing_keeps_logs_that_may_still_grow(store: DiskLogStorage, runs: Path) -> None:
    soon(lambda: store.erase() or None)
    assert [log.name for log in soon(store.logs)] == ["b-new.mcap", "c-own.mcap"]
    assert (runs / "a-old").is_dir()


def test_logs_that_cannot_be_erased_are_an_error(store: DiskLogStorage, runs: Path) -> None:
    log = runs / "a-old" / "log.mcap"
    log.unlink()
    log.mkdir()
    os.utime(log, (1_700_000_000, 1_700_000_000))
    with pytest.raises(OSError, match="Is a directory"):
        soon(lambda: store.erase() or None)
    assert log.exists()


def children() -> set[int]:
    """Return the processes that this one has begun."""
    return {int(pid) for task in Path("/proc/self/task").iterdir() for pid in (task / "children").read_text().split()}


def test_a_child_that_has_ended_is_an_error_and_not_an_end_of_file(runs: Path) -> None:
    before = children()
    store = DiskLogStorage(runs / "c-own", beside=True)
    (child,) = children() - before
    soon(store.logs)
    os.kill(child, signal.SIGSTOP)
    assert store.read("b-new.mcap", 0, 10) is None  # asked for, and not answered
    os.kill(child, signal.SIGKILL)
    os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT)
    for name in ("a-old.mcap", "b-new.mcap"):
        with pytest.raises(OSError, match="has ended"):
            store.read(name, 0, 10)
    with pytest.raises(OSError, match="has ended"):
        store.erase()
    store.close()
