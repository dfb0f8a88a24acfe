"""Is a value right that is called valid: two hulls, whole flights, vehicle files that are wrong in one thing each.

What a law may rely on is `valid`, so this alone is judged: how many valid values are off by more than `FAR` of their
own sigmas. The file of a flight is off to sides that are drawn by its seed.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.model.observer_model import GROUPS
from firmware_py.guidance.excitation import PERIOD
from firmware_py.vehicle.coefficients import Coefficients
from sternplane.logs.reading import read
from sternplane.logs.true_coefficients import truth
from sternplane.sitl.flight import FlightRequest, fly, prepare
from sternplane.sitl.taken_settings import beside
from sternplane.study.chance import share_of
from sternplane.study.laid_settings import settings_now
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.wrong_vehicle import Factors, coefficients, overlay

FAR, SHARE = 4.0, 0.01
"""A valid value is off if it is so many sigmas from the truth; and the share of such that is allowed."""
DURATION = 80.0
"""s; the first pass through the flight takes over at some 30 s."""
UNKNOWN_MAX = 3.0
"""Coefficients of a flight, of ten, that are not valid at its end, on average: honesty by silence is none."""
SCENARIO = """
description = "The estimation study: is valid right."
duration_s = {duration}
completes = "time"
[environment]
{water}
bottom_depth_m = 70.0
[start]
depth_m = 30.0
u_m_s = {u}
n_rpm = {n}
[autopilot.safety]
depth_max_m = 50.0
[[orders]]
t_s = 0.5
arming = "arm"
mode = "mission"
[[items]]
manoeuvre = {{ kind = "prbs", {fins}, register = {register} }}
"""

Tables = Mapping[str, Any]
Signs = Callable[[], float]


class Hull(NamedTuple):
    """A configuration, and how it is flown."""

    folder: str
    u: float
    n: float
    fins: str


class Wrong(NamedTuple):
    """One way in which a vehicle file is wrong."""

    hull: Hull
    label: str
    factors: Callable[[Tables, Signs], Factors]
    water: str = "current_ned_m_s = [0.06, 0.08, 0.0]"
    unknown_max: float | None = UNKNOWN_MAX


NPS = Hull("npsauv2", 1.8, 492.0, "delta_s_deg = 15.0, delta_r_deg = 15.0")
EDDIES = "current_ned_m_s = [0.12, 0.16, 0.0]\nturbulence_m_s = 0.05"
"""Water of a scenario: eddies, in a current of 0.2 m/s."""
BETWEEN = "current_ned_m_s = [0.06, 0.08, 0.0]\nturbulence_m_s = 0.03"
"""Water with eddies between two intensities of the bank, in a current of 0.1 m/s."""
REMUS = Hull("remus100", 1.5, 1461.0, "delta_s_deg = 3.0, delta_r_deg = 5.0, clock_s = 1.0")


def signs(seed: int) -> Signs:
    """Return what draws -1 or 1, again and again, for the file of a flight."""
    sides = np.random.default_rng([seed, *b"file"])
    return lambda: float(sides.choice((-1.0, 1.0)))


def _off(names: Iterable[str], share: float, sign: Signs) -> Mapping[str, float]:
    return {name: 1.0 + share * sign() for name in names}


def nothing(tables: Tables, sign: Signs) -> Factors:
    """Leave the file as it is."""
    del tables, sign
    return {}


def ten(share: float) -> Callable[[Tables, Signs], Factors]:
    """Return what makes the ten wrong by a share of each."""

    def factors(tables: Tables, sign: Signs) -> Factors:
        del tables
        return coefficients(_off(TEN, share, sign))

    return factors


def added_mass(tables: Tables, sign: Signs) -> Factors:
    """Make the added mass wrong by 20 %, to one side in each equation."""
    del tables
    sides = [(members, sign()) for members in GROUPS.values()]
    return coefficients({name: 1.0 + 0.2 * side for members, side in sides for name in members})


def rest(tables: Tables, sign: Signs) -> Factors:
    """Make every coefficient wrong by 20 % that is neither one of the ten nor added mass."""
    names = (name for name in tables["coefficients"] if name not in TEN and not name.endswith("dot"))
    return coefficients(_off(names, 0.2, sign))


def drag(tables: Tables, sign: Signs) -> Factors:
    """Make the drag wrong by 20 %: along, across, and that of the fins."""
    del tables
    wrong = {"propeller": ("C_d0",), "hull": ("C_dy", "C_dz"), "coefficients": ("X_dsds", "X_drdr")}
    return {table: _off(names, 0.2, sign) for table, names in wrong.items()}


def buoyancy(tables: Tables, sign: Signs) -> Factors:
    """Make the buoyancy wrong by 1 %."""
    del tables
    return {"body": _off(("buoyancy_n",), 0.01, sign)}


WAYS = (
    Wrong(NPS, "the rest +-20 %", rest),
    Wrong(REMUS, "the ten +-30 %", ten(0.3)),
    Wrong(NPS, "added mass +-20 %", added_mass),
    Wrong(REMUS, "right", nothing),
    Wrong(REMUS, "right, eddies of 0.03 m/s", nothing, BETWEEN, None),
    Wrong(NPS, "drag +-20 %", drag),
    Wrong(NPS, "the ten +-50 %", ten(0.5)),
    Wrong(REMUS, "the rest +-20 %", rest),
    Wrong(NPS, "the ten +-30 %", ten(0.3)),
    Wrong(REMUS, "added mass +-20 %", added_mass),
    Wrong(REMUS, "drag +-20 %", drag),
    Wrong(NPS, "right", nothing),
    Wrong(NPS, "buoyancy +-1 %", buoyancy),
    Wrong(REMUS, "buoyancy +-1 %", buoyancy),
    Wrong(NPS, "the rest +-20 %, eddies", rest, EDDIES),
    Wrong(NPS, "the ten +-30 %, eddies", ten(0.3), EDDIES),
    Wrong(NPS, "the ten +-30 %, eddies of 0.03 m/s", ten(0.3), BETWEEN),
    Wrong(REMUS, "right, eddies", nothing, EDDIES, None),  # they take more than 80 s of this hull
)


class Judged(NamedTuple):
    """A flight: whether it was completed; by how many sigmas the ten are off, and which are valid, (cycles, 10)."""

    completed: bool
    off: np.ndarray
    valid: np.ndarray


def judged(scenario: str, vehicle: str, factors: Callable[[Tables, Signs], Factors], seed: int) -> Judged:
    """Fly a scenario with a wrong vehicle file; judge what is learned by the plant, faults included."""
    shipped = configs() / vehicle
    true = read_toml(shipped / "vehicle.toml")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        file = folder / "study.toml"
        file.write_text(scenario + overlay(factors(true, signs(seed))))
        settings = beside(scenario, settings_now())
        request = FlightRequest(scenario=str(file), config=shipped, seed=seed, settings=settings)
        outcome = fly(prepare(request, {}), folder / "log.mcap")
        log = read(folder / "log.mcap")
        c = log.columns
    absent = dict.fromkeys((each.name for each in fields(Coefficients)), 0.0)
    believed = {**absent, **true["coefficients"], **{key: log.header["truth"][key] for key in ("density", "length")}}
    built = truth(log.header, believed, c["t"])
    right = np.column_stack([built[name] for name in TEN])
    off = (c["state.learned.value"] - right) / c["state.learned.std"]
    return Judged(outcome.completed, off, c["state.learned.valid"].astype(bool))


def _run(seed: int, k: int) -> RunArrays:
    way = WAYS[k % len(WAYS)]
    hull = way.hull
    fields = {
        "water": way.water,
        "duration": DURATION,
        "u": hull.u,
        "n": hull.n,
        "fins": hull.fins,
        "register": 1 + seed % PERIOD,
    }
    completed, off, valid = judged(SCENARIO.format(**fields), hull.folder, way.factors, seed)
    return {
        "way": np.array(k % len(WAYS)),
        "completed": np.array(completed),
        "z": np.abs(off[-1]),
        "valid": valid[-1],
        "ever": np.nanmax(np.where(valid, np.abs(off), 0.0), axis=0),
    }


def far(runs: Sequence[Mapping[str, np.ndarray]]) -> tuple[int, int]:
    """Return how many values are valid at the end, and how many of these are off by more than FAR sigmas."""
    valid = [run["valid"] for run in runs]
    return int(np.sum(valid)), int(np.sum([(run["z"] > FAR) & run["valid"] for run in runs]))


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    case = f"valid values, two hulls, SITL on virtual, PRBS, current 0.1 m/s, in eddies 0.2 m/s, {DURATION:g} s"
    count, wrong = far(runs)
    failed = sum(not run["completed"] for run in runs)
    share, most = wrong / max(count, 1), share_of(max(count, 1), SHARE)
    rows = [
        Row(case, f"share of the valid values beyond {FAR:g} sigma, all flights", share, most, len(runs)),
        Row(case, "flights that were not completed", float(failed), 0.0),
    ]
    for i, way in enumerate(WAYS):
        of_way = [run for run in runs if int(run["way"]) == i]
        if not of_way:
            continue
        name, n = f"{way.hull.folder}, {way.label}", len(of_way)
        z = [float((run["z"] * run["valid"]).max()) for run in of_way]
        unknown = 10.0 - far(of_way)[0] / n
        rows.append(Row(case, f"{name}: coefficients that are not valid, of ten", unknown, way.unknown_max, n))
        rows.append(Row(case, f"{name}: greatest valid value off, sigmas", max(z)))
        ever = max(float(run["ever"].max()) for run in of_way)
        rows.append(Row(case, f"{name}: the same at any time of the flights", ever))
    return Results(rows)


CASES = (
    Case(
        "valid is right",
        "Whole flights of two hulls, NPS AUV II and REMUS 100, with vehicle files that are wrong in the ten, in added "
        "mass, in drag, in buoyancy, or in everything else, some in eddies of 0.05 or 0.03 m/s; what is called valid "
        "is held against the truth.",
        *(_run, _evaluate, 10 * len(WAYS), 6),
    ),
)
