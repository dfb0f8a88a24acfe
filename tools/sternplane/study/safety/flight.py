"""One flight of the campaign, flown and judged in a process of its own."""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path
from typing import Any

from firmware_py import app
from firmware_py.adapters.installation import configs
from sternplane.logs.reading import read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import Flight, FlightRequest, fly, prepare
from sternplane.sitl.taken_settings import beside
from sternplane.study.safety.campaign import TRIALS, Job
from sternplane.study.safety.judge import Ending, Judge
from sternplane.study.safety.mission import DEPTH_MAX, NPS, patience, quiet_scenario, scenario
from sternplane.study.safety.verdict import is_alarmed, judge


def run(job: Job, logs: str, revision: str, settings: tuple[str, ...] = ()) -> dict[str, Any]:
    """Fly one job, leave its log in `logs`, and return what is known of it; `keep`: its log is not to be deleted."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "study.toml"
        text = written(job)
        file.write_text(text, encoding="utf-8")
        config = configs() / vehicle_of(job)
        io = with_bar30(config, Path(name)) if job.trial and TRIALS[job.trial].coarse else None
        laid = beside(text, settings)
        request = FlightRequest(scenario=str(file), config=config, seed=job.seed, io=io, settings=laid)
        flight = prepare(request, {})
        witness = _judge(flight, job)
        log = Path(logs) / job.file
        outcome = fly(flight, log, witness=witness)
        if outcome.reason == "interrupted":
            raise KeyboardInterrupt
        found = witness.found
        found.aground = "aground" in outcome.reason
        found.not_finite += "no longer finite" in outcome.reason
        ending = found.ending(DEPTH_MAX)
        if not job.trial and ending is Ending.LOST:
            ending = Ending.FLOWN  # it flies to its last second, and has no need to come up
        replayed = _replayed(log) if job.replay else ""
    row = {
        "key": job.key,
        "trial": job.trial,
        "onset": job.onset,
        "seed": job.seed,
        "eddies": job.eddies,
        "learning": job.learning,
        "revision": revision,
        "ending": ending.value,
        "log": f"{log.parent.name}/{log.name}",
        "replay": replayed,
        "outcome": outcome.reason,
        "cpu_s": round(time.process_time() - began, 2),
        "found": found.plain(),
    }
    wrong = judge(row).wrong if job.trial else is_alarmed(row)
    return row | {"keep": job.keep or ending.unsafe or wrong or replayed not in ("", "equal")}


def written(job: Job) -> str:
    """Return the scenario of a job."""
    if not job.trial:
        return quiet_scenario(job.duration, eddies=job.eddies, learning=job.learning)
    trial = TRIALS[job.trial]
    return scenario(
        trial.at(job.onset),
        eddies=job.eddies,
        learning=job.learning,
        profile=trial.profile,
        watch=trial.watch,
        vehicle=trial.vehicle,
        afloat=trial.afloat,
        coarse=trial.coarse,
        speed=trial.speed,
        bottom=trial.bottom,
    )


def vehicle_of(job: Job) -> str:
    """Return the name of the configuration that flies."""
    return TRIALS[job.trial].vehicle if job.trial else NPS


def with_bar30(config: Path, folder: Path) -> Path:
    """Write the io file of a vehicle that measures pressure by a Bar30 in place of a node, and return its place."""
    nodes = [line for line in (config / "io_sitl.toml").read_text().splitlines() if not line.startswith("pressure = ")]
    file = folder / "io.toml"
    file.write_text("\n".join([*nodes, "[[instruments]]", 'driver = "bar30"', 'port = "i2c:1"', ""]))
    return file


def _judge(flight: Flight, job: Job) -> Judge:
    hull, trial = flight.truth.hull, TRIALS.get(job.trial)
    onset, until = (trial.begins(job.onset), patience(trial.vehicle, trial.speed)) if trial else (0.0, math.inf)
    return Judge(flight.scenario.environment, onset, hull.L, hull.height, flight.scenario.watch, until)


def _replayed(log: Path) -> str:
    result = replay(read(log), app.build)
    return "equal" if result.equal else str(result)
