"""FIFOs, devices and read-only folders where files are expected: one line, no traceback, no wait."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from sternplane.cli.progress import Progress
from sternplane.report import report

from firmware_py.adapters import kernel_compile
from firmware_py.records.cycle import Cycle
from tests.command import SCRIPT, called
from tests.shared_flights import BRIEF

STATE = ("navigation.json", "parameters.toml", "mission.json", "fence.json", "rally.json")


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("odd")
    (folder / "brief.toml").write_text(BRIEF)
    assert called("sitl", "--scenario", "brief.toml", "--out", "good", cwd=folder).returncode == 0
    return folder


def assert_refused(folder: Path, *words: str | Path, says: str) -> None:
    result = called(*words, cwd=folder)
    assert result.returncode == 2, result.stderr
    assert result.stderr.count("\n") == 1, result.stderr
    assert says in result.stderr


@pytest.mark.timeout(60)
@pytest.mark.parametrize("name", [name + end for name in STATE for end in ("", ".new")])
def test_a_fifo_in_the_state_folder_makes_nobody_wait(flown: Path, tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    result = called("sitl", "--scenario", "brief.toml", "--state", tmp_path, "--out", tmp_path / "out", cwd=flown)
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "navigation.json").is_file()


@pytest.mark.timeout(60)
@pytest.mark.parametrize("name", ["report.html.new", "summary.json.new"])
def test_a_fifo_that_is_in_the_way_of_a_report_is_replaced(flown: Path, tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    assert called("report", "good", "--out", tmp_path, cwd=flown).returncode == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "summary.json"]


@pytest.mark.timeout(60)
@pytest.mark.parametrize("command", ["replay", "report", "export", "identify"])
def test_what_is_no_log_is_refused_at_once(flown: Path, tmp_path: Path, command: str) -> None:
    os.mkfifo(tmp_path / "log.mcap")
    (tmp_path / "folder").mkdir()
    (tmp_path / "device").mkdir()
    (tmp_path / "device" / "log.mcap").symlink_to("/dev/zero")
    (tmp_path / "deep" / "log.mcap").mkdir(parents=True)
    assert_refused(flown, command, tmp_path, says="log.mcap: is a FIFO, not a log")
    assert_refused(flown, command, tmp_path / "log.mcap", says="log.mcap: is a FIFO, not a log")
    assert_refused(flown, command, tmp_path / "folder", says="log.mcap: the log cannot be read (No such file")
    assert_refused(flown, command, tmp_path / "device", says="log.mcap: not a log")
    assert_refused(flown, command, tmp_path / "deep", says="log.mcap: ")
    assert_refused(flown, command, tmp_path / "none", says="none: ")


@pytest.mark.timeout(60)
@pytest.mark.parametrize(
    "words",
    [
        ("sitl", "--scenario", "brief.toml"),
        ("fly", "--bus", "udp:6"),
        ("report", "good"),
        ("export", "good"),
        ("study", "estimation", "--seeds", "0:1", "--short"),
        ("paper",),
    ],
    ids=lambda words: words[0],
)
def test_an_out_that_is_a_fifo_is_refused_before_anything_is_done(
    flown: Path, tmp_path: Path, words: tuple[str, ...]
) -> None:
    os.mkfifo(tmp_path / "out")
    assert_refused(flown, *words, "--out", tmp_path / "out", says="out")
    assert (tmp_path / "out").is_fifo()


def test_a_report_into_what_is_no_folder_is_refused_before_the_log_is_read(
    flown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "out").write_text("mine")
    monkeypatch.setattr(report, "stream", lambda _: pytest.fail("the log was read"))
    assert_refused(flown, "report", "good", "--out", tmp_path / "out", says="it is a file, not a folder")


@pytest.mark.parametrize("words", [("sitl", "--scenario", "brief.toml"), ("fly", "--bus", "udp:6"), ("report", "good")])
def test_an_out_that_is_no_folder_says_what_it_is(flown: Path, tmp_path: Path, words: tuple[str, ...]) -> None:
    (tmp_path / "out").write_text("mine")
    os.mkfifo(tmp_path / "fifo")
    assert_refused(flown, *words, "--out", tmp_path / "out", says="it is a file, not a folder")
    assert_refused(flown, *words, "--out", tmp_path / "fifo", says="it is a FIFO, not a folder")
    assert_refused(flown, *words, "--out", tmp_path / "out" / "in", says=f"({tmp_path}/out is a file, not a folder)")


@pytest.mark.timeout(60)
@pytest.mark.parametrize("words", [("sitl", "--scenario", "brief.toml"), ("report", "good"), ("fly", "--bus", "udp:6")])
def test_an_out_that_is_read_only_is_one_line(flown: Path, tmp_path: Path, words: tuple[str, ...]) -> None:
    tmp_path.chmod(0o555)
    as_anybody = ("setpriv", "--bounding-set", "-dac_override") if os.geteuid() == 0 else ()  # root may write anywhere
    command = [*as_anybody, SCRIPT, *words, "--out", tmp_path]
    done = subprocess.run(command, cwd=flown, capture_output=True, text=True, check=False, timeout=50)
    assert (done.returncode, done.stderr.count("\n"), "cannot be written" in done.stderr) == (2, 1, True), done.stderr


@pytest.mark.timeout(60)
def test_an_out_that_is_removed_in_flight_is_said_at_once_and_the_flight_summed_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    said_at: list[float] = []
    (tmp_path / "longer.toml").write_text(BRIEF.replace("duration_s = 1.0", "duration_s = 2.0"))

    def update(_: Progress, cycle: Cycle) -> None:
        if cycle.tick.k == 50:
            out.rename(tmp_path / "gone")  # at once: what keeps the state writes there meanwhile
            shutil.rmtree(tmp_path / "gone", ignore_errors=True)
        if not said_at and "was removed" in sys.stderr.getvalue():  # type: ignore[attr-defined]
            said_at.append(cycle.tick.t)

    monkeypatch.setattr(Progress, "update", update)
    result = called("sitl", "--scenario", "longer.toml", "--out", out, cwd=tmp_path)
    assert result.returncode == 2
    log = f"sternplane: {out}/log.mcap: was removed"
    assert result.stderr.splitlines() == [
        f"{log}, and will be lost; the flight goes on, and its summary comes at its end",
        f"{log} in flight, and is lost",
    ]
    assert said_at == [pytest.approx(1.01)]
    assert re.search("vehicle time +2.0 s", result.stdout)
    assert "completed" in json.loads((out / "summary.json").read_text())
    assert not (out / "log.mcap").exists()


@pytest.mark.timeout(60)
def test_two_runs_that_begin_in_the_same_moment_do_not_write_one_log(
    flown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "log.mcap").write_bytes(b"of the other")
    monkeypatch.setattr("sternplane.sitl.command.flight_folder", lambda _: tmp_path)  # it saw no log a moment ago
    assert_refused(flown, "sitl", "--scenario", "brief.toml", "--out", tmp_path, says="another flight has begun")
    assert (tmp_path / "log.mcap").read_bytes() == b"of the other"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("sitl", "--scenario", "atlantis"), "unknown scenario 'atlantis'"),
        (("plant", "--scenario", "none.toml"), "none.toml: cannot be read"),
        (("sitl", "--config", "nowhere"), "nowhere: there is no such configuration folder"),
        (("fly", "--config", "nowhere"), "nowhere: there is no such configuration folder"),
        (("sitl", "--config", "configs/udev"), "nor a shipped vehicle of that name: npsauv2, remus100, torpedo_x"),
        (("replay", "nothing"), "nothing: the log cannot be read"),
    ],
)
def test_a_name_that_is_wrong_is_said_before_kernels_are_compiled(
    flown: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], says: str
) -> None:
    def compile_kernels(_: object) -> None:
        raise AssertionError("kernels are compiled")

    monkeypatch.setattr(kernel_compile, "prepare_kernels", compile_kernels)
    assert_refused(flown, *words, says=says)
