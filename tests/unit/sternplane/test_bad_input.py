"""Whatever is typed, the command says in one line what is wrong with it, and nothing of it reaches a terminal raw."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_py.adapters.installation import configs
from tests.command import called

RED = "\x1b[31mred\x07"
LONG = "9" * 5000
"""Digits: more than Python reads or writes."""
SWEEP = ("sweep", "--vary", "vehicle.M_q=±20%", "--out", "out")


@pytest.mark.parametrize(
    "words",
    [
        ("sitl", "--set", f"vehicle.{RED}=1"),
        ("sitl", "--set", f"{RED}=1"),
        ("sitl", "--set", RED),
        ("sitl", "--set", f"vehicle.M_q={RED}"),
        ("sitl", "--set", f"vehicle.fins.{RED}.name=x"),
        ("sitl", "--set", f"autopilot.control.law={RED}"),
        ("sitl", "--set", "autopilot.control.law=\N{RIGHT-TO-LEFT OVERRIDE}gnidils"),
        ("sitl", "--config", RED),
        ("sitl", "--scenario", RED),
        ("sitl", RED),
        ("sitl", "--seed", RED),
        (RED,),
        ("replay", RED),
        ("fins", "--sweep", "--node", RED),
        ("sweep", "--vary", f"vehicle.{RED}=1..2", "--out", "out"),
        ("sweep", "--vary", f"vehicle.M_q={RED}", "--out", "out"),
        ("sweep", "--vary", "vehicle.M_q=±20%", "--seeds", RED, "--out", "out"),
    ],
)
def test_control_characters_are_shown_and_not_sent_to_the_terminal(words: tuple[str, ...], tmp_path: Path) -> None:
    done = called(*words, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("sternplane: ")
    assert done.stderr.removesuffix("\n").isprintable()
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize(
    "words",
    [
        *((*SWEEP, option, LONG) for option in ("--n", "--grid", "--seed", "--jobs", "--worst", "--again")),
        (*SWEEP, "--seeds", f"0:{LONG}"),
        ("sweep", "--vary", f"vehicle.M_q=±{LONG}%", "--out", "out"),
        ("sweep", "--vary", f"sensors.dvl.rate=1..{LONG}", "--out", "out"),
        ("sweep", "--vary", f"sensors.dvl.rate=1,{LONG}", "--out", "out"),
        ("sweep", "--vary", f"autopilot.control.law=a,{LONG}", "--out", "out"),
        ("study", "estimation", "--seeds", f"0:{LONG}", "--out", "out"),
        ("sitl", "--seed", LONG),
        ("sitl", "--set", f"sensors.dvl.rate={LONG}"),
        ("sitl", "--set", f"truth.fins.{LONG}.effectiveness=1"),
        ("fins", "--sweep", "--node", LONG),
        ("serial", "sniff", "/dev/null", "--baud", LONG),
    ],
)
def test_numbers_of_thousands_of_digits_are_one_line(words: tuple[str, ...], tmp_path: Path) -> None:
    done = called(*words, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert len(done.stderr) < 600
    assert not [*tmp_path.iterdir()]


def test_a_count_of_seeds_that_no_disk_holds_is_refused(tmp_path: Path) -> None:
    done = called("study", "estimation", "--seeds", "0:1000000000000", "--out", "out", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (
        2,
        "sternplane: --seeds 0:1000000000000: 1,000,000,000,000 seeds; at most 1,000,000\n",
    )


@pytest.mark.parametrize(
    "words",
    [
        ("export", "PATH", "--format", "csv"),
        ("report", "PATH"),
        ("replay", "PATH"),
        ("compare", "PATH", "PATH"),
        ("sitl", "--config", "PATH"),
        ("sitl", "--io", "PATH"),
        ("sitl", "--out", "PATH"),
        ("sitl", "--state", "PATH"),
        ("sweep", "--vary", "vehicle.M_q=±20%", "--out", "PATH"),
        ("sweep", "--again", "1", "--out", "PATH"),
        ("passport", "PATH"),
        ("identify", "PATH"),
        ("vehicle", "check", "PATH"),
        ("vehicle", "import", "PATH"),
    ],
)
@pytest.mark.parametrize("path", ["x" * 300, "loop/x", "file/x"])
def test_a_path_that_no_file_can_have_is_one_line(words: tuple[str, ...], path: str, tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "file").touch()
    done = called(*(path if word == "PATH" else word for word in words), cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert done.stderr.startswith("sternplane: ")
    assert sorted(one.name for one in tmp_path.iterdir()) == ["file", "loop"]


def test_serial_sniff_takes_serial_devices_alone(tmp_path: Path) -> None:
    done = called("serial", "sniff", "tcp:127.0.0.1:9", cwd=tmp_path)
    assert done.returncode == 2
    assert "sternplane: serial sniff tcp:127.0.0.1:9: listens on serial devices alone" in done.stderr


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ('name = "bow"\nid = 1\n', "fins: bow: is no fin of vehicle.toml"),
        ('name = "{}"\nid = {}\ntravel_deg = 9.0\n', "fins: stern_port: travel_deg = 9: the servo must turn to"),
    ],
    ids=["unknown fin", "travel"],
)
@pytest.mark.parametrize("command", ["sitl --io", "fly --io", "io check", "fins --sweep --io"])
def test_servos_that_do_not_fit_the_fins_are_told_with_their_file(
    command: str, settings: str, words: str, tmp_path: Path
) -> None:
    names = ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")
    file, shipped = tmp_path / "mine.toml", configs() / "npsauv2" / "io_sitl.toml"
    tables = "".join("[[fins]]\n" + settings.format(name, i) for i, name in enumerate(names, 1))
    file.write_text(shipped.read_text() + tables)
    done = called(*command.split(), file, cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert done.stderr.startswith(f"sternplane: {file}: {words}")
    assert [*tmp_path.iterdir()] == [file]
