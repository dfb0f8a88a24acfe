"""Names of logs: a flight's folder, which its number orders whatever the clock shows, and the parts of its log."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import NamedTuple

LOG_FILE = "log.mcap"
"""The log, in the folder of its run; log.2.mcap and so on are its further parts."""
_FLIGHT = re.compile(r"(\d{5,})-\d{8}-\d{6}")
_PART = re.compile(r"log(?:\.([1-9]\d*))?\.mcap")


class NamedLog(NamedTuple):
    """A part of a flight's log; they sort by age."""

    flight: int
    part: int
    path: Path


def part_file(part: int) -> str:
    """Return the name of a part; they count from 1."""
    return of_part(LOG_FILE, part)


def of_part(file: str, part: int) -> str:
    """Return the name of a file that belongs to a part: that of the first has no number."""
    name, _, kind = file.rpartition(".")
    return file if part == 1 else f"{name}.{part}.{kind}"


def part_number(file: str) -> int:
    """Return the number of a part by its name; 1 of a file with any other name."""
    match = _PART.fullmatch(file)
    return int(match[1] or 1) if match else 1


def parts_in(folder: Path) -> list[tuple[int, Path]]:
    """Return number and path of the parts in a flight's folder, the oldest first.

    Raises:
        OSError: it cannot be listed.
    """
    found = ((_PART.fullmatch(entry.name), entry.path) for entry in os.scandir(folder))
    return sorted((int(match[1] or 1), Path(path)) for match, path in found if match)


def flight_number(folder: str) -> int:
    """Return the number in the name of a flight's folder; 0 for any other."""
    match = _FLIGHT.fullmatch(folder)
    return int(match[1]) if match else 0


def logs_below(root: Path) -> list[NamedLog]:
    """Return all logs of numbered flights in a folder, the oldest first.

    Raises:
        OSError: it cannot be listed.
    """
    found: list[NamedLog] = []
    for entry in os.scandir(root):
        number = flight_number(entry.name)
        if number and entry.is_dir(follow_symlinks=False):
            found += (NamedLog(number, part, path) for part, path in parts_in(Path(entry.path)))
    return sorted(found)
