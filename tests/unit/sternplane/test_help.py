"""What a help text costs: it imports nothing that computes, draws or opens a bus."""

from __future__ import annotations

import subprocess
import sys

import pytest

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
