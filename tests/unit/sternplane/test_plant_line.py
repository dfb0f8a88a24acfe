"""The name of the simulated DVL's line: of one living plant, whatever a killed one left."""

from __future__ import annotations

from pathlib import Path

import pytest
from sternplane.sitl.plant import _owned

from firmware_py.run.usage_error import UsageError
from sim_bridge.devices.serial_line import SerialLine


def test_what_a_killed_plant_left_is_removed_even_if_its_terminal_is_there_still(tmp_path: Path) -> None:
    name = tmp_path / "dvl"
    with SerialLine() as of_another:
        name.symlink_to(of_another.path)
        with _owned(name):
            assert not name.is_symlink()
    name.symlink_to("/dev/pts/99999")
    with _owned(name):
        assert not name.is_symlink()


def test_the_name_of_a_living_plant_is_refused_and_its_link_stays(tmp_path: Path) -> None:
    name = tmp_path / "dvl"
    with SerialLine() as line, _owned(name):
        name.symlink_to(line.path)
        with pytest.raises(UsageError, match="another plant has it"), _owned(name):
            pass
        assert name.is_symlink()


def test_what_is_no_terminal_stays(tmp_path: Path) -> None:
    name, file = tmp_path / "dvl", tmp_path / "precious"
    file.write_text("?")
    name.symlink_to(file)
    with _owned(name):
        assert name.is_symlink()
