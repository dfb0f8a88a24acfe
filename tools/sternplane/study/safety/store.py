"""The flights of a campaign in a file: one line of JSON each, written when the flight is over; and their logs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.regular_file import FolderError, make_folder
from firmware_py.run.usage_error import UsageError
from sternplane.campaign.line_store import LineStore
from sternplane.logs.after_log import place_of
from sternplane.study.safety.campaign import Job

FILE = "flights.jsonl"
LOGS = "logs"


class Store(LineStore):
    """What was flown already, and what is flown now.

    Args:
        folder: of the study.

    Raises:
        UsageError: the file cannot be read or written.
    """

    def __init__(self, folder: Path) -> None:
        self.logs = folder / LOGS
        try:
            make_folder(self.logs)
        except FolderError as error:
            raise UsageError(f"{error}; choose another --out") from None
        super().__init__(folder / FILE)
        self._logged = {_cell(flight) for flight in self.rows() if flight["log"]}

    def add(self, row: dict[str, Any]) -> None:
        """Keep a flight; of logs that need not be kept one for each cell of the matrix, the first."""
        keep, cell = row.pop("keep"), _cell(row)
        if not keep and cell in self._logged:
            log = self.logs.parent / row["log"]
            for path in (log, place_of(log)):
                path.unlink(missing_ok=True)
            row["log"] = ""
        if row["log"]:
            self._logged.add(cell)
        super().add(row)

    def missing(self, jobs: Iterable[Job]) -> list[Job]:
        """Return the jobs that were not flown yet."""
        return [job for job in jobs if job.key not in self.keys]


def _cell(flight: Mapping[str, Any]) -> tuple[str, int, str]:
    return flight["trial"], flight["onset"], flight["ending"]
