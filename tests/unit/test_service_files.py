"""The files that start the vehicle at boot: systemd and udev know what is in them, and so does the program."""

from __future__ import annotations

import argparse
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from configparser import ConfigParser
from pathlib import Path

import pytest

from firmware_py.adapters.ground.station_link import parse_link
from firmware_py.adapters.installation import configs
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.params import load
from firmware_py.run import options

UNITS = sorted((configs() / "systemd").iterdir())
RULES = sorted((configs() / "udev").iterdir())
PYTHON = "/opt/sternplane/bin/python"
KEY = re.compile(
    r"(?:ACTION|SUBSYSTEM|DRIVER|KERNEL|SYMLINK|GROUP|MODE|ENV\{\w+\}|ATTR\{\w+\})"  # of udev(7), those we use
    r'(?:==|=|\+=)"[^"]*"'
)


def unit(path: Path) -> ConfigParser:
    found = ConfigParser(strict=False, interpolation=None, delimiters=("=",), comment_prefixes=("#",))
    found.optionxform = str  # type: ignore[assignment, method-assign]
    found.read_string(path.read_text())
    return found


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="no systemd on this machine")
@pytest.mark.parametrize("path", UNITS, ids=lambda path: path.name)
def test_systemd_finds_nothing_wrong(path: Path, tmp_path: Path) -> None:
    for other in UNITS:  # a unit is read with those that it names
        text = other.read_text().replace(PYTHON, sys.executable)
        (tmp_path / other.name).write_text(re.sub(r"=/usr/sbin/ip ", f"={sys.executable} ", text))
    verify = ["systemd-analyze", "verify", "--man=no", "--recursive-errors=yes", tmp_path / path.name]
    done = subprocess.run(verify, capture_output=True, text=True, check=False, timeout=60)
    assert [line for line in (done.stdout + done.stderr).splitlines() if "sternplane" in line] == []
    assert done.returncode == 0


def test_the_service_starts_the_program_with_options_that_it_knows() -> None:
    service = unit(configs() / "systemd" / "sternplane.service")["Service"]
    python, *words = shlex.split(service["ExecStart"])
    assert [python, *words[:3]] == [PYTHON, "-P", "-m", "firmware_py"]
    assert words[-1] == "$LINKS"
    parser = argparse.ArgumentParser()
    options.add_fly(parser)
    parsed = parser.parse_args([*words[3:-1], "--gcs", "udpout:192.168.2.1:14550"])
    kept = f"/var/lib/{service['StateDirectory']}"
    assert str(parsed.state).startswith(kept)
    assert str(parsed.logs).startswith(kept)
    assert f"STERNPLANE_CACHE=/var/cache/{service['CacheDirectory']}" in service["Environment"].split()
    assert (parsed.pace, parsed.out) == (None, None)


def test_it_is_started_again_after_everything_but_a_configuration_that_cannot_be_flown() -> None:
    found = unit(configs() / "systemd" / "sternplane.service")
    service = found["Service"]
    assert (service["Restart"], service["RestartPreventExitStatus"], service["SuccessExitStatus"]) == (
        "always",
        "2",
        "3",
    )
    assert found["Unit"]["StartLimitIntervalSec"] == "0", "it would give up after five crashes"
    assert service["KillMode"] == "mixed", "helpers that write the state would be killed before they have"
    assert service["Type"] == "notify", "or nobody feeds the watchdog"
    assert "MemoryDenyWriteExecute" not in service, "kernels are compiled"
    assert "AF_CAN" in service["RestrictAddressFamilies"]


@pytest.mark.parametrize("path", RULES, ids=lambda path: path.name)
def test_each_rule_has_keys_that_udev_knows_and_gives_names_below_one_folder(path: Path) -> None:
    rules = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    for rule in rules:
        assert [pair for pair in re.split(r",\s*", rule) if not KEY.fullmatch(pair)] == []
    names = re.findall(r'SYMLINK\+="([^"]*)"', "".join(rules))
    assert {"sternplane/dvl", "sternplane/ahrs", "sternplane/gps"} <= set(names)
    assert len(set(names)) == len(names)
    assert path.name > "60-serial.rules", "that one finds out what these compare"
    udevadm = shutil.which("udevadm") or "true"
    if "verify" in subprocess.run([udevadm, "--help"], capture_output=True, text=True, check=False).stdout:  # 254 on
        done = subprocess.run([udevadm, "verify", path], capture_output=True, text=True, check=False, timeout=60)
        assert done.returncode == 0, done.stdout + done.stderr


def test_the_page_tells_what_the_program_takes() -> None:
    page = (configs() / "vehicle.md").read_text()
    found = re.search(r"```toml\n(.*?)```", page, re.DOTALL)
    assert found is not None
    io = load(
        IoParams, read_toml(configs() / "npsauv2" / "io_sea.toml") | tomllib.loads(found[1]), "io.toml of the page"
    )
    assert [device.table.driver for device in io.lines] == ["vectornav", "waterlink", "ublox"]
    parser = argparse.ArgumentParser()
    options.add_fly(parser)
    [fly] = re.findall(r"^    sternplane fly (.*)$", page, re.MULTILINE)
    assert str(parser.parse_args(fly.split()).logs) == "/tmp/logs"
    links = re.search(r"^    LINKS=(.*)$", page, re.MULTILINE)
    assert links is not None
    for link in parser.parse_args(shlex.split(links[1])).gcs:
        parse_link(link)
    for unit_or_rule in (*UNITS, *RULES):
        assert unit_or_rule.name in page


def test_the_vehicles_requirements_draw_nothing_and_are_those_that_were_tested() -> None:
    folder = Path(__file__).resolve().parents[2] / "tools" / "requirements"
    aboard, tested = ((folder / name).read_text() for name in ("vehicle.txt", "run.txt"))
    pins = re.compile(r"^([\w.-]+==\S+)", re.MULTILINE)
    assert set(pins.findall(aboard)) < set(pins.findall(tested))
    names = {pin.partition("==")[0] for pin in pins.findall(aboard)}
    assert names.isdisjoint({"plotly", "jinja2", "matplotlib", "pillow", "hatchling"})
    project = tomllib.loads((folder.parents[1] / "pyproject.toml").read_text())["project"]
    assert {line.partition(">")[0] for line in project["dependencies"]} <= names
    assert aboard.count("--hash=sha256:") > len(names)


def test_what_the_page_copies_lies_where_it_says() -> None:
    page = (configs() / "vehicle.md").read_text()
    aboard = r"^    cp /opt/sternplane/lib/python3\*/site-packages/firmware_py/configs/(\S+) /etc/"
    copied = {configs() / name for name in re.findall(aboard, page, re.MULTILINE)}
    assert copied == {*UNITS, *RULES}
