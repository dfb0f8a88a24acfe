"""The flights of a campaign in a file: one line of JSON each, written when the flight is over."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from firmware_py.run.usage_error import UsageError
from sternplane.logs.after_log import place_of
from sternplane.study.safety.campaign import Job

FILE = "flights.jsonl"
LOGS = "logs"


class Store:
    """What was flown already, and what is flown now.

    Args:
        folder: of the study.

    Raises:
        UsageError: the file cannot be read or written.
    """

    def __init__(self, folder: Path) -> None:
        self.path, self.logs = folder / FILE, folder / LOGS
        self.flights: dict[str, dict[str, Any]] = {}
        try:
            self.logs.mkdir(exist_ok=True)
            whole = self.path.read_bytes() if self.path.exists() else b""
            self._file = self.path.open("r+b" if whole else "wb")
        except OSError as error:
            raise UsageError(f"{self.path}: cannot be written ({error.strerror}); choose another --out") from None
        ends = whole.rfind(b"\n") + 1
        for line in whole[:ends].splitlines():
            flight = json.loads(line)
            self.flights[flight["key"]] = flight
        self._file.seek(ends)
        self._file.truncate()  # a line that a killed study had begun

    def add(self, flight: dict[str, Any]) -> None:
        """Keep a flight; of logs that need not be kept one for each cell of the matrix, the first."""
        keep = flight.pop("keep")
        if not keep and _cell(flight) in {_cell(other) for other in self.flights.values() if other["log"]}:
            log = self.logs.parent / flight["log"]
            for path in (log, place_of(log)):
                path.unlink(missing_ok=True)
            flight["log"] = ""
        self.flights[flight["key"]] = flight
        self._file.write(json.dumps(flight, allow_nan=False).encode() + b"\n")
        self._file.flush()

    def missing(self, jobs: Iterable[Job]) -> list[Job]:
        """Return the jobs that were not flown yet."""
        return [job for job in jobs if job.key not in self.flights]

    def of(self, jobs: Iterable[Job]) -> list[dict[str, Any]]:
        """Return the flights of these jobs, in their order; those that were not flown are left out."""
        return [self.flights[job.key] for job in jobs if job.key in self.flights]

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def _cell(flight: Mapping[str, Any]) -> tuple[str, int, str]:
    return flight["trial"], flight["onset"], flight["ending"]
