"""`sternplane log`: the events of toy runs, as people and as programs get them."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from rich.console import Console
from rich.text import Text
from sternplane.logs import after_log, event_list
from sternplane.logs.after_log import AfterLog
from sternplane.logs.event_list import ListedEvent, listed_events
from sternplane.logs.streaming import stream

from firmware_py.records.event import Severity
from tests.command import called

LISTED = [
    (1.0, "notice", "DISARMED -> MANUAL: ordered"),
    (1.0, "warning", "change not made: the fins <move>"),
    (2.0, "info", "waypoint 1 of 3 passed"),
]


def test_a_pipe_gets_a_line_for_each_event(flown: Path) -> None:
    result = called("log", flown, cwd=flown.parent)
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout.splitlines() == [f"{t:9.2f} s  {severity:<9}  {text}" for t, severity, text in LISTED]


def test_a_program_gets_the_same_as_json(flown: Path) -> None:
    found = json.loads(called("log", flown, "--json", cwd=flown.parent).stdout)
    assert found["log"] == str(flown)
    assert found["lost"] == ""
    assert found["events"] == [{"t_s": t, "severity": severity, "text": text} for t, severity, text in LISTED]


def test_a_terminal_gets_a_table_that_folds(flown: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = io.StringIO()
    terminal = Console(file=shown, force_terminal=True, width=45, no_color=True, markup=False)
    monkeypatch.setattr(event_list, "PlainConsole", lambda: terminal)
    called("log", flown, cwd=flown.parent)
    assert "severity" in shown.getvalue()
    assert "<move>" in shown.getvalue()
    assert max(map(len, Text.from_ansi(shown.getvalue()).plain.splitlines())) <= 45


def test_a_log_that_was_cut_off_is_listed_as_far_as_it_goes_and_says_so(flown: Path, tmp_path: Path) -> None:
    data = flown.read_bytes()
    (tmp_path / "log.mcap").write_bytes(data[: 2 * len(data) // 3])
    result = called("log", tmp_path, cwd=tmp_path)
    assert result.returncode == 0
    assert "ordered" in result.stdout
    assert result.stderr.startswith("sternplane: the log is ")
    assert result.stderr.count("\n") == 1


def test_what_happened_after_the_disk_was_full_is_listed_without_a_severity(flown: Path, tmp_path: Path) -> None:
    data, path = flown.read_bytes(), tmp_path / "log.mcap"
    path.write_bytes(data[: 2 * len(data) // 3])
    told = [(1.0, "DISARMED -> MANUAL: ordered"), (9.0, "SURFACE -> DISARMED: surfaced")]
    after = AfterLog("the disk was full", {}, 10.0, "DISARMED", 0.1, 3.0, 2.0, 3.0, 0, told)
    after_log.place_of(path).write_text(after.text())
    listed = listed_events(stream(path))
    assert listed[-1] == ListedEvent(9.0, None, "SURFACE -> DISARMED: surfaced")
    assert [event.text for event in listed].count("DISARMED -> MANUAL: ordered") == 1
    assert listed[-1].document()["severity"] is None
    assert (
        called("log", path, cwd=tmp_path).stdout.splitlines()[-1]
        == "     9.00 s  -          SURFACE -> DISARMED: surfaced"
    )


def test_the_most_severe_event_has_its_word() -> None:
    assert ListedEvent(1.0, Severity.EMERGENCY, "").document()["severity"] == "emergency"


def test_what_is_no_log_is_refused_in_a_line(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("no log\n" * 100)
    for name in ("text", "absent", "."):
        result = called("log", name, cwd=tmp_path)
        assert (result.returncode, result.stdout) == (2, "")
        assert result.stderr.startswith("sternplane: ")
        assert result.stderr.count("\n") == 1
