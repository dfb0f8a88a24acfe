"""One flight of the vehicle alone, in this process: what it leaves, what it never overwrites, what it refuses."""

from __future__ import annotations

import argparse
import os
import pty
import shutil
import tty
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from sternplane.cli.fly import command
from sternplane.logs.reading import read

from firmware_py.__main__ import main
from firmware_py.adapters.storage.recorder import LogError, LogWriter
from firmware_py.params import ParamError
from firmware_py.run import flight_recorder, kept_navigation, options, over_can, run_folders, terminal
from firmware_py.run import fly as fly_module
from firmware_py.run.fly import FlightResult, fly
from firmware_py.run.usage_error import UsageError

Fly = Callable[..., FlightResult]


def parsed(*words: str | Path) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    options.add_fly(parser)
    parser.add_argument("--report", action="store_true")
    return parser.parse_args([str(word) for word in words])


@pytest.fixture
def dvl() -> Iterator[str]:
    """A serial line on which nobody speaks."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    yield os.ttyname(theirs)
    os.close(ours)
    os.close(theirs)


@pytest.fixture
def until(monkeypatch: pytest.MonkeyPatch) -> Callable[[int, Callable[[], None]], None]:
    """Arranges that something happens at a cycle, and that the flight then ends as by Ctrl-C."""

    write = flight_recorder.FlightRecorder.write

    def until(cycles: int, happens: Callable[[], None]) -> None:
        def watched(self: flight_recorder.FlightRecorder, cycle: object) -> None:
            write(self, cycle)  # type: ignore[arg-type]
            if self.cycles == cycles:
                happens()
                os.kill(os.getpid(), 2)

        monkeypatch.setattr(flight_recorder.FlightRecorder, "write", watched)

    return until


@pytest.fixture
def flown(dvl: str, until: Callable, bus_spec: str) -> Fly:
    """Flies for ten cycles."""

    def flown(*words: str | Path, happens: Callable[[], None] = lambda: None) -> FlightResult:
        until(10, happens)
        return fly(parsed("--bus", bus_spec, "--dvl", dvl, *words))

    return flown


def test_a_log_that_is_there_is_never_overwritten(
    tmp_path: Path, flown: Fly, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    first = flown("--out", out)
    assert (first.status, first.folder) == (0, out)
    before = (out / "log.mcap").read_bytes()
    second = flown("--out", out)
    assert second.folder.parent == out
    assert (out / "log.mcap").read_bytes() == before
    assert read(second.folder / "log.mcap").end["reason"].startswith("ended by a person")
    assert str(second.folder) in capsys.readouterr().err
    left = {path.name for path in second.folder.iterdir()}
    assert left == {"log.mcap", "state"}, "no report unless it is asked for"


def test_a_report_is_made_when_it_is_asked_for(tmp_path: Path, dvl: str, until: Callable, bus_spec: str) -> None:
    until(10, lambda: None)
    assert command(parsed("--bus", bus_spec, "--dvl", dvl, "--out", tmp_path, "--report")) == 0
    assert (tmp_path / "report.html").exists()
    assert (tmp_path / "summary.json").exists()


def test_a_folder_that_is_removed_in_flight_is_said_in_one_line(
    tmp_path: Path, flown: Fly, capsys: pytest.CaptureFixture[str]
) -> None:
    out, state = tmp_path / "out", tmp_path / "state"
    ended = flown("--out", out, "--state", state, happens=lambda: shutil.rmtree(out))
    assert ended.status == 1
    complaints = [line for line in capsys.readouterr().err.splitlines() if line.startswith("sternplane: ")]
    assert complaints == [f"sternplane: {out}/log.mcap was removed in flight, and is lost"]
    assert not out.exists()
    assert (state / "navigation.json").exists()


def test_where_the_folder_was_removed_in_flight_no_report_is_made(
    tmp_path: Path, dvl: str, until: Callable, bus_spec: str
) -> None:
    out = tmp_path / "out"
    until(10, lambda: shutil.rmtree(out))
    assert command(parsed("--bus", bus_spec, "--dvl", dvl, "--out", out, "--report")) == 1
    assert not out.exists()


def test_a_folder_that_cannot_be_written_is_refused_before_the_flight(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path)  # root may write wherever it likes
    with pytest.raises(UsageError, match=r"--out .*: cannot be written; choose another folder"):
        run_folders.flight_folder(tmp_path)


def test_two_flights_in_a_second_have_folders_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "log.mcap").touch()
    assert len({run_folders.flight_folder(tmp_path) for _ in range(3)}) == 3


def test_a_folder_with_the_name_of_the_summary_does_not_cost_the_summary_of_a_flight(tmp_path: Path) -> None:
    (tmp_path / "summary.json").mkdir()
    folder = run_folders.flight_folder(tmp_path)
    assert folder.parent == tmp_path
    assert not list(folder.iterdir())


def test_a_log_that_another_flight_began_in_the_same_second_is_not_overwritten(
    tmp_path: Path, bus_spec: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def taken(out: Path) -> Path:
        folder = run_folders.flight_folder(out)
        (folder / "log.mcap").write_text("another flight's")
        return folder

    monkeypatch.setattr(fly_module, "flight_folder", taken)
    with pytest.raises(LogError, match=r"log\.mcap: another flight has begun to write it; choose another folder$"):
        fly(parsed("--bus", bus_spec, "--out", tmp_path))
    assert (tmp_path / "log.mcap").read_text() == "another flight's"


@pytest.mark.parametrize("name", ["parameters.toml", "mission.json", "signing", "navigation.json"])
def test_the_state_of_an_earlier_run_that_nobody_named_is_not_touched(tmp_path: Path, bus_spec: str, name: str) -> None:
    path = tmp_path / "state" / name
    path.parent.mkdir()
    path.write_text("precious")
    wanted = f"^{path} is of an earlier run; use it with --state {path.parent}, or choose another --out$"
    with pytest.raises(UsageError, match=wanted):
        fly(parsed("--bus", bus_spec, "--out", tmp_path))
    assert path.read_text() == "precious"
    assert not (tmp_path / "log.mcap").exists()


def test_a_fifo_in_a_logs_place_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    os.mkfifo(path)
    with pytest.raises(LogError, match="is a FIFO"):
        LogWriter(path, {})
    with pytest.raises(LogError, match="is a FIFO"):
        read(path)
    assert run_folders.flight_folder(tmp_path) != tmp_path


def test_a_vehicle_starts_without_what_an_earlier_run_left_broken_and_says_so(
    tmp_path: Path, flown: Fly, capsys: pytest.CaptureFixture[str]
) -> None:
    state = tmp_path / "state"
    state.mkdir()
    (state / "navigation.json").write_text("{")
    (state / "parameters.toml").write_text("[safety]\ndepth_max_m = -3.0\n")
    ended = flown("--out", tmp_path / "out", "--state", state)
    assert ended.status == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "set aside as" in line]
    assert ["navigation.json.corrupt-1: " in said[0], "parameters.toml.corrupt-1: " in said[1]] == [True, True]
    log = read(tmp_path / "out" / "log.mcap")
    assert [f"sternplane: {note}" for note in log.header["notes"]] == said
    assert log.header["configuration"]["kept"] == {}
    assert kept_navigation.load_navigation(state)["age_s"] == 0.0


def test_a_terminal_that_is_gone_does_not_end_a_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as gone:
        monkeypatch.setattr("sys.stderr", gone)
        for _ in range(3):
            terminal.say("nobody reads this")
        monkeypatch.undo()
        os.dup2(os.open(os.devnull, os.O_WRONLY), gone.fileno())  # what is buffered goes nowhere


def test_the_vehicles_own_program_takes_the_same_options_and_refuses_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(over_can, "run", None)  # it never comes so far
    assert main(["--bus", "virtual", "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == (
        "sternplane: a virtual bus ends at its process; give --bus udp:N (N from 0 to 9), socketcan:IFACE or "
        "python-can:INTERFACE:CHANNEL@BITRATE\n"
    )
    assert not (tmp_path / "out").exists()


def test_what_is_set_stands_in_the_log_of_the_vehicle_alone(tmp_path: Path, flown: Fly) -> None:
    flown("--out", tmp_path / "out", "--set", "autopilot.depth_max=20", "--set", "io.latency.ahrs=0.02")
    header = read(tmp_path / "out" / "log.mcap").header
    assert header["settings"] == {"autopilot.safety.depth_max_m": 20, "io.latency.ahrs_s": 0.02}
    assert header["configuration"]["autopilot"]["safety"]["depth_max_m"] == 20
    with pytest.raises(ParamError, match="'truth' is no file"):
        flown("--out", tmp_path / "none", "--set", "truth.M_q=1")
