"""The `sternplane` command, called in three ways: in this process, forked from a warm one, and as it is installed.

A Python process that begins anew takes seconds of a processor to import what it needs. So a test calls the command in
its own process where that shows the same, forks it where signals, kills or two processes are the matter, and starts the
installed script where the script itself is.
"""

from __future__ import annotations

import contextlib
import io
import multiprocessing
import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from multiprocessing.context import ForkServerProcess
from pathlib import Path
from tempfile import TemporaryDirectory

from sternplane.cli.main import main

SCRIPT = Path(sys.executable).parent / "sternplane"
"""As installed."""
_FORKS = multiprocessing.get_context("forkserver")
_FORKS.set_forkserver_preload(["tests.preload"])


def called(*arguments: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command to its end in this process; the exit status and the output are what a process would have had."""
    words = [str(argument) for argument in arguments]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.chdir(cwd), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(words)
        except SystemExit as ended:
            status = int(ended.code or 0)
    return subprocess.CompletedProcess(words, status, out.getvalue(), err.getvalue())


def installed(*arguments: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the installed command to its end."""
    return subprocess.run([SCRIPT, *arguments], cwd=cwd, capture_output=True, text=True, check=False, timeout=110)


@contextlib.contextmanager
def no_file_larger_than(size: int) -> Iterator[None]:
    """No file of this process grows beyond that many bytes, as on a disk that is full."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


class Forked:
    """The command in a process of its own that began with everything imported; used as a `subprocess.Popen`."""

    def __init__(self, *arguments: str | Path, cwd: Path) -> None:
        self._folder = TemporaryDirectory()
        self._out, self._err = (Path(self._folder.name, name) for name in ("out", "err"))
        words = [str(argument) for argument in arguments]
        self._process: ForkServerProcess = _FORKS.Process(target=_be, args=(words, cwd, self._out, self._err))
        self._process.start()

    @property
    def returncode(self) -> int | None:
        """The exit status, None while it runs; minus the signal's number if one has killed it."""
        return self._process.exitcode

    @property
    def stdout(self) -> str:
        """What it has written until now."""
        return _text(self._out)

    @property
    def stderr(self) -> str:
        """What it has written until now."""
        return _text(self._err)

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.returncode is None:
            assert self._process.pid is not None
            os.kill(self._process.pid, number)

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    def communicate(self, timeout: float) -> tuple[str, str]:
        """Return (stdout, stderr) once it has ended.

        Raises:
            TimeoutError: it has not ended within `timeout`, s.
        """
        self._process.join(timeout)
        if self.returncode is None:
            raise TimeoutError(f"it still runs after {timeout:g} s:\n{self.stdout}{self.stderr}")
        return self.stdout, self.stderr

    def until_said(self, words: str, timeout: float = 60.0) -> None:
        """Return once it has written these words to stderr."""
        end = time.monotonic() + timeout
        while words not in self.stderr:
            assert self.returncode is None, f"it ended before it said {words!r}:\n{self.stderr}"
            assert time.monotonic() < end, f"it did not say {words!r} within {timeout:g} s:\n{self.stderr}"
            time.sleep(0.02)

    def close(self) -> None:
        """End it if it still runs; what it wrote is forgotten."""
        self.kill()
        self._process.join()
        self._process.close()
        self._folder.cleanup()


def _be(words: list[str], cwd: Path, *outputs: Path) -> None:
    """Be the command; stdout and stderr go to these files."""
    for number, path in zip((1, 2), outputs, strict=True):
        opened = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(opened, number)
        os.close(opened)
    sys.stdout, sys.stderr = (os.fdopen(number, "w", buffering=1) for number in (1, 2))
    os.chdir(cwd)
    sys.exit(main(words))


def _text(path: Path) -> str:
    return path.read_text(errors="replace") if path.exists() else ""
