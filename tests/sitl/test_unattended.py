"""`fly` as a service manager starts it: devices that are not there, disks that cannot be written, a second instance."""

from __future__ import annotations

import os
import signal
import socket
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from pymavlink import mavutil
from sternplane.logs.reading import read
from sternplane.logs.replay import replay

from firmware_py.adapters.storage import log_names
from firmware_py.app import build
from firmware_py.run import flight_recorder, run_folders
from firmware_py.run.fly import fly
from firmware_py.run.state_lock import LOCK_FILE, alone_with
from firmware_py.run.usage_error import UsageError
from tests.sitl.conftest import Start
from tests.sitl.test_fly import parsed


@pytest.fixture
def fly_for(bus_spec: str, monkeypatch: pytest.MonkeyPatch) -> Callable[..., object]:
    """Flies in this process until a cycle, and ends then as by SIGTERM."""
    write = flight_recorder.FlightRecorder.write

    def fly_for(cycles: int, *words: str | Path) -> object:
        def watched(self: flight_recorder.FlightRecorder, cycle: object) -> None:
            write(self, cycle)  # type: ignore[arg-type]
            if self.last is not None and self.last.tick.k == cycles:
                os.kill(os.getpid(), signal.SIGTERM)

        monkeypatch.setattr(flight_recorder.FlightRecorder, "write", watched)
        return fly(parsed("--bus", bus_spec, *words))

    return fly_for


def test_it_begins_without_any_device_tells_the_service_manager_and_what_it_waits_for(
    tmp_path: Path, fly_for: Callable, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(str(tmp_path / "notify"))
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        monkeypatch.setenv("WATCHDOG_USEC", "300000")
        monkeypatch.delenv("WATCHDOG_PID", raising=False)
        radio = f"serial:{tmp_path}/radio:57600"
        ended = fly_for(25, "--logs", tmp_path / "logs", "--dvl", tmp_path / "dvl", "--gcs", radio)
        heard = [systemd.recv(1000).decode() for _ in range(6)]
    assert ended.status == 0
    assert heard == [f"STATUS=waiting for link {radio}, dvl", "READY=1", *["WATCHDOG=1"] * 3, "STOPPING=1"]
    said = capsys.readouterr().err
    assert f"sternplane: waiting for link {radio}: No such file or directory\n" in said
    assert "sternplane: waiting for dvl: port " in said
    assert "there is no such device" in said
    assert replay(read(ended.folder / "log.mcap"), build).equal


def test_flights_are_numbered_whatever_the_clock_shows(
    tmp_path: Path, fly_for: Callable, monkeypatch: pytest.MonkeyPatch
) -> None:
    logs, names = tmp_path / "logs", []
    for stamp in ("20261123-104501", "19700101-000012", "19700101-000012"):  # its battery is empty
        monkeypatch.setattr(run_folders, "time", SimpleNamespace(strftime=lambda _form, stamp=stamp: stamp))
        names.append(run_folders.numbered_folder(logs).name)
    assert names == ["00001-20261123-104501", "00002-19700101-000012", "00003-19700101-000012"]
    assert [log_names.flight_number(name) for name in names] == [1, 2, 3]


def test_ten_thousand_flights_cost_the_start_no_second(tmp_path: Path) -> None:
    for n in range(10_000):
        (tmp_path / f"{n + 1:05d}-20260101-000000").mkdir()
    began = time.process_time()
    assert run_folders.numbered_folder(tmp_path).name.startswith("10001-")
    assert time.process_time() - began < 1.0


def test_a_disk_that_cannot_be_written_does_not_keep_it_from_flying(
    tmp_path: Path, fly_for: Callable, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wall, state = tmp_path / "wall", tmp_path / "state"
    wall.write_text("no folder")
    monkeypatch.setattr(os, "access", lambda path, _mode: path != state)  # root may write wherever it likes
    ended = fly_for(5, "--logs", wall / "logs", "--state", state, "--dvl", tmp_path / "dvl")
    said = capsys.readouterr().err
    assert "the flight goes on without a log" in said
    assert "the flight begins, and keeps nothing for the next one" in said
    assert ended.status == 1, "what was to be kept is lost, and the service manager starts it again"
    assert wall.read_text() == "no folder"


def test_killed_and_started_again_it_takes_the_next_number_and_a_second_one_is_refused(
    tmp_path: Path, bus_spec: str, start: Start
) -> None:
    words = ("fly", "--bus", bus_spec, "--dvl", tmp_path / "dvl", "--logs", "logs", "--state", "state")
    first = start(*words)
    first.until_said("waiting for dvl")
    second = start(*words)
    assert "--state state: another flight uses it" in second.communicate(60.0)[1]
    assert second.returncode == 2
    first.kill()
    third = start(*words)
    third.until_said("waiting for dvl")
    third.send_signal(signal.SIGTERM)
    third.communicate(60.0)
    assert third.returncode == 0
    folders = sorted(path.name[:5] for path in (tmp_path / "logs").iterdir())
    assert folders == ["00001", "00002"]


def test_a_second_one_touches_nothing_that_the_first_keeps(tmp_path: Path, bus_spec: str) -> None:
    (tmp_path / "fence.json").write_text("of another origin, as the second one is configured")
    with alone_with(tmp_path), pytest.raises(UsageError, match="another flight uses it"):
        fly(parsed("--bus", bus_spec, "--state", tmp_path))
    assert {path.name for path in tmp_path.iterdir()} == {"fence.json", LOCK_FILE}


@pytest.mark.parametrize(("param", "status"), [(1, 3), (2, 0)], ids=["reboot", "shutdown"])
def test_a_station_that_orders_a_reboot_has_it_started_again_and_one_that_ends_it_is_told_apart(
    tmp_path: Path, bus_spec: str, start: Start, param: int, status: int
) -> None:
    station = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255)
    try:
        link = f"udpout:127.0.0.1:{station.port.getsockname()[1]}"
        process = start("fly", "--bus", bus_spec, "--dvl", tmp_path / "dvl", "--logs", "logs", "--gcs", link)
        assert station.wait_heartbeat(timeout=60) is not None
        reboot = mavutil.mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN
        station.mav.command_long_send(station.target_system, 1, reboot, 0, param, *[0.0] * 6)
        _, said = process.communicate(60.0)
    finally:
        station.close()
    assert process.returncode == status, said
    [folder] = (tmp_path / "logs").iterdir()
    assert read(folder / "log.mcap").end["completed"] is None
