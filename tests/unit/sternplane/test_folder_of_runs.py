"""Who gives the folder of all runs, where that of one is meant, is told which ones there are."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from sternplane.logs.reading import find

from firmware_py.adapters.storage.recorder import LogError


def test_a_folder_of_runs_is_told_from_a_run(tmp_path: Path) -> None:
    assert find(tmp_path) == tmp_path / "log.mcap"  # what reads it says that there is none
    for run in ("a", "b"):
        (tmp_path / run).mkdir()
        (tmp_path / run / "log.2.mcap").touch()
    assert find(tmp_path / "a") == tmp_path / "a" / "log.2.mcap"
    with pytest.raises(
        LogError, match=rf"a folder of runs, not a run; give one .* such as {re.escape(str(tmp_path))}/b$"
    ):
        find(tmp_path)
    (tmp_path / "latest").symlink_to("gone")
    with pytest.raises(LogError, match=r"such as \S+/b$"):
        find(tmp_path)
    (tmp_path / "latest").unlink()
    (tmp_path / "latest").symlink_to("a")
    with pytest.raises(LogError, match=r"such as \S+/latest$"):
        find(tmp_path)
    (tmp_path / "log.mcap").touch()
    assert find(tmp_path) == tmp_path / "log.mcap"
