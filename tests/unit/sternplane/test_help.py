"""What a help text costs: it imports nothing that computes, draws or opens a bus."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.command import called

HEAVY = ("numpy", "numba", "can", "pymavlink", "mcap", "rich", "plotly", "matplotlib")


@pytest.mark.parametrize("module", ["sternplane.cli.main", "firmware_py.__main__"])
def test_a_help_text_imports_nothing_heavy(module: str) -> None:
    script = (
        "import sys, contextlib, io, importlib\n"
        f"main = importlib.import_module('{module}').main\n"
        "with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()): main(['--help'])\n"
        f"print([name for name in {HEAVY} if name in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(("command", "other"), [("plant", "fly"), ("fly", "plant")])
def test_each_end_of_the_lines_names_the_other_one(command: str, other: str, tmp_path: Path) -> None:
    told = " ".join(called(command, "--help", cwd=tmp_path).stdout.split())
    assert f"fly it against `sternplane {other} --lines DIR`" in told
