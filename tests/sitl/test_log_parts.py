"""A log in parts: no cycle is lost between two, and each replays to the bit without the others."""

from __future__ import annotations

import dataclasses
import errno
import json
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from sternplane.logs.reading import Log, find, read
from sternplane.logs.replay import replay
from sternplane.logs.streaming import stream
from sternplane.report.report import write_report_of_file

from firmware_py.adapters.storage import parted_log
from firmware_py.adapters.storage.log_names import of_part, part_file, parts_in
from firmware_py.adapters.storage.log_params import LogParams
from firmware_py.adapters.storage.parted_log import PartedLog
from firmware_py.adapters.storage.recorder import LogError, LogWriter
from firmware_py.app import build
from firmware_py.records.cycle import Cycle
from firmware_py.run import flight_recorder
from firmware_py.run.flight_recorder import FlightRecorder
from tests.shared_flights import Flights

LEARNS = """
description = "Five seconds under water, with a manoeuvre that moves all fins."
duration_s = 5.0
completes = "time"
[start]
depth_m = 5.0
u_m_s = 1.8
[[orders]]
t_s = 0.1
arming = "arm"
[[orders]]
t_s = 0.2
mode = "hold"
depth_m = 9.0
heading_deg = 40.0
"""
NOBODY: Any = SimpleNamespace(written=lambda _path: None)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return Flights(tmp_path_factory.mktemp("parts") / "flights")(LEARNS)[1]


def flown_again(whole: Log, autopilot: Any) -> Iterator[Cycle]:
    """Yield each cycle as the autopilot computes it again; a log may freeze that in between."""
    for cycle in whole.cycles:
        yield autopilot.step(cycle.tick, cycle.frame, cycle.order)


def parted(whole: Log, folder: Path, params: LogParams) -> tuple[PartedLog, Any]:
    autopilot = build(whole.header["configuration"])
    return PartedLog(folder, whole.header, params, autopilot.freeze, NOBODY), autopilot


def small(**sizes: float) -> LogParams:
    """Return smaller parts than a file may ask for."""
    params = LogParams()
    for name, value in sizes.items():
        object.__setattr__(params, name, value)
    return params


@pytest.mark.parametrize("params", [small(part_time=1.5), small(part_size=40e3)], ids=["by time", "by size"])
def test_no_cycle_is_lost_and_each_part_replays_by_itself(whole: Log, tmp_path: Path, params: LogParams) -> None:
    log, autopilot = parted(whole, tmp_path / "flight", params)
    log.begin()
    for cycle in flown_again(whole, autopilot):
        log.write(cycle)
    log.close({"reason": "over"})
    paths = [path for _, path in parts_in(tmp_path / "flight")]
    assert len(paths) >= 3
    parts = [read(path) for path in paths]
    assert all(part.complete for part in parts)
    assert [message for part in parts for message in part.cycle_bytes] == whole.cycle_bytes
    ends = [part.end["reason"] for part in parts]
    assert ends == [*(f"goes on in {path.name}" for path in paths[1:]), "over"]
    for path in reversed(paths):
        result = replay(stream(path), build)
        assert result.equal, f"{path}: {result}"
        assert result.cycles > 0
        path.unlink()


def test_a_part_whose_writer_was_killed_replays_up_to_there(whole: Log, tmp_path: Path) -> None:
    log, autopilot = parted(whole, tmp_path, small(part_time=2.0))
    log.begin()
    for cycle in flown_again(whole, autopilot):
        log.write(cycle)
    kept = log.path.read_bytes()  # never closed
    assert log.path.name == "log.3.mcap"
    log.path.write_bytes(kept[:-100])
    result = replay(read(log.path), build)
    assert result.equal
    assert "cut off" in result.cautions[0]


def test_a_part_without_what_was_remembered_is_readable_and_refuses_to_be_replayed(whole: Log, tmp_path: Path) -> None:
    log = PartedLog(tmp_path, whole.header, small(part_time=1.0), lambda: lambda: None, NOBODY)
    log.begin()
    for cycle in whole.cycles:
        log.write(cycle)
    log.close({})
    part = read(tmp_path / "log.2.mcap")
    assert part.count == 100
    with pytest.raises(LogError, match="begins in flight, without what was remembered then"):
        replay(part, build)
    (tmp_path / "log.mcap").unlink()
    assert find(tmp_path) == tmp_path / "log.2.mcap"


def test_the_report_of_a_part_leaves_that_of_the_first_as_it_is(whole: Log, tmp_path: Path) -> None:
    log, autopilot = parted(whole, tmp_path, small(part_time=2.0))
    log.begin()
    for cycle in flown_again(whole, autopilot):
        log.write(cycle)
    log.close({})
    for part in (1, 2):
        write_report_of_file(tmp_path / part_file(part), tmp_path)
    times = [json.loads((tmp_path / of_part("summary.json", part)).read_text())["vehicle_time_s"] for part in (1, 2)]
    assert times == pytest.approx([2.2, 4.2], abs=0.3), "each of its own part"
    assert {"report.html", "report.2.html"} < {path.name for path in tmp_path.iterdir()}


def test_a_memory_that_was_tampered_with_is_refused(whole: Log) -> None:
    with pytest.raises(LogError, match=r"cannot be read .*; use revision"):
        replay(dataclasses.replace(whole, memory=b"cos\nsystem\n(S'true'\ntR."), build)


def test_a_part_that_is_there_is_never_overwritten(whole: Log, tmp_path: Path) -> None:
    (tmp_path / "log.2.mcap").write_text("precious")
    log, autopilot = parted(whole, tmp_path, small(part_time=1.0))
    log.begin()
    cycles = flown_again(whole, autopilot)
    for _ in range(100):
        log.write(next(cycles))
    with pytest.raises(LogError, match=r"log\.2\.mcap"):
        log.write(next(cycles))
    assert (tmp_path / "log.2.mcap").read_text() == "precious"


def test_a_log_that_could_not_be_written_for_a_while_goes_on_and_replays(
    whole: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flight_recorder, "_AGAIN_NS", 1_000_000_000)
    folder, told = tmp_path / "flight", list[str]()
    folder.write_text("what is in the way")
    log, autopilot = parted(whole, folder, LogParams())
    recorder = FlightRecorder(log, tell=told.append)
    recorder.begin()
    for cycle in flown_again(whole, autopilot):
        recorder.write(cycle)
        if cycle.tick.k == 150:
            folder.unlink()
    assert recorder.close({"reason": "over"})
    assert len(told) == 2
    assert told[0].endswith("the flight goes on without a log")
    assert told[1] == f"the log goes on in {folder}/log.mcap"
    part = read(folder / "log.mcap")
    assert [cycle.tick.k for cycle in part.cycles] == list(range(201, 500))
    assert replay(part, build).equal


def test_a_disk_that_is_full_costs_what_comes_until_there_is_room(
    whole: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flight_recorder, "_AGAIN_NS", 1_000_000_000)
    full = [False]

    class Filling(LogWriter):
        def write(self, topic: str, t_ns: int, record: Any) -> None:
            if full[0]:
                raise self._failed(OSError(28, "No space left on device"))
            super().write(topic, t_ns, record)

    monkeypatch.setattr(parted_log, "LogWriter", Filling)
    log, autopilot = parted(whole, tmp_path, LogParams())
    recorder = FlightRecorder(log, tell=lambda _sentence: None)
    recorder.begin()
    for cycle in flown_again(whole, autopilot):
        full[0] = 120 <= cycle.tick.k < 150
        recorder.write(cycle)
    assert recorder.close({"reason": "over"})
    first, second = read(tmp_path / "log.mcap"), read(tmp_path / "log.2.mcap")
    assert [first.count, second.count] == [100, 500 - 221], "up to its last whole chunk; a second later"
    assert replay(first, build).equal
    assert replay(second, build).equal


def test_a_disk_that_turns_read_only_in_a_turn_costs_the_log_and_not_the_flight(
    whole: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next part is begun already then; of a read-only file system even a missing name cannot be removed."""
    monkeypatch.setattr(flight_recorder, "_AGAIN_NS", 1_000_000_000)
    read_only = OSError(errno.EROFS, "Read-only file system")
    turned = [False]

    class ReadOnly(LogWriter):
        def __init__(self, path: str | Path, *args: Any, **more: Any) -> None:
            if turned[0]:
                raise LogError(f"{path}: {read_only.strerror}")
            super().__init__(path, *args, **more)

        def write(self, topic: str, t_ns: int, record: Any) -> None:
            if turned[0]:
                raise self._failed(read_only)
            super().write(topic, t_ns, record)

    def unlink(path: Path, missing_ok: bool = False) -> None:
        raise read_only

    monkeypatch.setattr(parted_log, "LogWriter", ReadOnly)
    log, autopilot = parted(whole, tmp_path / "flight", small(part_time=1.0))
    told = list[str]()
    recorder = FlightRecorder(log, tell=told.append)
    recorder.begin()
    for cycle in flown_again(whole, autopilot):
        if cycle.tick.k == 110:
            turned[0] = True
            monkeypatch.setattr(Path, "unlink", unlink)
        recorder.write(cycle)
    assert not recorder.close({"reason": "over"})
    assert recorder.last is not None
    assert recorder.last.tick.k == 499
    assert len(told) == 1
    assert told[0].endswith("the flight goes on without a log")


def test_a_disk_that_answers_nothing_is_a_log_that_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dead(_: Path) -> bool:
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(Path, "is_fifo", dead)
    with pytest.raises(LogError, match=r"cannot be written \(Input/output error\)"):
        LogWriter(tmp_path / "log.mcap", {})
