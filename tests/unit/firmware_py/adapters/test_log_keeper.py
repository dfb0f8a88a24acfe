"""Which logs are removed, in which order, and which never; the child process that does it."""

from __future__ import annotations

import errno
import os
import signal
import time
from pathlib import Path

import pytest

from firmware_py.adapters.storage import log_keeper
from firmware_py.adapters.storage.log_keeper import DiskSync, LogKeeper, remove_oldest
from firmware_py.adapters.storage.log_names import flight_number, logs_below
from firmware_py.adapters.storage.log_params import LogParams
from firmware_py.params import ParamError, load

LONG_AGO = 1_700_000_000
SIZE = 1000


def flight(root: Path, name: str, *parts: str, age: float = LONG_AGO) -> list[Path]:
    (root / name).mkdir(parents=True)
    paths = [root / name / part for part in parts]
    for path in paths:
        path.write_bytes(bytes(SIZE))
        os.utime(path, (age, age))
    return paths


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """The oldest two were flown when the clock had been set wrong, far into the future."""
    flight(tmp_path, "00009-20991231-000000", "log.mcap", "log.2.mcap", "log.10.mcap")
    flight(tmp_path, "00010-19700101-000012", "log.mcap")
    flight(tmp_path, "00011-20260101-000000", "log.mcap")
    return tmp_path


def left(root: Path) -> list[str]:
    return [str(log.path.relative_to(root))[:5] + log.path.name[3:-5] for log in logs_below(root)]


def test_the_oldest_go_first_by_their_numbers_whatever_the_clock_said(root: Path) -> None:
    assert left(root) == ["00009", "00009.2", "00009.10", "00010", "00011"]
    removed = remove_oldest(root, [], total=3 * SIZE, free=0)
    assert [log.part for log in removed] == [1, 2]
    assert left(root) == ["00009.10", "00010", "00011"]


def test_a_flight_whose_logs_are_gone_leaves_no_folder_unless_it_holds_something_else(root: Path) -> None:
    (root / "00010-19700101-000012" / "state").mkdir()
    remove_oldest(root, [], total=SIZE, free=0)
    assert {path.name[:5] for path in root.iterdir()} == {"00010", "00011"}


def test_what_is_written_or_was_a_moment_ago_stays_however_little_room_there_is(root: Path) -> None:
    other = flight(root, "00012-20260101-000000", "log.mcap", age=time.time())
    own = root / "00011-20260101-000000" / "log.mcap"
    remove_oldest(root, [own], total=0, free=1e30)
    assert {log.path for log in logs_below(root)} == {own, *other}


def test_what_is_no_flights_log_is_never_touched(root: Path) -> None:
    foreign = [*flight(root, "20260101-000000", "log.mcap"), *flight(root, "00005-20260101-000000", "log.02.mcap")]
    (root / "log.mcap").write_bytes(b"x")
    (root / "00001-link").symlink_to(root / "20260101-000000")
    remove_oldest(root, [], total=0, free=0)
    assert logs_below(root) == []
    assert all(path.exists() for path in (*foreign, root / "log.mcap"))


def test_nothing_is_removed_while_there_is_room(root: Path) -> None:
    assert remove_oldest(root, [], total=5 * SIZE, free=0) == []
    assert len(left(root)) == 5


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("00017-19700101-000012", 17),
        ("123456-20260101-000000", 123456),
        ("0017-20260101-000000", 0),
        ("20260101-000000", 0),
        ("latest", 0),
    ],
)
def test_the_number_of_a_flights_folder(name: str, number: int) -> None:
    assert flight_number(name) == number


def first_said(keeper: LogKeeper) -> list[str]:
    """Wait until it says something."""
    said: list[str] = []
    end = time.monotonic() + 30.0
    while not said and time.monotonic() < end:
        said += keeper.said()
        time.sleep(0.01)
    return said


def test_the_child_makes_room_says_so_and_ends_with_its_flight(root: Path) -> None:
    own = root / "00011-20260101-000000" / "log.mcap"
    keeper = LogKeeper(root, LogParams(total_size=2.0 * SIZE, part_size=SIZE, free_size=0.0))
    keeper.written(own)
    said = first_said(keeper)
    assert said == [f"3 old logs removed to make room, up to {root}/00009-20991231-000000/log.10.mcap"]
    assert left(root) == ["00010", "00011"]
    keeper.close()
    keeper.close()


def test_a_single_log_that_was_removed_is_told_as_one(root: Path) -> None:
    own = root / "00011-20260101-000000" / "log.mcap"
    keeper = LogKeeper(root, LogParams(total_size=4.0 * SIZE, part_size=SIZE, free_size=0.0))
    keeper.written(own)
    said = first_said(keeper)
    keeper.close()
    assert said[0].startswith("1 old log removed to make room, up to ")


def test_a_log_that_is_gone_is_told_and_the_child_goes_on(tmp_path: Path) -> None:
    keeper = LogKeeper(None, LogParams())
    keeper.written(tmp_path / "gone.mcap")
    said = first_said(keeper)
    assert said == [f"{tmp_path}/gone.mcap: cannot be brought to the disk (No such file or directory)"]
    keeper.close()


def test_a_log_that_cannot_be_brought_to_the_disk_is_tried_again_later_and_no_other_waits_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bad, good, gone = tmp_path / "log.mcap", tmp_path / "log.2.mcap", tmp_path / "log.3.mcap"
    done: list[tuple[str, bool]] = []
    broken = [True]

    def to_disk(path: Path, begun: bool) -> None:
        if path == bad and broken[0]:
            raise OSError(errno.EIO, "Input/output error")
        if path == gone:
            raise FileNotFoundError(errno.ENOENT, "No such file or directory")
        done.append((path.name, begun))

    monkeypatch.setattr(log_keeper, "_to_disk", to_disk)
    said: list[str] = []
    logs = DiskSync(said.append)
    logs.begin(bad)
    logs.begin(good)
    for t in (0.0, 2.0):
        logs.sync(t)
    assert said == [f"{bad}: cannot be brought to the disk (Input/output error)"]
    assert done == [("log.2.mcap", True), ("log.2.mcap", False)]
    assert logs.written == [bad, good]
    broken[0] = False
    logs.sync(61.0)
    assert done[2:] == [("log.mcap", True), ("log.2.mcap", False)]
    logs.begin(gone)
    logs.sync(62.0)
    assert logs.written == [good]
    assert len(said) == 2


def test_a_keeper_that_has_ended_is_told_once(tmp_path: Path) -> None:
    keeper = LogKeeper(None, LogParams())
    child = keeper._child._process.pid
    os.kill(child, signal.SIGKILL)
    os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT)
    keeper.written(tmp_path / "log.mcap")
    assert ["has ended" in sentence for sentence in keeper.said()] == [True]
    assert keeper.said() == []
    keeper.close()


def test_a_disk_that_does_not_say_how_much_is_free_does_not_end_the_child(
    root: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def broken(_: Path) -> None:
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "statvfs", broken)
    log_keeper._bound(root, [], 1e9, 1.0)
    assert capfd.readouterr().out == f"old logs below {root} cannot be removed (Input/output error)\n"


def test_bounds_without_room_for_two_parts_are_refused() -> None:
    with pytest.raises(ParamError, match="total_size_mb = 900: must hold two parts, of part_size_mb = 500"):
        load(LogParams, {"total_size_mb": 900.0, "part_size_mb": 500.0}, "io.toml: log")
