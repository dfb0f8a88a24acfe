"""Fig. 9 and 10: depth and heading under laws designed from the EKF's coefficients, the SMO's, the true ones, and PID.

Each is a flight of a scenario in the simulator, bus and servos included, by a vehicle in a folder of its own, so that
anybody can fly it again: `sternplane sitl --config DIR/vehicles/smo --scenario paper-depth`.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.params import ParamError
from firmware_py.records.cycle import Cycle
from firmware_py.run.usage_error import UsageError
from sternplane.identification import vehicle_file
from sternplane.logs.reading import Columns, read
from sternplane.logs.tracking import Array, true_columns
from sternplane.sitl.flight import CONFIG, FlightRequest, fly, prepare

SCENARIOS = {"fig9": "paper-depth", "fig10": "paper-heading"}
EVERY = 10
"""So many cycles make a point of a figure."""
BAND = 0.05
"""Settled is within this part of the metre."""
LEARNED = ("ekf", "smo")
"""Who learned coefficients."""
IDEAL = "ideal"
"""The vehicle with true coefficients whose servos hardly lag: to see what servos do to the paper's gains."""
_LAW = ('law = "sliding"', 'law = "pid"')
_SERVO = ("tau_s = 0.1\nrate_deg_s = 40.0\nbacklash_deg = 0.1", "tau_s = 0.01\nrate_deg_s = 1000.0\nbacklash_deg = 0.0")


class FlightError(Exception):
    """A flight did not end as it should."""


class StepFlight(NamedTuple):
    """What is drawn of a flight, at 10 Hz, by name: t (s), m and degrees; and its figures."""

    columns: dict[str, Array]
    figures: dict[str, float | None]


def vehicles(folder: Path, estimates: Mapping[str, Mapping[str, float]], config: Path = CONFIG) -> dict[str, Path]:
    """Makes a configuration for every set of coefficients, "pid" and IDEAL: by name, where it is.

    Raises:
        ParamError: coefficients that no vehicle can have.
        UsageError: the folder cannot be written.
    """
    made = {}
    for name, values in {**estimates, "pid": {}, IDEAL: {}}.items():
        made[name] = place = folder / name
        try:
            place.mkdir(parents=True, exist_ok=True)
            for path in config.glob("*.toml"):
                shutil.copyfile(path, place / path.name)
            if name == "pid":
                _change(place / "autopilot.toml", *_LAW)
            if name == IDEAL:
                _change(place / "truth.toml", *_SERVO)
        except OSError as error:
            raise UsageError(f"{place}: cannot be written ({error.strerror}); choose another --out") from None
        table = read_toml(config / "vehicle.toml")
        table["coefficients"] = {**table["coefficients"], **values}
        origin = f"as the {name.upper()} learned them in the paper's scenario" if name in LEARNED else "as they are"
        comment = f"For `sternplane paper`: {config.name}, with the ten coefficients {origin}."
        vehicle_file.write(place / "vehicle.toml", table, comment)
    return made


def fly_step(
    scenario: str, config: Path, folder: Path, watch: Callable[[Cycle], None], settings: tuple[str, ...] = ()
) -> StepFlight:
    """Flies, leaving a log; the step is one of the path if the mission has such, else one of the depth.

    Raises:
        ParamError: a law that cannot be designed.
        FlightError: it did not end as it should.
        KeyboardInterrupt: the user has had enough.
    """
    folder.mkdir(parents=True, exist_ok=True)
    outcome = fly(prepare(FlightRequest(scenario, config, settings=settings), {}), folder / "log.mcap", watch)
    if outcome.reason == "interrupted":
        raise KeyboardInterrupt
    if not outcome.completed:
        raise FlightError(f"{scenario} with {config}: {outcome.reason}")
    log = read(folder / "log.mcap")
    c, truth = log.columns, true_columns(log)
    waypoints = log.header["mission"]["waypoints"]
    return _turn(c, truth, waypoints) if len({y for _, y, _, _ in waypoints}) > 1 else _dive(c, truth)


def _dive(c: Columns, truth: Columns) -> StepFlight:
    more = {"pitch": np.degrees(truth["eta.theta"]), "rate": np.degrees(truth["nu.q"]), "sigma": c["demand.sigma_z"]}
    begin = c["reference.z_d"][0]
    return _flown(c["t"], c["reference.z_d"] - begin, truth["eta.z"] - begin, np.degrees(c["demand.delta_s"]), more)


def _turn(c: Columns, truth: Columns, waypoints: list[list[float]]) -> StepFlight:
    path = np.array([y for _, y, _, _ in waypoints])
    wanted = path[np.minimum(c["reference.waypoint"], len(path) - 1)]
    more = {
        "heading": np.degrees(truth["eta.psi"]),
        "rate": np.degrees(truth["nu.r"]),
        "sway": truth["nu.v"],
        "sigma": np.degrees(c["demand.sigma_psi"]),
    }
    return _flown(c["t"], wanted, truth["eta.y"], np.degrees(c["demand.delta_r"]), more)


def _flown(t: Array, wanted: Array, way: Array, fin: Array, more: dict[str, Array]) -> StepFlight:
    drawn = {"t": t, "wanted": wanted, "way": way, "fin": fin, **more}
    thinned = {name: np.ascontiguousarray(column[::EVERY]) for name, column in drawn.items()}
    return StepFlight(thinned, step_figures(t, wanted, way, fin))


def step_figures(t: Array, wanted: Array, way: Array, fin: Array) -> dict[str, float | None]:
    """A step of `wanted` from 0 to 1 m and back: how long it took, how far it went over, what the fin did for it.

    Args:
        t: s.
        wanted: m.
        way: m, what came of it.
        fin: degrees.
    """
    over = np.flatnonzero(wanted > 0.5)
    begin, back = int(over[0]), int(over[-1]) + 1
    return {
        "settling_s": _settled(t[begin:back], way[begin:back] - 1.0),
        "settling_back_s": _settled(t[back:], way[back:]),
        "overshoot_pct": 100.0 * max(float(np.max(way[begin:back])) - 1.0, 0.0),
        "overshoot_back_pct": 100.0 * max(-float(np.min(way[back:])), 0.0),
        "rms_m": float(np.sqrt(np.mean((way - wanted)[begin:] ** 2))),
        "fin_max_deg": float(np.max(np.abs(fin[begin:]))),
        "fin_travel_deg_s": float(np.sum(np.abs(np.diff(fin[begin:]))) / (t[-1] - t[begin])),
    }


def _settled(t: Array, off: Array) -> float | None:
    """How long until it was last out of the band; None if it still was at the end."""
    out = np.flatnonzero(np.abs(off) > BAND)
    if not out.size:
        return 0.0
    return float(t[out[-1] + 1] - t[0]) if out[-1] + 1 < len(t) else None


def _change(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    if text.count(old) != 1:
        raise ParamError(f"{path}: should have this once: {old!r}")
    path.write_text(text.replace(old, new), encoding="utf-8")
