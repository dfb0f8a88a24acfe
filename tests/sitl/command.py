"""The `sternplane` command, as a process of its own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

COMMAND = Path(sys.executable).parent / "sternplane"
Start = Callable[..., subprocess.Popen[str]]
"""Starts it with these words, in the background."""


def sternplane(*arguments: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Runs it to its end."""
    return subprocess.run([COMMAND, *arguments], cwd=cwd, capture_output=True, text=True, check=False, timeout=110)
