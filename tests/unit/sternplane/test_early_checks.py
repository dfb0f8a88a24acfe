"""A mistake in a name is told at once, in a process of its own: what finds it imports nothing that computes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize(
    "words",
    [
        "sitl --config nowhere",
        "plant --config nowhere",
        "fly --config nowhere",
        "vehicle check nowhere",
        "study tuning --config nowhere",
        "sweep --scenario demo --vary vehicle.M_q=±20% --config nowhere",
        "sitl --scenario nowhere",
        "sitl --io nowhere",
        "replay nowhere",
    ],
)
def test_a_name_that_there_is_not_costs_no_compiling(words: str, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    done = subprocess.run(
        [sys.executable, "-m", "sternplane.cli.main", *words.split()],
        env=environment | {"STERNPLANE_CACHE": str(cache), "PYTHONPATH": f"{ROOT}:{ROOT / 'tools'}"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 2
    assert "nowhere" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not cache.exists()
