"""`make setup` where Python cannot make a virtual environment: what it says, and what it leaves alone."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PYTHON = """#!/bin/sh
case "$*" in
*ensurepip*) exit {ensurepip} ;;
*venv*) mkdir -p .venv && touch .venv/half; echo "Error: no space" >&2; exit 1 ;;
esac
"""


def made(folder: Path, ensurepip: int = 0) -> str:
    """Call make with a Python whose venv fails; the output."""
    shutil.copy(ROOT / "Makefile", folder)
    python = folder / "python"
    python.write_text(PYTHON.format(ensurepip=ensurepip))
    python.chmod(0o755)
    words = ["make", "--no-print-directory", ".venv/bin/python", f"PYTHON={python}"]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode != 0
    return done.stderr


@pytest.mark.parametrize("ensurepip", [0, 1])
def test_a_folder_that_was_there_is_kept(tmp_path: Path, ensurepip: int) -> None:
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "precious").write_text("kept")
    made(tmp_path, ensurepip)
    assert (tmp_path / ".venv" / "precious").read_text() == "kept"


def test_what_this_run_made_is_removed_and_the_cause_is_not_put_down_to_a_missing_package(tmp_path: Path) -> None:
    said = made(tmp_path)
    assert not (tmp_path / ".venv").exists()
    assert "Error: no space" in said
    assert "-m venv .venv has failed, as said above" in said
    assert "apt-get" not in said


def test_a_python_without_venv_is_said_with_the_package(tmp_path: Path) -> None:
    assert "has no venv: apt-get install python3-venv" in made(tmp_path, ensurepip=1)
