"""The bench of lateness, with a clock that the test moves. What it measures is not judged here."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from sternplane.bench import lateness

from firmware_py.adapters import realtime_schedule


class Clock:
    """Every sleep ends 80 us late."""

    now = 0

    def monotonic_ns(self) -> int:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += round(seconds * 1e9) + 80_000


def test_our_loop_counts_every_tick_that_it_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(realtime_schedule, "time", Clock())
    assert lateness.ours(lateness.EMPTY)(1000, 5) == [80_000] * 5


def test_the_ratios_are_ours_over_cs() -> None:
    def late(median: float, p99: float, most: float) -> dict[str, float]:
        return {"median_us": median, "p99_us": p99, "max_us": most}

    table = {"loop": late(90.0, 150.0, 400.0), "autopilot": late(60.0, 300.0, 100.0), "c": late(60.0, 100.0, 800.0)}
    assert lateness.with_ratios(table, "") == table | {
        "loop over c": {"median": 1.5, "p99": 1.5, "max": 0.5},
        "autopilot over c": {"median": 1.0, "p99": 3.0, "max": 0.12},
    }


def test_without_a_compiler_it_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(lateness.NoCompiler, match="no C compiler"):
        lateness.compile_loop(tmp_path)
    assert lateness.with_ratios({"loop": {"median_us": 1.0}}, "no C compiler (cc) on this machine") == {
        "loop": {"median_us": 1.0},
        "c": "not measured: no C compiler (cc) on this machine",
    }


def test_a_compiler_that_fails_is_quoted(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    cc = tmp_path / "cc"
    cc.write_text("#!/bin/sh\necho 'time.h: not found' >&2\nexit 1\n")
    cc.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda name: str(cc))
    with pytest.raises(lateness.NoCompiler, match=r"cannot compile lateness.c: time.h: not found"):
        lateness.compile_loop(tmp_path)


def test_what_the_compiled_program_prints_is_what_was_measured(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The compiler is a stand-in that makes a program which prints what it was asked."""
    cc = tmp_path / "cc"
    cc.write_text('#!/bin/sh\nprintf \'#!/bin/sh\\necho $1\\necho $2\\n\' > "$3"\nchmod +x "$3"\n')
    cc.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda name: str(cc))
    assert lateness.compile_loop(tmp_path)(1000, 7) == [1_000_000, 7]


def test_the_c_source_is_there_and_is_clean_c_where_there_is_a_compiler(tmp_path: Path) -> None:
    source = lateness.SOURCE.read_text()
    assert "clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME" in source
    if cc := shutil.which("cc"):
        program = tmp_path / "lateness"
        strict = [cc, "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2", "-o", program]
        subprocess.run([*strict, lateness.SOURCE], check=True)
        late = [int(line) for line in subprocess.check_output([program, "1000000", "20"]).split()]
        assert len(late) == 20
        assert min(late) >= 0, "it never wakes before its deadline"
        assert subprocess.run([program, "0", "20"], capture_output=True, check=False).returncode == 2
