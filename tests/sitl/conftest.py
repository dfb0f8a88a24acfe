"""What the tests of whole processes have in common."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.dive import DIVE
from tests.sitl.command import COMMAND, Start


@pytest.fixture
def dive(tmp_path: Path) -> Path:
    """A scenario of 12 s, in eddies; it may be written anew."""
    path = tmp_path / "dive.toml"
    path.write_text(f"{DIVE}[environment]\nturbulence_m_s = 0.03\n")
    return path


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Starts `sternplane ...` in the background; what is still running when the test ends is ended."""
    processes: list[subprocess.Popen[str]] = []

    def start(*arguments: str | Path) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [COMMAND, *arguments], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()
