"""MAVProxy without a screen: what a person types goes to its standard input, and what it prints is waited for."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
from pathlib import Path

from .vehicle import until

NOBODY = "http://127.0.0.1:9"
"""Where MAVProxy would fetch maps and descriptions from."""
MODULES = "log,wp,rally,fence,ftp,param,arm,mode,misc,link"


class Proxy:
    """A running MAVProxy, which leaves all it writes in a folder."""

    def __init__(self, master: str, folder: Path) -> None:
        words = ["--master", master, "--retries", "60", "--state-basedir", folder, "--default-modules", MODULES]
        silent = {"http_proxy": NOBODY, "https_proxy": NOBODY, "MPLBACKEND": "agg", "PYTHONUNBUFFERED": "1"}
        self.tlog = folder / "flight.tlog"
        self._process = subprocess.Popen(
            [sys.executable, Path(sys.executable).parent / "mavproxy.py", *words, "--logfile", self.tlog],
            cwd=folder,
            env={**os.environ, **silent, "HOME": str(folder)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.said = ""
        self._heard = 0
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def types(self, line: str) -> None:
        """What a person types; what is waited for from now on comes after it."""
        assert self._process.stdin is not None
        self._heard = len(self.said)
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def says(self, pattern: str) -> re.Match[str]:
        """Waits until it prints that."""
        return until(
            lambda: re.compile(pattern, re.MULTILINE).search(self.said, self._heard), f"{pattern!r} of:\n{self.said}"
        )

    def end(self) -> None:
        """Ends it: nothing more is typed."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.close()
            self._process.wait(timeout=30)
        finally:
            self._process.kill()
            self._process.wait()
            self._reader.join()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for text in iter(lambda: self._process.stdout.readline(), ""):
            self.said += text
