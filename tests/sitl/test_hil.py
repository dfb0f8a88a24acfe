"""Vehicle and plant as two processes over the simulator interface: a mission, two runs alike, either killed."""

from __future__ import annotations

import shutil
import signal
import socket
from collections.abc import Callable
from pathlib import Path

import pytest
from sternplane.cli.main import main
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.logs.summary import summarise

from firmware_py.app import build
from tests.command import called
from tests.dive import DIVE
from tests.shared_flights import Flights
from tests.sitl.conftest import Start
from tests.straight_run import under_way

ROOT = Path(__file__).resolve().parents[2]


def free_link() -> str:
    """The interface, on a port that is free."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"mavlink-hil:127.0.0.1:{server.getsockname()[1]}"


@pytest.fixture
def link() -> str:
    return free_link()


Refused = Callable[..., str]


@pytest.fixture
def refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Refused:
    """The line with which `sternplane ...` refuses; it leaves nothing behind."""
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")

    def refused(*arguments: str) -> str:
        assert main(arguments) == 2
        error = capfd.readouterr().err
        assert error.startswith("sternplane: ")
        assert error.count("\n") == 1
        assert not list(Path().iterdir())
        return error

    return refused


FLIES = "0.00 s  disarmed"
"""What the vehicle says in its first cycle."""


CORNER = under_way(
    120.0,
    6.0,
    '[[orders]]\nt_s = 0.5\narming = "arm"\n[[orders]]\nt_s = 1.0\nmode = "mission"\n',
    *(
        f"[[waypoints]]\nx_m = {x}\ny_m = {y}\ndepth_m = {z}\nspeed_m_s = 1.8\n"
        for x, y, z in ((50, 0, 6), (80, 35, 9))
    ),
    completes="surfaced",
    current=(0.06, 0.08),
)
"""Two legs, one of them down, a corner between them, and up."""


def test_a_mission_is_tracked_as_over_can(flown: Flights, tmp_path: Path, link: str) -> None:
    seed = 2
    scenario = tmp_path / "corner.toml"
    scenario.write_text(CORNER)
    words = ("--scenario", scenario, "--link", link, "--seed", str(seed), "--out", "hil")
    result = called("sitl", *words, cwd=tmp_path)
    assert result.returncode == 0, result.stderr + result.stdout
    log = read(tmp_path / "hil" / "log.mcap")
    hil = summarise(log)
    outcome, over_can = flown(CORNER, seed)
    can = summarise(over_can)
    assert outcome.completed
    assert hil["waypoints_passed"] == can["waypoints_passed"] == 2
    assert hil["against"] == "truth"
    # The attitude has no error over this link, and the velocity half a cm/s: it may be better than over CAN, not worse.
    assert hil["depth_tracking_error_rms_m"] < min(0.05, 1.1 * can["depth_tracking_error_rms_m"])
    assert hil["path_error_rms_m"] < min(2.0, 1.1 * can["path_error_rms_m"])
    assert hil["path_error_rms_m"] > 0.5 * can["path_error_rms_m"]  # corners are cut alike
    assert hil["heading_tracking_error_rms_deg"] < min(1.0, 1.1 * can["heading_tracking_error_rms_deg"])
    assert abs(hil["vehicle_time_s"] - can["vehicle_time_s"]) < 3.0
    last = list(log.cycles)[-1]
    assert not any(fin.ok for fin in last.frame.fins)  # nothing reports them, and it flew


def over_hil(folder: Path, link: str, duration: float, pace: str = "max") -> Log:
    """The log of a dive of so many seconds, in eddies."""
    scenario = folder / "dive.toml"
    scenario.write_text(DIVE.replace("12.0", f"{duration}") + "[environment]\nturbulence_m_s = 0.03\n")
    result = called("sitl", "--scenario", scenario, "--link", link, "--pace", pace, "--out", "run", cwd=folder)
    assert result.returncode == 0, result.stderr + result.stdout
    return read(folder / "run" / "log.mcap")


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Log:
    """A dive of 12 s."""
    return over_hil(tmp_path_factory.mktemp("first"), free_link(), 12.0)


def test_two_runs_give_the_same_bytes_and_so_does_the_replay(first: Log, tmp_path: Path, link: str) -> None:
    second = over_hil(tmp_path, link, 12.0)
    assert len(first.cycle_bytes) == 1200
    assert first.cycle_bytes == second.cycle_bytes
    assert first.topics["/truth"].messages == second.topics["/truth"].messages
    compared = replay(first, build)
    assert compared.equal, str(compared)


def test_in_real_time_the_plant_keeps_the_time_and_the_vehicle_follows(first: Log, tmp_path: Path, link: str) -> None:
    slow = over_hil(tmp_path, link, 3.0, "realtime")
    assert slow.end["wall_s"] > 2.9
    assert len(slow.cycle_bytes) == 300
    assert slow.cycle_bytes == first.cycle_bytes[:300]


def test_a_killed_plant_ends_the_vehicle_with_its_name_and_a_whole_log(tmp_path: Path, link: str, start: Start) -> None:
    plant = start("plant", "--link", link)
    vehicle = start("fly", "--link", link, "--out", "vehicle")
    vehicle.until_said(FLIES)
    plant.kill()
    out, err = vehicle.communicate(timeout=20)
    assert vehicle.returncode == 1, out + err
    assert "the plant has closed the connection, at tick" in err
    log = read(tmp_path / "vehicle" / "log.mcap")
    assert log.complete
    assert "the plant has closed the connection" in log.end["reason"]


def test_a_plant_that_hangs_ends_the_vehicle_after_four_seconds(link: str, start: Start) -> None:
    plant = start("plant", "--link", link)
    vehicle = start("fly", "--link", link)
    vehicle.until_said(FLIES)
    plant.send_signal(signal.SIGSTOP)
    out, err = vehicle.communicate(timeout=20)
    assert vehicle.returncode == 1, out + err
    assert "the plant has been silent for 4 s, at tick" in err


def test_a_killed_vehicle_ends_the_plant_with_its_name(link: str, start: Start) -> None:
    plant = start("plant", "--link", link)
    vehicle = start("fly", "--link", link)
    vehicle.until_said(FLIES)
    vehicle.kill()
    _, err = plant.communicate(timeout=20)
    assert plant.returncode == 1, err
    assert "the vehicle has closed the connection, at tick" in err


@pytest.mark.parametrize("ended", ["plant", "fly"])
def test_ctrl_c_on_either_side_ends_both_well(tmp_path: Path, link: str, start: Start, ended: str) -> None:
    plant = start("plant", "--link", link)
    vehicle = start("fly", "--link", link, "--out", "vehicle")
    vehicle.until_said(FLIES)
    (plant if ended == "plant" else vehicle).send_signal(signal.SIGINT)
    out, err = vehicle.communicate(timeout=60)
    _, words = plant.communicate(timeout=20)
    assert (vehicle.returncode, plant.returncode) == (0, 0), out + err + words
    assert ("interrupted" if ended == "plant" else "the vehicle has ended") in words
    by = "ended with the plant's time" if ended == "plant" else "ended by a person"
    assert read(tmp_path / "vehicle" / "log.mcap").end["reason"].startswith(by)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("sitl", "--link", "hil"), "write can or mavlink-hil[:HOST:PORT]"),
        (("sitl", "--link", "mavlink-hil", "--bus", "udp:6"), "leave --bus away"),
        (("sitl", "--link", "mavlink-hil", "--fault", "off:dvl@5"), "mavlink-hil has no dvl"),
        (("fly", "--link", "mavlink-hil", "--bus", "udp:6"), "has no bus"),
        (("fly", "--link", "mavlink-hil", "--pace", "realtime"), "the plant's pace"),
        (("fly", "--link", "mavlink-hil:no such host:1"), "there is no host 'no such host'"),
        (("plant", "--link", "mavlink-hil", "--dvl", "x"), "leave --bus and --dvl away"),
    ],
)
def test_what_does_not_go_with_the_link_is_one_line(refused: Refused, arguments: tuple[str, ...], words: str) -> None:
    assert words in refused(*arguments)


@pytest.mark.parametrize("command", ["sitl", "plant"])
def test_a_port_in_use_is_refused_in_one_line(refused: Refused, command: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        assert "in use" in refused(command, "--link", f"mavlink-hil:127.0.0.1:{server.getsockname()[1]}")


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("travel_deg = 23.0", "travel_deg = 30.0", "travel_deg"),
        ("n_max_rpm = 1000.0", "n_max_rpm = 900.0", "n_max_rpm"),
    ],
)
def test_another_full_scale_is_refused(refused: Refused, tmp_path: Path, old: str, new: str, key: str) -> None:
    config = Path(shutil.copytree(ROOT / "configs" / "npsauv2", tmp_path / "config"))
    sensors = config / "sensors.toml"
    sensors.write_text(sensors.read_text().replace(old, new))
    error = refused("sitl", "--config", str(config), "--link", "mavlink-hil")
    assert key in error
    assert "vehicle.toml" in error
