"""One flight of a sweep, in any process of any computer: files and settings in, one row out."""

from __future__ import annotations

import functools
import platform
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import walk_tb
from typing import Any

from firmware_py.error_text import one_line
from firmware_py.run.usage_error import UsageError
from sternplane.sweep.accused import FOUND
from sternplane.sweep.plan import Job

SCENARIO_FILE = "scenario.toml"
_LEFT_OUT = frozenset(
    {
        *("wall_time_s", "speed_up", "late_cycles", "lateness", "losses", "losses_seen_s", "received"),
        *(
            "scenario",
            "seed",
            "complete",
            "lost",
            "after_log",
            "settings",
            "faults",
            "faults_not_begun",
            "notes",
            "events",
            "adoption_off",
        ),
    }
)
"""Of the summary: what the computer's speed decides, and what no table holds."""
_TRIES = 3
"""So often a flight is begun that a busy computer has made one that cannot be reproduced."""
_ONE = threading.Lock()
"""One flight at a time in a process: a worker of a cluster may have several threads."""


def fly_row(job: Job, inputs: Mapping[str, bytes], keep: str | None = None) -> dict[str, Any]:
    """Fly once; return the row: number, values, and all figures of its summary that a table can hold.

    A flight that cannot be flown, say for a value out of bounds, has its error in the row.

    Args:
        job: what to fly.
        inputs: the files, by name: of the configuration, and scenario.toml.
        keep: where its log is left; None is nowhere.

    Raises:
        BusError, LogError, UsageError: what the computer lacks, such as a part of one's own, and no flight is to blame
            for.
    """
    try:
        with _ONE, TemporaryDirectory() as name:
            folder = Path(name)
            for file, content in inputs.items():
                (folder / file).write_bytes(content)
            return {**_begun(job), **_flown(job, folder, keep)}
    except (OSError, MemoryError) as error:
        why = getattr(error, "strerror", None) or type(error).__name__
        raise UsageError(f"flight {job.flight} on {platform.node()}: {why}; start it again to go on") from None


@functools.cache
def _made_by() -> dict[str, str]:
    """Return which code, and which processor: both decide the bits of a flight."""
    from firmware_py.run import provenance, version

    return {"revision": version.git_revision(), "cpu": provenance.fingerprint()["cpu"]}


def died_row(job: Job, why: str) -> dict[str, Any]:
    """Return the row of a flight that no process survives."""
    return {**_begun(job), "completed": False, "error": why}


def _begun(job: Job) -> dict[str, Any]:
    values = {key: list(value) if isinstance(value, tuple) else value for key, value in job.values.items()}
    numbers = {"flight": job.flight, "sample": job.sample, "seed": job.seed, "law": job.law}
    return {"key": str(job.flight), **numbers, **values}


def _flown(job: Job, folder: Path, keep: str | None) -> dict[str, Any]:
    from firmware_py.adapters.buses.can_bus import BusError
    from firmware_py.adapters.storage.recorder import LogError
    from sternplane.logs.streaming import stream
    from sternplane.logs.summary import summarise
    from sternplane.sitl.flight import NOT_REPRODUCIBLE, FlightRequest, fly, prepare

    made_by = _made_by()
    request = FlightRequest(
        str(folder / SCENARIO_FILE), folder, seed=job.seed, faults=job.faults, settings=job.settings
    )
    log = folder / "log.mcap"
    try:
        for _ in range(_TRIES):
            outcome = fly(prepare(request, {}), log)
            if outcome.reason == "interrupted":
                raise KeyboardInterrupt
            if NOT_REPRODUCIBLE not in outcome.reason:
                break
        summary = summarise(stream(log))
    except (LogError, BusError, OSError, MemoryError):
        raise
    except Exception as error:
        said = one_line(str(error).replace(f"{folder}/", ""))
        if _is_of_finding(error):
            where = f"flight {job.flight} on {platform.node()}"
            raise UsageError(
                f"{where}: {said[:300]}; install it on that computer, and start it again to go on"
            ) from None
        return {"completed": False, "error": f"{type(error).__name__}: {said}"[:300], **made_by}
    if keep is not None:
        place = Path(keep)
        place.parent.mkdir(parents=True, exist_ok=True)
        part = place.with_name(f"{place.name}.part")
        part.write_bytes(log.read_bytes())
        part.replace(place)
    found = "; ".join(dict.fromkeys(one["text"] for one in summary["found"] if not one["known"]))
    return {**dict(_flat(summary)), FOUND: found, "error": "", **made_by}


def _is_of_finding(error: BaseException | None) -> bool:
    """Return whether an error came about where a part of one's own was looked for: that computer lacks it."""
    from firmware_py.adapters.own_parts import find

    while error is not None:
        if any(frame.f_code is find.__code__ for frame, _ in walk_tb(error.__traceback__)):
            return True
        error = error.__cause__
    return False


def _flat(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield what a table of rows can hold, by names with dots; of a list of numbers each by its place."""
    for key, value in table.items():
        if not before and key in _LEFT_OUT:
            continue
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{key}.")
        elif isinstance(value, list | tuple):
            if all(isinstance(one, int | float) for one in value):
                yield from _flat({str(i): one for i, one in enumerate(value)}, f"{before}{key}.")
        else:
            yield f"{before}{key}", value
