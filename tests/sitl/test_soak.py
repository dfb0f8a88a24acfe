"""The tool that flies io files in real time, without its flights: their course, their judgement, what it refuses."""

from __future__ import annotations

import itertools
import json
import math
import os
import shutil
import socket
from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.replay import Difference, ReplayResult
from sternplane.logs.truth_beside import TRUTH_FILE
from sternplane.soak import __main__ as soak
from sternplane.soak import judgement
from sternplane.soak.course import SPEED, configuration, course
from sternplane.soak.flight import Flown
from sternplane.soak.judgement import judge

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from tests.shared_flights import Flights
from tests.straight_run import mission, under_way

DIVE = under_way(60.0, 2.0, mission([(10.0, 2.0), (25.0, 4.0)]), completes="surfaced")


@pytest.mark.parametrize("seconds", [20.0, 60.0, 255.0, 600.0, 3600.0])
def test_a_course_is_as_long_as_wanted_and_turns_about_nowhere(seconds: float) -> None:
    found = course(seconds)
    legs = [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise([(0.0, 0.0), *[one[:2] for one in found]])]
    assert sum(math.hypot(*leg) for leg in legs) == pytest.approx(seconds * SPEED, abs=10.0)
    assert min(math.hypot(*leg) for leg in legs) >= 10.0
    turns = np.diff(np.unwrap([math.atan2(y, x) for x, y in legs]))
    assert np.all(np.abs(turns) < math.radians(110.0)), np.degrees(turns)
    assert all(5.0 <= one.z <= 10.0 and one.u == SPEED for one in found)


@pytest.mark.parametrize("vehicle", ["npsauv2", "remus100", "torpedo_x"])
def test_the_vehicle_of_a_soak_is_the_demonstrations_and_knows_its_course(tmp_path: Path, vehicle: str) -> None:
    made = configuration(configs() / vehicle / "io_sitl.toml", tmp_path, 600.0)
    believed, shipped = (config_files.read_configuration(one)["vehicle"] for one in (made, configs() / vehicle))
    assert believed["coefficients"]["M_q"] == pytest.approx(0.6 * shipped["coefficients"]["M_q"])
    assert len(config_files.read_mission(made)["waypoints"]) == len(course(600.0))


@pytest.fixture
def ended(flown: Flights, tmp_path_factory: pytest.TempPathFactory) -> Flown:
    """A flight whose log and truth lie where two processes leave them."""
    _, log = flown(DIVE)
    folder = tmp_path_factory.mktemp("ended")
    for name in ("log.mcap", TRUTH_FILE):
        shutil.copy(log.path, folder / name)
    return Flown(folder, folder, 0.0, "")


def test_a_flight_is_judged_by_the_truth_of_its_time(ended: Flown, monkeypatch: pytest.MonkeyPatch) -> None:
    found = judge(ended)
    assert found["wrong"] == []
    assert (found["completed"], found["replay_equal"], found["waypoints"]) == (True, True, [2, 2])
    assert found["path_rms_m"] < 2.0
    monkeypatch.setattr(judgement, "replay", lambda *_: ReplayResult(1, 1, Difference(7, "a.b", 1.0, 2.0), ()))
    killed = "the plant has ended: killed"
    odd = judge(ended._replace(ahead=6.0, why=killed))  # as if it had been elsewhere
    assert odd["wrong"][0] == killed
    assert any(text.startswith("depth off its reference, RMS: ") for text in odd["wrong"]), odd
    assert odd["wrong"][-1] == "1 of 1 cycles differ, first at tick 7: a.b was 1.0 and is now 2.0"


def test_a_file_that_cannot_be_flown_is_counted_as_not_flown_with_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = Path(shutil.copytree(configs() / "npsauv2", tmp_path / "boat"))
    (config / "io_odd.toml").write_text('[can]\nbuss = "udp:1"\n')
    assert soak.main([str(config / "io_odd.toml"), "--seconds", "30", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)["boat/io_odd.toml"]
    assert found["flown"] is False
    assert "buss" in found["wrong"][0]
    assert soak.main([str(config / "io_odd.toml"), "--seconds", "30"]) == 1
    said = capsys.readouterr().out
    assert "boat/io_odd  not" in said
    assert "0 of 1 io files flew within the limits" in said


def test_of_the_folder_of_an_io_file_the_configuration_alone_is_taken(tmp_path: Path) -> None:
    boat, flight = tmp_path / "boat", tmp_path / "flight"
    shutil.copytree(configs() / "npsauv2", boat)
    flight.mkdir()
    (boat / "logs").mkdir()
    (boat / "logs" / "log.mcap").write_bytes(b"1")
    (boat / "video.mp4").write_bytes(b"1")
    os.mkfifo(boat / "pipe")
    os.mkfifo(boat / "pipe.toml")
    (boat / "gone.toml").symlink_to("nowhere")
    (boat / "io_boat.txt").write_text((boat / "io_sitl.toml").read_text())
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(boat / "socket"))
        made = configuration(boat / "io_boat.txt", flight, 60.0)
    shipped = {file.name for file in (configs() / "npsauv2").glob("*.toml")}
    assert {file.name for file in made.iterdir()} == {*shipped, "io_boat.txt", "mission.toml", "vehicle.toml"}


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (("--seconds", "5"), "--seconds must be 20 to 20000"),
        (("nowhere.toml",), "nowhere.toml: there is no such io file"),
        (("--jobs", "2", "--bus", "udp:0"), "--jobs 2 needs --bus udp:N"),
        (("--jobs", "2", "--bus", "socketcan:vcan0"), "--jobs 2 needs --bus udp:N"),
        (("--bus", "socketcan:nowhere0"), "bus 'socketcan:nowhere0' cannot be opened: "),
        (("--bus", "udp:77"), "bus 'udp:77' cannot be opened: there is no bus '77'"),
        (("--bus", "kan:1"), "bus 'kan:1' is not known; write one of: virtual, udp:N"),
        (("--bus", "virtual"), "a virtual bus ends at its process"),
        (("--fault", "jam:sail"), "fault 'jam:sail': write "),
        (("--fault", "melt:pressure@60"), "melt is not known"),
    ],
)
def test_bad_words_are_refused_before_anything_flies(
    words: tuple[str, ...], error: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as refused:
        soak.main([*words])
    assert refused.value.code == 2
    assert error in capsys.readouterr().err
