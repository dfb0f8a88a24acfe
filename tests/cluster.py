"""A Dask cluster of processes of this computer, for tests of who flies on one."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

BARE = "import sys; sys.modules['sternplane'] = sys.modules['firmware_py'] = None"
"""Before a worker of a computer on which the program was never installed."""
OLD = "import firmware_py; firmware_py.__version__ = '0.0.1'"
"""Before one with another version."""


def until(true: Callable[[], bool], goes_on: Callable[[], bool], seconds: float = 90.0) -> None:
    """Return once something is true, of what must go on until then."""
    end = time.monotonic() + seconds
    while not true():
        assert goes_on()
        assert time.monotonic() < end
        time.sleep(0.01)


@contextlib.contextmanager
def dask(part: str, *words: str | Path, cwd: Path, first: str = "") -> Iterator[subprocess.Popen]:
    """A process of a cluster, ended with the block; nobody has told it of a cache of kernels.

    Args:
        part: scheduler or worker.
        words: its options.
        cwd: where it runs.
        first: what it does before anything else.
    """
    program = f"{first}\nfrom distributed.cli.dask_{part} import main; main()"
    command = [sys.executable, "-c", program, *map(str, words), "--no-dashboard"]
    bare = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    process = subprocess.Popen(command, cwd=cwd, env=bare, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def worker(scheduler: str, cwd: Path, first: str = "") -> contextlib.AbstractContextManager[subprocess.Popen]:
    """A worker of one thread, which nobody starts again."""
    return dask("worker", scheduler, "--no-nanny", "--nthreads", "1", cwd=cwd, first=first)


@contextlib.contextmanager
def scheduler_in(folder: Path) -> Iterator[tuple[str, subprocess.Popen]]:
    """A scheduler: its address, and its process."""
    pytest.importorskip("distributed")
    file = folder / "scheduler.json"
    words = ("--host", "127.0.0.1", "--port", "0", "--scheduler-file", file)
    with dask("scheduler", *words, cwd=folder) as process:
        until(lambda: file.exists() and file.stat().st_size > 0, lambda: process.poll() is None)
        yield json.loads(file.read_text())["address"], process
