"""Worker processes end with the one that started them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from io import StringIO

import pytest
from rich.console import Console
from sternplane.campaign.engine import complete

HEARS = "signal.signal(signal.SIGINT, signal.default_int_handler)  # as a child of a shell's background would not\n"
STARTER = f"""
import os, signal, time
from rich.console import Console
from sternplane.campaign.workers import workers
{HEARS}
if __name__ == "__main__":
    with workers(1, Console(stderr=True)) as (_, pool):
        print(pool.submit(os.getpid).result(), flush=True)
        pool.submit(time.sleep, 600.0).result()
"""


INTERRUPTED = STARTER.replace("print(pool", "pool.submit(time.sleep, 600.0); print(pool").replace("(1, Con", "(2, Con")

INTERRUPTED_WHILE_STARTING = f"""
import multiprocessing.popen_spawn_posix as popen, os, signal, time
from rich.console import Console
from sternplane.campaign.workers import workers
{HEARS}
start = popen.Popen._launch

def interrupted(self, process):
    start(self, process)
    print(self.pid, flush=True)
    os.kill(os.getpid(), signal.SIGINT)

if __name__ == "__main__":
    try:
        with workers(2, Console(stderr=True)) as (_, pool):
            pool.submit(time.sleep, 600.0)
            popen.Popen._launch = interrupted
            pool.submit(time.sleep, 600.0)
    except KeyboardInterrupt:
        time.sleep(600.0)
"""

ORPHANED = """
import os, time
from sternplane.campaign.workers import pool_of

if __name__ == "__main__":
    with pool_of(1) as pool:
        pool.submit(os.getpid).result()
else:
    starter = os.getppid()
    print(os.getpid(), flush=True)
    while os.getppid() == starter:
        time.sleep(0.01)
"""


def is_running(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):  # the latter of one that is reaped after its file was opened
        return False


def ends(worker: int) -> bool:
    """Return whether a process ends within 20 s; if not, kill it."""
    end = time.monotonic() + 20.0
    while is_running(worker) and time.monotonic() < end:
        time.sleep(0.01)
    if not is_running(worker):
        return True
    os.kill(worker, signal.SIGKILL)
    return False


@pytest.mark.parametrize("text", [STARTER, ORPHANED], ids=["at work", "before it began"])
def test_a_worker_ends_when_its_starter_is_killed(text: str, tmp_path) -> None:
    script = tmp_path / "starter.py"
    script.write_text(text)
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as starter:
        assert starter.stdout is not None
        worker = int(starter.stdout.readline())
        assert is_running(worker)
        starter.send_signal(signal.SIGKILL)
        gone = ends(worker)
    assert gone


def test_an_interrupt_ends_a_worker_that_is_being_started(tmp_path) -> None:
    script = tmp_path / "starter.py"
    script.write_text(INTERRUPTED_WHILE_STARTING)
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as starter:
        assert starter.stdout is not None
        try:
            gone = ends(int(starter.stdout.readline()))
            going_on = is_running(starter.pid)
        finally:
            starter.kill()
    assert gone
    assert going_on


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_workers_in_the_middle_of_their_work(tmp_path, number: signal.Signals) -> None:
    script = tmp_path / "starter.py"
    script.write_text(INTERRUPTED)
    with subprocess.Popen(
        [sys.executable, script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as starter:
        assert starter.stdout is not None
        worker = int(starter.stdout.readline())
        starter.send_signal(number)
        ended = ends(starter.pid)
        gone = ends(worker)
        said = starter.stderr.read()
    assert ended
    assert gone
    assert "resource_tracker" not in said


def test_all_jobs_are_done_and_each_part_is_told() -> None:
    told, found = Console(file=StringIO(), width=200), {}
    complete(divmod, range(8), lambda k: (k, 3), found.__setitem__, "divisions", told, parts=4)
    assert found == {k: divmod(k, 3) for k in range(8)}
    lines = [line.partition(",")[0] for line in told.file.getvalue().splitlines()]  # a slow machine tells what is left
    assert lines == [f"{k} of 8 divisions" for k in (2, 4, 6, 8)]
