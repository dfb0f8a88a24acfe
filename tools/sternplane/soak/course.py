"""The demonstration, made as long as wanted: its waypoints, then a way back to the first of them, round and round."""

from __future__ import annotations

import itertools
import math
import re
import shutil
from pathlib import Path

from firmware_py import config_files
from firmware_py.records.mission import Waypoint
from sim_bridge.scenarios import load_scenario, scenario_path
from sternplane.identification import vehicle_file
from sternplane.sitl.flight import SCENARIOS

SPEED = 1.8
_BACK = ((240.0, 190.0, 5.0), (110.0, 160.0, 10.0), (0.0, 110.0, 10.0), (-40.0, 40.0, 6.0))
"""North, east, depth, m: from the demonstration's last waypoint to its first, without turning about."""
_SHORTEST_LEG = 10.0
_DURATION = re.compile(r"^duration_s = .*$", re.MULTILINE)


def course(seconds: float) -> list[Waypoint]:
    """Return waypoints that take so long at the demonstration's speed, from 0, 0 to the last."""
    there = [item for item in load_scenario("demo", SCENARIOS).mission.items if isinstance(item, Waypoint)]
    back = [Waypoint(x, y, z, SPEED) for x, y, z in _BACK]
    left, at, found = seconds * SPEED, (0.0, 0.0), list[Waypoint]()
    for one in itertools.cycle((*there, *back)):
        leg = math.dist(at, (one.x, one.y))
        if leg >= left:
            if left >= _SHORTEST_LEG or not found:
                x, y = (a + (b - a) * left / leg for a, b in zip(at, (one.x, one.y), strict=True))
                found.append(one._replace(x=x, y=y))
            return found
        found.append(one)
        left, at = left - leg, (one.x, one.y)
    raise AssertionError("a course goes round and round")


def configuration(io_file: Path, folder: Path, seconds: float) -> Path:
    """Make a configuration as the demonstration's vehicle has it, 40 % wrong, with a course; return its folder.

    Of the folder of the io file the TOML files are taken, and nothing else that may stand there.
    """
    made, shipped = folder / "config", io_file.parent
    made.mkdir()
    for file in {io_file, *shipped.glob("*.toml")}:
        if file.is_file():  # to read a FIFO would wait for a writer
            shutil.copyfile(file, made / file.name)
    factors = load_scenario("demo", SCENARIOS).vehicle_factors
    vehicle = config_files.read_configuration(shipped, factors=factors)["vehicle"]
    vehicle_file.write(made / "vehicle.toml", vehicle, "As the demonstration has it: 40 % wrong.")
    lines = [
        f"[[waypoints]]\nx_m = {one.x:.1f}\ny_m = {one.y:.1f}\ndepth_m = {one.z:.1f}\nspeed_m_s = {one.u:.1f}\n"
        for one in course(seconds)
    ]
    (made / "mission.toml").write_text("\n".join(lines), encoding="utf-8")
    return made


def scenario(folder: Path, longest: float) -> Path:
    """Write the demonstration's scenario, for a plant that goes on for so long, s; return its file."""
    text = scenario_path("demo", SCENARIOS).read_text(encoding="utf-8")
    path = folder / "soak.toml"
    path.write_text(_DURATION.sub(f"duration_s = {longest:.1f}", text), encoding="utf-8")
    return path
