"""A simulated vehicle in another process, in real time, and the bench tools beside it."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.installation import configs
from tests.bus_numbers import free_number
from tests.command import Forked, called

SITL = configs() / "npsauv2" / "io_sitl.toml"


class Plant(NamedTuple):
    """A simulated vehicle: its bus, the DVL's port, its folder."""

    bus: str
    dvl: Path
    folder: Path


@contextlib.contextmanager
def started(folder: Path, *words: str | Path) -> Iterator[Plant]:
    """Run `sternplane plant` with these words too, until it speaks on its bus."""
    with free_number() as number:
        found = Plant(f"udp:{number}", folder / "dvl", folder)
        process = Forked("plant", "--bus", found.bus, "--dvl", found.dvl, "--pace", "realtime", *words, cwd=folder)
        try:
            process.until_said("plant on")
            with contextlib.closing(open_bus(found.bus)) as bus:
                assert bus.drain(1, 60.0)
            yield found
        finally:
            process.close()


def tool(plant: Plant, *words: str | Path, status: int = 0) -> str:
    done = called(*words, cwd=plant.folder)
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout


def checked(plant: Plant, *words: str | Path, file: Path = SITL, status: int = 0) -> dict:
    seconds = ("--seconds", "1.3", "--json")
    return json.loads(tool(plant, "io", "check", file, "--bus", plant.bus, *words, *seconds, status=status))
