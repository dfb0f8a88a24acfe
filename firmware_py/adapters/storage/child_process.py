"""A child process that does slow work on the disk; the cycle talks to it by pipes that never block.

It ends when its input is closed, and only then: SIGTERM, which a shutdown sends to all, ends the flight first.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys


class ChildProcess:
    """A module of ours, run by this Python.

    Args:
        module: its name.
        words: its arguments.
        ended: what `said` returns once, when it has ended by itself.

    Attributes:
        stdin: the descriptor of its standard input, which a write that does not fit leaves as it is.
        stdout: that of its standard output, of which nothing is read where nothing has come.
    """

    def __init__(self, module: str, *words: str, ended: str = "") -> None:
        self._ended = [ended] if ended else []
        unblocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})  # the child inherits it
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", module, *words],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C ends the flight first, which then ends this
            )
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, unblocked)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self.stdin, self.stdout = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self.stdin, False)
        os.set_blocking(self.stdout, False)

    @property
    def closed(self) -> bool:
        """Return whether it was closed."""
        return self._process.stdin is None or self._process.stdin.closed

    def said(self, most: int) -> list[str]:
        """Return the lines that it has said since the last call, of so many bytes at most; mostly none."""
        with contextlib.suppress(BlockingIOError):
            said = os.read(self.stdout, most)
            ended, self._ended = ([], self._ended) if said else (self._ended, [])
            return [*said.decode(errors="replace").splitlines(), *ended]
        return []

    def close(self, seconds: float | None = None, *, kill: bool = False) -> None:
        """End its input, and wait until it has ended. A second call does nothing.

        Args:
            seconds: how long to wait at most; None: until it has ended.
            kill: whether it is killed then; else it goes on by itself.
        """
        process = self._process
        if process.stdin is None or process.stdin.closed:
            return
        process.stdin.close()
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            if kill:
                process.kill()
                process.wait()
        if process.stdout is not None:
            process.stdout.close()
