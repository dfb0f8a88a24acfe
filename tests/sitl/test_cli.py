"""The `sternplane` command as a person meets it: exit statuses, errors of one line, and what it leaves."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path

import pytest
from sternplane.logs.reading import read

from tests.command import called, installed, no_file_larger_than
from tests.shared_flights import LEARNING_OFF, without_learning
from tests.sitl.conftest import Start

ROOT = Path(__file__).resolve().parents[2]
BRIEF = """
description = "Two seconds at the surface."
duration_s = 2.0
completes = "time"
[[orders]]
t_s = 0.2
arming = "arm"
"""

PLACE = "[[waypoints]]\nx_m = 100.0\ny_m = 0.0\n"
WRONG = {
    "mud.toml": "[start]\ndepth_m = 50.0\n[environment]\nbottom_depth_m = 40.0\n",
    "far.toml": "[[waypoints]]\nx_m = 1e300\ny_m = 0.0\ndepth_m = 1.0\nspeed_m_s = 1.0\n",
    "deep.toml": f"{PLACE}depth_m = 9.0\nspeed_m_s = 1.8\n{PLACE}depth_m = 30.5\nspeed_m_s = 1.8\n",
    "ground.toml": f"{PLACE}depth_m = 9.0\nspeed_m_s = 1.8\n[environment]\nbottom_depth_m = 10.0\n",
    "fast.toml": f"{PLACE}depth_m = 9.0\nspeed_m_s = 5.0\n",
    "slow.toml": "[sensors.pressure]\nrate_hz = 1\n[autopilot.safety]\ndepth_timeout_s = 0.5\n",
    "law.toml": '[autopilot.control]\nlaw = "fuzzy"\n',
}


@pytest.fixture
def config(tmp_path: Path) -> Path:
    return Path(shutil.copytree(ROOT / "configs" / "npsauv2", tmp_path / "config"))


@pytest.fixture
def brief(tmp_path: Path) -> Path:
    path = tmp_path / "brief.toml"
    path.write_text(BRIEF)
    return path


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def assert_one_line(result: subprocess.CompletedProcess[str], *words: str) -> None:
    assert result.returncode == 2, result.stdout + result.stderr
    assert result.stderr.count("\n") == 1, result.stderr
    assert result.stderr.startswith("sternplane: ")
    for word in words:
        assert word in result.stderr
    assert not result.stdout


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("autopilot.toml", "rate_hz = 100", "rate_hz = 100\ncolour = 3", ("autopilot.toml: colour is unknown",)),
        ("autopilot.toml", "rate_hz = 100", "rate_hz = 75", ("autopilot.toml: rate_hz", "75 Hz", "100")),
        ("autopilot.toml", "rate_hz = 100", "rate_hz = 1e", ("autopilot.toml: is not TOML",)),
        ("autopilot.toml", "depth_max_m = 30.0", "depth_max_m = -3.0", ("safety: depth_max_m = -3.0: out of bounds",)),
        ("autopilot.toml", "pitch_max_deg = ", "pitch_max_rad = ", ("guidance: pitch_max_rad", "write pitch_max_deg")),
        (
            "autopilot.toml",
            'law = "sliding"',
            'law = "fuzzy"',
            ("control.law = fuzzy: no installed package", "known here: pid, sliding"),
        ),
        ("vehicle.toml", "hinge_deg = 90", "hinge_deg = 0", ()),
        ("vehicle.toml", 'name = "rudder_upper"', 'name = "rudder_lower"', ("vehicle.toml", "rudder_lower")),
        (
            "vehicle.toml",
            "mass_kg = 5454.54",
            "mass_kg = 1e300",
            ("vehicle.toml: body: mass_kg = 1e+300: out of bounds",),
        ),
        ("vehicle.toml", "M_q = -6.8e-2\n", "", ("vehicle.toml: coefficients: M_q is missing", "[-10, 10]")),
        (
            "vehicle.toml",
            "M_qdot = -1.7e-2",
            "M_qdot = 1.0",
            ("vehicle.toml: coefficients: M_qdot = 1 leaves no inertia",),
        ),
        ("vehicle.toml", 'name = "rudder_lower"', 'name = ""', ("vehicle.toml: fins[3]: name is empty",)),
        ("truth.toml", "Z_w = ", "Z_u = ", ("truth.toml: coefficients: Z_u is unknown",)),
        ("truth.toml", "substeps = 1", "substeps = 0", ("truth.toml: substeps = 0", "a whole number in [1, 100]")),
        ("io_sitl.toml", "ahrs = 23", "ahrs = 10", ("io_sitl.toml: nodes.ahrs = 10: is can.node_id already",)),
        ("io_sitl.toml", "esc = 22", "esc = 125", ("io_sitl.toml: nodes.esc = 125: is can.plant_id already",)),
    ],
)
def test_a_bad_configuration_is_one_line_with_file_and_key(
    config: Path, brief: Path, tmp_path: Path, file: str, old: str, new: str, words: Sequence[str]
) -> None:
    if file == "vehicle.toml" and "hinge" in old:  # no fin is left that acts on delta_r
        path = config / file
        path.write_text(path.read_text().replace("hinge_deg = 90", "hinge_deg = 0"))
        words = ("vehicle.toml", "delta_r")
    else:
        edit(config / file, old, new)
    result = called("sitl", "--scenario", brief, "--config", config, "--out", tmp_path / "out", cwd=tmp_path)
    assert_one_line(result, *words)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--scenario", "atlantis"), ("atlantis", "demo", "paper-depth")),
        (("--bus", "socketcan:vcan9"), ("bus 'socketcan:vcan9' cannot be opened",)),
        (("--scenario", "folder.toml"), ("folder.toml: cannot be read (Is a directory)",)),
        (("--scenario", "mud.toml"), ("mud.toml: start: depth_m = 50 is below the bottom", "which is 40 m deep there")),
        (("--scenario", "far.toml"), ("far.toml: waypoints[0]: x_m = 1e+300: out of bounds",)),
        (("--scenario", "deep.toml"), ("deep.toml: waypoints[1]: depth 30.5 m is over safety.depth_max_m = 30",)),
        (("--scenario", "ground.toml"), ("ground.toml: waypoints[0]: depth 9 m, and the bottom is 10 m deep there",)),
        (("--scenario", "fast.toml"), ("fast.toml: waypoints[0]: speed_m_s = 5 is over guidance.speed_max_m_s",)),
        (("--scenario", "slow.toml"), ("sensors.toml: pressure.rate_hz = 1: safety.depth_timeout_s = 0.5 in ",)),
        (
            ("--scenario", "law.toml"),
            ("under [autopilot] of law.toml: control.law = fuzzy: no installed package", "known here: pid, sliding"),
        ),
        (
            ("--scenario", "law.toml", "--set", "autopilot.guidance.law=straight"),
            ("autopilot.toml under [autopilot] of law.toml with autopilot.guidance.law set: ",),
        ),
        (
            ("--set", "autopilot.control.law=fuzzy", "--set", "truth.current=0.1"),
            ("autopilot.toml with autopilot.control.law set: control.law = fuzzy: no installed package",),
        ),
        (
            ("--set", "autopilot.control.own.k=3"),
            ("autopilot.toml with autopilot.control.own.k set: control.own: control.law names no part",),
        ),
        (("--config", "nowhere"), ("nowhere", "npsauv2, remus100")),
        (("--seed", "-1"), ("--seed -1",)),
        (("--out", "/proc/here"), ("--out /proc/here", "choose another")),
        (("--state", "folder.toml/../mud.toml"), ("mud.toml: is not a folder; choose another",)),
        (("--fault", "jam:rudder@1"), ("fault jam:rudder@1: there is no fin 'rudder'; known: stern_port",)),
        (("--fault", "off:ahrs.2@1"), ("fault off:ahrs.2@1: the io file has no ahrs.2",)),
    ],
)
def test_a_bad_argument_is_one_line_that_says_what_would_be_right(
    tmp_path: Path, brief: Path, arguments: tuple[str, str], words: Sequence[str]
) -> None:
    (tmp_path / "folder.toml").mkdir()
    for name, more in WRONG.items():
        (tmp_path / name).write_text(BRIEF + more)
    wanted = ("sitl", "--scenario", brief, *arguments) if arguments[0] != "--scenario" else ("sitl", *arguments)
    assert_one_line(called(*wanted, cwd=tmp_path), *words)
    assert not (tmp_path / "runs").exists()


def test_a_flight_that_is_refused_at_its_begin_leaves_nothing(tmp_path: Path, brief: Path) -> None:
    """The battery is found to be impossible when the plant is built, after the run's folder was made."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("kept")
    wanted = ("sitl", "--scenario", brief, "--set", "sensors.battery.voltage_empty_v=51")
    for out in (("--out", "new"), ("--out", "mine"), ()):
        result = called(*wanted, *out, cwd=tmp_path)
        assert result.returncode == 2
        assert "battery: voltage_empty_v is above voltage_full_v" in result.stderr
    assert not (tmp_path / "new").exists()
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["notes.txt"]
    assert not list(tmp_path.glob("runs/*"))


def test_the_installed_script_says_what_the_command_says_when_a_test_calls_it(tmp_path: Path) -> None:
    words = ("sitl", "--scenario", "atlantis")
    script, here = installed(*words, cwd=tmp_path), called(*words, cwd=tmp_path)
    assert_one_line(script, "atlantis")
    assert (script.returncode, script.stdout, script.stderr) == (here.returncode, here.stdout, here.stderr)


def test_a_mistake_in_a_file_is_not_put_down_to_the_scenario(config: Path, tmp_path: Path) -> None:
    edit(config / "autopilot.toml", "depth_max_m = 30.0", "depth_max_m = -3.0")
    (tmp_path / "law.toml").write_text(BRIEF + WRONG["law.toml"])
    result = called("sitl", "--scenario", "law.toml", "--config", config, cwd=tmp_path)
    assert_one_line(result, "autopilot.toml: safety: depth_max_m = -3.0: out of bounds")


def test_sixteen_fins_are_refused_in_belief_and_in_truth(config: Path, brief: Path, tmp_path: Path) -> None:
    for name, more, words in (
        (
            "truth.toml",
            'station = "stern"\ncentre_m = [0.0, 0.0, 0.0]\nspan_m = 0.1\n',
            "fins: 16 of them; write 1 to 15",
        ),
        ("vehicle.toml", "", "fins: 16 are too many; one command holds 15"),
    ):
        before = (config / name).read_text()
        fins = "".join(f'[[fins]]\nname = "more_{i}"\nhinge_deg = 0.0\n{more}' for i in range(12))
        (config / name).write_text(before + fins)
        assert_one_line(called("sitl", "--scenario", brief, "--config", config, cwd=tmp_path), f"{name}: {words}")
        (config / name).write_text(before)


def test_a_full_disk_ends_the_run_with_one_line_and_keeps_what_was_written(tmp_path: Path) -> None:
    with no_file_larger_than(300_000):
        result = called("sitl", "--out", "full", cwd=tmp_path)
    assert result.returncode == 2
    errors = [line for line in result.stderr.splitlines() if line.startswith("sternplane: ")]
    assert len(errors) == 1
    assert "log.mcap" in errors[0]
    assert "choose another folder" in errors[0]
    log = read(tmp_path / "full" / "log.mcap")
    assert not log.complete
    assert len(log.cycle_bytes) > 100
    again = called("replay", "full", cwd=tmp_path)
    assert again.returncode == 0, again.stdout + again.stderr


def test_a_disk_that_is_full_by_a_fault_ends_the_log_and_not_the_flight(tmp_path: Path, brief: Path) -> None:
    result = called("sitl", "--scenario", brief, "--out", "run", "--fault", "full:disk@1.2", cwd=tmp_path)
    assert result.returncode == 0, result.stderr  # it was flown to its end
    said = [line for line in result.stderr.splitlines() if line.startswith("sternplane: ")]
    assert len(said) == 1
    assert "No space left on device" in said[0]
    assert said[0].endswith("the flight goes on without a log")
    log = read(tmp_path / "run" / "log.mcap")
    assert not log.complete
    assert 60 <= len(log.cycle_bytes) <= 120  # at most half a second is lost with it
    words = " ".join(result.stdout.split())
    assert "completed; the log ends at 1." in words
    assert "because the disk was full: the vehicle flew on for" in words
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["completed"]
    assert summary["judged_by"] == "truth"
    assert summary["after_log"]["mode"] == "manual"
    assert summary["vehicle_time_s"] == pytest.approx(2.0)
    assert 0.6 <= summary["logged_s"] <= 1.2
    assert "of a part of the flight alone" in (tmp_path / "run" / "report.html").read_text()


def test_a_bus_that_loses_frames_is_told_while_it_flies(tmp_path: Path, brief: Path) -> None:
    wanted = ("sitl", "--scenario", brief, "--no-report", "--out")
    sound = called(*wanted, "sound", cwd=tmp_path)
    lossy = called(*wanted, "lossy", "--fault", "lossy:bus=30@0", cwd=tmp_path)
    told = [line for line in lossy.stderr.splitlines() if re.fullmatch(r" +0\.99 s  .+ missed: \d+ more, .*", line)]
    assert len(told) == 1, lossy.stderr
    assert "missed" not in sound.stderr


def test_faults_aboard_the_vehicle_are_refused_where_they_mean_nothing(tmp_path: Path, brief: Path) -> None:
    wanted = ("--scenario", brief, "--fault", "jump:clock=1@1")
    assert_one_line(called("sitl", *wanted, cwd=tmp_path), "jump:clock=1@1", "--pace realtime")
    wanted = ("plant", "--bus", "udp:7", "--fault", "full:disk@1")
    assert_one_line(called(*wanted, cwd=tmp_path), "full:disk@1", "strikes the vehicle")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--seed", "-1"), "--seed -1: must be 0 or more"),
        (("--wait", "nan"), "'nan': must be in [0, 86400]"),
        (("--wait", "inf"), "'inf': must be in [0, 86400]"),
        (("--wait", "0"), "--wait 0: in lockstep the plant steps with a vehicle"),
    ],
)
def test_a_plant_that_cannot_begin_says_so_in_one_line(tmp_path: Path, words: tuple[str, str], said: str) -> None:
    assert_one_line(called("plant", "--bus", "udp:7", *words, cwd=tmp_path), said)


def test_a_run_leaves_log_summary_and_report_and_a_replay_and_a_report_can_be_made_of_it(
    tmp_path: Path, brief: Path
) -> None:
    flown = called("sitl", "--scenario", brief, "--out", "run", cwd=tmp_path)
    assert flown.returncode == 0, flown.stderr
    folder = tmp_path / "run"
    assert json.loads((folder / "summary.json").read_text())["completed"] is True
    page = (folder / "report.html").read_text()
    (folder / "report.html").unlink()

    replayed = called("replay", folder, cwd=tmp_path)
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr
    assert "200 cycles replayed: every byte equal" in replayed.stdout

    reported = called("report", folder / "log.mcap", cwd=tmp_path)
    assert reported.returncode == 0
    assert (folder / "report.html").read_text() == page


def test_a_log_that_is_there_is_kept_and_the_next_run_goes_beside_it(tmp_path: Path, brief: Path) -> None:
    wanted = ("sitl", "--scenario", brief, "--out", "run")
    assert called(*wanted, cwd=tmp_path).returncode == 0
    before = {path: path.read_bytes() for path in (tmp_path / "run").rglob("*") if path.is_file()}
    again = called(*wanted, cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    (folder,) = (path.parent for path in tmp_path.glob("run/*/log.mcap"))
    said = f"sternplane: --out run: holds a log already, which is kept; this run is in run/{folder.name}"
    assert said in again.stderr.splitlines()
    assert {path: path.read_bytes() for path in before} == before
    assert read(folder / "log.mcap").complete
    assert (folder / "summary.json").exists()


def test_a_run_that_is_refused_tells_of_no_folder_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "log.mcap").touch()
    result = called("sitl", "--out", "run", "--state", "/proc/here", cwd=tmp_path)
    assert_one_line(result, "/proc/here: cannot be made")
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["log.mcap"]


def test_a_vehicle_takes_up_the_state_that_it_kept(tmp_path: Path, brief: Path) -> None:
    for name in ("one", "two"):
        result = called("sitl", "--scenario", brief, "--out", name, "--state", "kept", cwd=tmp_path)
        assert result.returncode == 0, result.stderr
    one, two = (read(tmp_path / name / "log.mcap") for name in ("one", "two"))
    assert one.header["configuration"]["kept"] == {}
    last = list(one.cycles)[-1].state
    assert two.header["configuration"]["kept"]["x"] == last.eta.x
    kept = two.header["configuration"]["kept"]["position_std"]
    assert last.position_std < kept < 100.0  # time has passed; a vehicle that knows nothing begins with 100 m
    assert next(two.cycles).state.position_std < kept + 0.1


def test_a_mission_that_fails_is_status_1_and_says_why(tmp_path: Path) -> None:
    path = tmp_path / "aground.toml"
    path.write_text(without_learning("demo").replace("duration_s = 330.0", "duration_s = 30.0"))
    result = called("sitl", "--scenario", path, "--out", "run", cwd=tmp_path)
    assert result.returncode == 1, result.stderr
    told = " ".join(result.stdout.split())
    assert "the scenario's 30 s were over while it flew its mission, " in told


def test_a_vehicle_armed_at_rest_stays_where_it_is_with_its_fins_centred(tmp_path: Path) -> None:
    path = tmp_path / "rest.toml"
    path.write_text(
        BRIEF.replace("duration_s = 2.0", "duration_s = 20.0") + 'mode = "hold"\nspeed_m_s = 0.0\n' + LEARNING_OFF
    )
    result = called("sitl", "--scenario", path, "--out", "run", cwd=tmp_path)
    assert result.returncode == 0, result.stderr + result.stdout
    cycles = list(read(tmp_path / "run" / "log.mcap").cycles)
    assert all(abs(angle) < 1e-9 for cycle in cycles for angle in cycle.applied.fins)
    assert max(abs(cycle.applied.n) for cycle in cycles) < 1.0
    assert abs(cycles[-1].state.eta.z) < 0.2


def test_ctrl_c_closes_the_log_and_leaves_the_report(tmp_path: Path, start: Start) -> None:
    process = start("sitl", "--out", "run", "--pace", "realtime")
    log = tmp_path / "run" / "log.mcap"
    while not (log.exists() and log.stat().st_size > 20_000):  # a chunk is written: it flies
        assert process.returncode is None, process.stderr
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "interrupted" in out
    recovered = read(log)
    assert recovered.complete
    assert len(recovered.cycle_bytes) > 50
    assert (tmp_path / "run" / "report.html").stat().st_size > 100_000


def test_a_truncated_log_is_replayed_as_far_as_it_goes_and_one_without_a_beginning_is_refused(
    tmp_path: Path, brief: Path
) -> None:
    assert called("sitl", "--scenario", brief, "--out", "run", cwd=tmp_path).returncode == 0
    data = (tmp_path / "run" / "log.mcap").read_bytes()
    (tmp_path / "half.mcap").write_bytes(data[: len(data) // 2])
    (tmp_path / "stub.mcap").write_bytes(data[:100])
    half = called("replay", "half.mcap", cwd=tmp_path)
    assert half.returncode == 0, half.stderr
    assert "every byte equal" in half.stdout
    assert "note:" in half.stdout
    assert_one_line(called("replay", "stub.mcap", cwd=tmp_path), "stub.mcap")
    assert_one_line(called("replay", "missing.mcap", cwd=tmp_path), "missing.mcap")


def test_the_scenarios_are_listed_with_a_sentence_each(tmp_path: Path) -> None:
    result = called("scenarios", cwd=tmp_path)
    assert result.returncode == 0
    lines = dict(line.split(maxsplit=1) for line in result.stdout.splitlines())
    assert {"demo", "paper-depth", "paper-heading", "zigzag", "turning-circle"} <= set(lines)
    assert all(sentence.endswith(".") for sentence in lines.values())
