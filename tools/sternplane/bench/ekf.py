"""What a step of the coefficient filter costs beside the same step in C (`ekf_step.c`), of one derivation.

It is `bank.step`. Both run over the same flight, in turns of a fraction of a millisecond, each inside compiled code, so
that whatever else the machine does troubles them alike. Their numbers are equal to the last bit; a test holds that.
What a call of `CoefficientEkf.step` from Python costs, all included, stands apart.
"""

from __future__ import annotations

import ctypes
import shutil
import statistics
import subprocess
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from firmware_py import params
from firmware_py.adapters.installation import ROOT, configs
from firmware_py.compiled import kernel
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.filter import bank
from firmware_py.estimation.filter.start_up import FLOOR, GROWTH, LEARNS, MAY
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import GROUPS, ObserverModel
from firmware_py.estimation.model.transition import MOVING, Picks
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.bench.lateness import NoCompiler
from sternplane.codegen import derive_c

SOURCE = Path(__file__).with_name("ekf_step.c")
FOLDER = ROOT / "build" / "ekf_step"
FLAGS = ("-std=c99", "-O3", "-march=native", "-ffp-contract=off")
NS = 1e-3
"""ns to us."""

H = 0.01
"""Step, s."""
CASES = {
    "19 states": CoefficientParams(current=False),
    "21 states": CoefficientParams(),
    "29 states": CoefficientParams(names=(*TEN, *GROUPS, "C_dy", "C_dz")),
    "bank of 5 by 24 states": CoefficientParams(turbulence=(0.0, 0.01, 0.02, 0.04, 0.08)),
}
SPEED, N = 1.8288, 500.0 / 60.0
"""Where the flight begins, m/s and rev/s."""
STD = np.array([0.01] * 3 + [0.001] * 3 + [0.005] * 3)
"""Noise of u v w p q r phi theta psi, 1 sigma, m/s, rad/s, rad; the first three come with every DVL_EVERY-th step."""
DVL_EVERY = 20
SWITCH_EVERY = 50
"""Steps between draws of the fins, each 0.2 rad to one side or the other."""
TURN = 100
"""Steps of a turn, over all members of a bank: so short that most turns are through before others get the processor."""


Run = Callable[[Array, Array, Array, Array], int]
"""(inputs, z, variance, nis) -> how many steps were made."""


class Flight(NamedTuple):
    """What a filter is given, a row a step; see `CoefficientEkf.run`."""

    inputs: Array
    z: Array


@kernel(f"i8({bank.MODEL},{bank.BANK},f8[:,::1],f8,f8[:,::1],f8[::1],f8[:,::1],i8[::1])")
def loop(
    c: Array, inverse: Array, picks: Picks, weight: Array, water: int, first: int, heavy: bool, work: Array, y: Array,
    room: Array, rules: Array, bias: Picks, eddy_time: float, memory: float, gate: float, eddies: Array, x: Array,
    P: Array, evidence: Array, weights: Array, inputs: Array, h: float, z: Array, variance: Array, nis: Array,
    rejected: Picks,
) -> int:  # fmt: skip
    """`bank.step` over the rows of inputs, z and nis; how many were made."""
    for k in range(len(inputs)):
        if not bank.step(
            c, inverse, picks, weight, water, first, heavy, work, y, room, rules, bias, eddy_time, memory, gate,
            eddies, x, P, evidence, weights, inputs[k], h, z[k], variance, nis[k], rejected,
        ):  # fmt: skip
            return k
    return len(inputs)


class InNumba:
    """A filter whose steps are made by `bank.step`, without what `CoefficientEkf.run` does between them."""

    def __init__(self, ekf: CoefficientEkf) -> None:
        self.ekf = ekf

    def run(self, inputs: Array, z: Array, variance: Array, nis: Array) -> int:
        """Steps over the rows, filling nis, (K, 9); how many were made."""
        steps: int = loop(*self.ekf.bank.arguments(inputs, H, z, variance, nis, self.ekf.rejected))
        return steps


class Bank(ctypes.Structure):
    """The structure of this name in ekf_step.c."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("n", "width", "members", "picked", "drift", "first", "heavy")),
        *((name, ctypes.c_double) for name in ("eddy_time", "memory", "gate")),
        *((name, ctypes.c_void_p) for name in ("c", "inverse", "picks", "weight", "y", "room", "rules", "bias")),
        *((name, ctypes.c_void_p) for name in ("eddies", "x", "P", "evidence", "weights", "rejected")),
    )


class InC:
    """A filter whose steps are made in C, on its own arrays."""

    def __init__(self, library: ctypes.CDLL, ekf: CoefficientEkf) -> None:
        self.ekf = ekf
        self._run = library.run
        c, inverse, picks, weight, drift, first, heavy, _, y, room, rules, bias, *rest = ekf.bank.arguments()
        eddy_time, memory, gate, eddies, x, P, evidence, weights = rest
        members, n, width = P.shape
        arrays = (c, inverse, picks, weight, y, room, rules, bias, eddies, x, P, evidence, weights, ekf.rejected)
        self._bank = Bank(
            *(n, width, members, len(weight), drift, first, heavy),
            *(eddy_time, memory, gate),
            *(array.ctypes.data for array in arrays),
        )

    def run(self, inputs: Array, z: Array, variance: Array, nis: Array) -> int:
        """Steps over the rows, filling nis, (K, 9); how many were made."""
        steps: int = self._run(
            *(ctypes.byref(self._bank), ctypes.c_int64(len(inputs)), inputs.ctypes, ctypes.c_double(H)),
            *(z.ctypes, variance.ctypes, nis.ctypes),
        )
        return steps


def measure(rounds: int = 4, seconds: int = 20) -> dict[str, Any]:
    """A step of each of CASES in both languages, us, as JSON: medians over the turns, and their ratio.

    Args:
        rounds: how often the flight is gone through.
        seconds: its length.
    """
    missing, library = "", None
    try:
        library = compiled(FOLDER)
    except NoCompiler as error:
        missing = str(error)
    return {name: _case(case, library, missing, rounds, seconds) for name, case in CASES.items()}


def compiled(folder: Path, *flags: str) -> ctypes.CDLL:
    """The C step, derived and compiled into a folder.

    Raises:
        NoCompiler: there is no cc, or it does not compile this.
    """
    cc, library = shutil.which("cc"), folder / "ekf_step.so"
    if cc is None:
        raise NoCompiler("no C compiler (cc) on this machine")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "jacobians.h").write_text(derive_c.generate())
    command = [cc, *FLAGS, *flags, "-fPIC", "-shared", f"-I{folder}", "-o", str(library), str(SOURCE), "-lm"]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if built.returncode:
        raise NoCompiler(f"cc cannot compile {SOURCE.name}: {built.stderr.strip().partition(chr(10))[0]}")
    loaded = ctypes.CDLL(str(library))
    loaded.run.restype = ctypes.c_int64
    return loaded


def settled(case: CoefficientParams) -> CoefficientEkf:
    """As `begun`, but with the rules that hold when the beginning is over: both languages take them as they are."""
    ekf = begun(case)
    ekf.rules[GROWTH], ekf.rules[LEARNS] = ekf.rules[FLOOR], ekf.rules[MAY]
    return ekf


def begun(case: CoefficientParams) -> CoefficientEkf:
    """A filter of the vehicle, at the beginning of the flight."""
    table = tomllib.loads((configs() / "npsauv2" / "vehicle.toml").read_text())
    ekf = CoefficientEkf(params.load(Vehicle, table, "vehicle.toml"), case)
    ekf.start((SPEED, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), STD)
    return ekf


def flight(model: ObserverModel, steps: int, seed: int = 1, noise: float = 1.0) -> Flight:
    """The believed vehicle under fins that switch at random, as its sensors see it; `noise` is a share of STD."""
    rng = np.random.default_rng(seed)
    inputs, z = np.zeros((steps, 4)), np.zeros((steps, MOVING))
    sides = rng.choice((-0.2, 0.2), (steps // SWITCH_EVERY + 1, 2))
    inputs[:, :2] = np.repeat(sides, SWITCH_EVERY, axis=0)[:steps]
    inputs[:, 3] = N
    x = model.state((SPEED, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    for k in range(steps):
        model.advance(x, inputs[k], H)
        z[k] = x[:MOVING] + noise * STD * rng.standard_normal(MOVING)
    z[np.arange(steps) % DVL_EVERY != 0, :3] = np.nan
    return Flight(inputs, z)


def _case(case: CoefficientParams, library: ctypes.CDLL | None, missing: str, rounds: int, seconds: int) -> Any:
    inputs, z = flight(begun(case).model, seconds * 100)
    rows, variance = TURN // len(case.turbulence), STD**2
    nis = np.zeros((rows, MOVING))
    times: dict[str, list[float]] = {name: [] for name in ("numba", *(("c",) if library else ()), "called from python")}
    for _ in range(rounds):
        runs: dict[str, Run] = {"numba": InNumba(settled(case)).run}
        if library:
            runs["c"] = InC(library, settled(case)).run
        for k in range(0, len(inputs), rows):
            for name, run in runs.items():
                began = time.perf_counter_ns()
                run(inputs[k : k + rows], z[k : k + rows], variance, nis)
                times[name].append((time.perf_counter_ns() - began) / rows)
        ekf = begun(case)
        for row, heard in zip(inputs, z, strict=True):
            began = time.perf_counter_ns()
            ekf.step(row, H, heard, variance)
            times["called from python"].append(time.perf_counter_ns() - began)
    return table({name: statistics.median(values) * NS for name, values in times.items()}, missing)


def table(medians: dict[str, float], missing: str) -> dict[str, Any]:
    """A case's medians, us, and the ratio; or why there is no C."""
    rounded = {f"{name} us": round(us, 2) for name, us in medians.items()}
    if missing:
        return {**rounded, "c us": f"not measured: {missing}"}
    return {**rounded, "numba over c": round(medians["numba"] / medians["c"], 2)}
