"""Through the bus: whole flights in SITL, with float16 on the wires, real rates, latency, dropouts, biases.

The vehicle file is right but for the ten, and the filter is told so; `honesty` flies files that are wrong in the rest.
"""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from firmware_py import config_files
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.model.state import MOVING
from firmware_py.guidance.excitation import PERIOD
from sternplane.identification.cramer_rao_bound import bound, true_states
from sternplane.logs.reading import Columns, Log, read
from sternplane.logs.tracking import Array
from sternplane.sitl.busless_flight import SENSOR_STD
from sternplane.sitl.flight import FlightRequest, fly, prepare
from sternplane.sitl.taken_settings import beside
from sternplane.study.figures import bars, over_bound, per_name, rms
from sternplane.study.laid_settings import settings_now
from sternplane.study.rows import Case, Results, RunArrays
from sternplane.study.setups import CONFIG, WRONG, starts, true_vehicle
from sternplane.study.wrong_vehicle import coefficients, overlay

DURATION = 61.0
"""s; the vehicle dives with its fins moving from 0.5 s on."""
SCENARIO = """
description = "The estimation study: PRBS at 60 m."
duration_s = {duration}
completes = "surfaced"
[environment]
bottom_depth_m = 100.0
[start]
depth_m = 60.0
u_m_s = 1.8
n_rpm = 492.0
[autopilot.safety]
depth_max_m = 80.0
[autopilot.estimation.coefficients]
nuisances = []
surge_noise = 0.0
roll_noise = 0.0
[[orders]]
t_s = 0.5
arming = "arm"
mode = "mission"
[[items]]
manoeuvre = {{ kind = "prbs", delta_s_deg = 15.0, delta_r_deg = 15.0, register = {register} }}
"""


def _run(seed: int, k: int) -> RunArrays:
    del k
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scenario = folder / "study.toml"
        text = SCENARIO.format(duration=DURATION, register=1 + seed % PERIOD)
        scenario.write_text(text + overlay(coefficients(starts(seed, WRONG))))
        settings = beside(text, settings_now())
        flight = prepare(FlightRequest(scenario=str(scenario), config=CONFIG, seed=seed, settings=settings), {})
        fly(flight, folder / "log.mcap")
        log = read(folder / "log.mcap")
        params = dataclasses.replace(flight.params.estimation.coefficients, turbulence=(0.0,))
        ekf = CoefficientEkf(config_files.vehicle(flight.configuration), params)
        return {**_learned(log), "bound": _bound(log, ekf)}


def _true(names: Sequence[str]) -> Array:
    return np.array([getattr(true_vehicle().coefficients, name) for name in names])


def _learned(log: Log) -> RunArrays:
    """Error and sigma at the end, as parts of the true values."""
    c, true = log.columns, _true(TEN)
    error = (c["state.learned.value"][-1] - true) / np.abs(true)
    return {"t": c["t"][-1:], "error": error, "std": c["state.learned.std"][-1] / np.abs(true)}


def _bound(log: Log, ekf: CoefficientEkf) -> Array:
    """1 sigma of the ten at the end, along what the vehicle really did, as parts of the true values."""
    c, truth, model = log.columns, log.truth, ekf.model
    t = c["t"]
    h = float(t[1] - t[0])
    moving = np.column_stack(
        [*(truth[f"nu.{name}"] for name in "uvwpqr"), *(truth[f"eta.{name}"] for name in ("phi", "theta", "psi"))]
    )
    fins = truth["fins"] @ np.array([fin.share for fin in true_vehicle().fins])
    acts = np.column_stack([fins, truth["n"]])
    came = np.zeros((len(t) - 1, MOVING), dtype=np.bool_)
    _mark(came[:, 3:], c, "frame.ahrs", h)
    _mark(came[:, :3], c, "frame.dvl", h)
    prior = ekf.prior.copy()
    prior[:MOVING] = SENSOR_STD
    x = true_states(model, moving, truth["current"][0, :2], _true(model.names))
    found = bound(model, x, 0.5 * (acts[1:] + acts[:-1]), h, came, SENSOR_STD, prior)
    part = slice(model.first, model.first + len(TEN))
    limit: Array = np.sqrt(np.diag(found)[part]) / np.abs(_true(TEN))
    return limit


def _mark(came: np.ndarray, c: Columns, sensor: str, h: float) -> None:
    """Row k is what was true at (k + 1) h; what arrived is marked where it was true."""
    fresh = c[f"{sensor}.fresh"] & c[f"{sensor}.ok"]
    rows = np.round(c[f"{sensor}.t_valid"][fresh] / h).astype(int) - 1
    came[rows[rows >= 0]] = True


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    name = f"through the bus, SITL on virtual, PRBS, file +-50 % off, {DURATION:g} s, AHRS 100 Hz, DVL 5 Hz, biases"
    error, limit = (np.array([run[key] for run in runs]) for key in ("error", "bound"))
    ratio, band, rows = over_bound(name, "RMS over bound", error, limit)
    rows += per_name(name, "RMS error, %", 100.0 * rms(error), None)
    note = f"Whole flights by the autopilot: float16, real rates, latency, dropouts, biases; the line is {band[1]:.2f}."
    return Results(rows, [bars("Through the bus: RMS over bound", note, "RMS / bound", {"SITL": ratio}, (band[1],))])


CASES = (
    Case(
        "through the bus",
        "Whole flights on the virtual bus with a vehicle file whose ten are 50 % off, learned by the autopilot itself.",
        *(_run, _evaluate, 40, 2),
    ),
)
