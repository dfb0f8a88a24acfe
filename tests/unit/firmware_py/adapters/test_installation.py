"""What a person calls a configuration: a folder, or a shipped vehicle, wherever the program is started."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest
from sternplane.cli.main import main

from firmware_py.adapters.installation import configs, configuration_file, configuration_folder, shipped_vehicles
from firmware_py.run import options


@pytest.fixture(autouse=True)
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["npsauv2", "remus100", "torpedo_x"])
@pytest.mark.parametrize("form", ["{}", "configs/{}", "./configs/{}/"])
def test_a_shipped_vehicle_is_found_by_its_name_from_an_empty_folder(name: str, form: str) -> None:
    assert name in shipped_vehicles()
    assert configuration_folder(form.format(name)) == configs() / name


def test_a_folder_that_exists_is_that_folder(empty: Path) -> None:
    for path in (Path("remus100"), Path("configs/remus100")):
        path.mkdir(parents=True)
        assert configuration_folder(path) == path


@pytest.mark.parametrize("name", ["scenarios", "configs/udev", "boats/remus100", "/configs/remus100", "", "n" * 300])
def test_what_is_neither_stays_as_it_is_to_be_refused(name: str) -> None:
    assert configuration_folder(name) == Path(name)


@pytest.mark.parametrize("named", ["npsauv2/io_sea.toml", "configs/npsauv2/io_sea.toml"])
def test_a_file_of_a_shipped_vehicle_is_found_and_one_that_exists_is_that_file(named: str) -> None:
    assert configuration_file(named) == configs() / "npsauv2" / "io_sea.toml"
    vehicle = argparse.ArgumentParser()
    options.add_fly(vehicle)
    assert vehicle.parse_args(["--io", named]).io == configs() / "npsauv2" / "io_sea.toml"
    Path(named).parent.mkdir(parents=True)
    Path(named).touch()
    assert configuration_file(named) == Path(named)


@pytest.mark.parametrize("named", ["io_sea.toml", "npsauv2", "npsauv2/io_lake.toml", "a/io_sea.toml", "", "n" * 300])
def test_a_file_that_there_is_not_stays_as_it_is(named: str) -> None:
    assert configuration_file(named) == Path(named)


def test_both_programs_take_it(capsys: pytest.CaptureFixture[str]) -> None:
    vehicle = argparse.ArgumentParser()
    options.add_fly(vehicle)
    assert vehicle.parse_args(["--config", "torpedo_x"]).config == configs() / "torpedo_x"
    assert main(["vehicle", "check", "configs/nothing"]) == 2
    assert "configs/nothing: there is no such configuration folder" in capsys.readouterr().err
