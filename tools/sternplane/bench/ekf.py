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
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.filter.kernel_arguments import Given
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.observer_model import GROUPS, ObserverModel
from firmware_py.estimation.model.state import MOVING
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.bench.ekf_loop import loop
from sternplane.bench.lateness import NoCompiler

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
"""Steps of a turn, over all filters of a bank: so short that most turns are through before others get the processor."""


Run = Callable[[Array, Array, Array, Array], int]
"""(inputs, z, variance, nis) -> how many steps were made."""


class FilterInputs(NamedTuple):
    """What a filter is given, a row a step; see `CoefficientEkf.run`."""

    inputs: Array
    z: Array


class InNumba:
    """A filter whose steps are made by `bank.step`, without what `CoefficientEkf.run` does between them."""

    def __init__(self, ekf: CoefficientEkf) -> None:
        self.ekf = ekf

    def run(self, inputs: Array, z: Array, variance: Array, nis: Array) -> int:
        """Steps over the rows, filling nis, (K, 9); how many were made."""
        steps: int = loop(self.ekf.bank.kernel, Given(H, inputs, z, variance, nis), self.ekf.rejected)
        return steps


class Bank(ctypes.Structure):
    """The structure of this name in ekf_step.c."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("n", "width", "filters", "terms", "groups")),
        *((name, ctypes.c_int64) for name in ("water", "first", "added_mass")),
        *((name, ctypes.c_double) for name in ("eddy_time", "likelihood_memory", "gate")),
        *((name, ctypes.c_void_p) for name in ("constants", "inverse_mass")),
        *((name, ctypes.c_void_p) for name in ("parameter", "regressor", "equation", "constant", "weight")),
        *((f"group_{name}", ctypes.c_void_p) for name in ("parameter", "regressor", "weight", "equation")),
        *((name, ctypes.c_void_p) for name in ("regressors", "FP", "channels", "PHt", "K")),
        *((name, ctypes.c_void_p) for name in ("Q", "Q_eddy", "learns", "lower", "upper", "bias_state")),
        *((name, ctypes.c_void_p) for name in ("intensity", "x", "P", "log_likelihood", "weights", "rejected")),
    )


class InC:
    """A filter whose steps are made in C, on its own arrays."""

    def __init__(self, library: ctypes.CDLL, ekf: CoefficientEkf) -> None:
        self.ekf = ekf
        self._run = library.run
        filters = ekf.bank.kernel
        model, tuning, scratch, settings = filters.model, filters.tuning, filters.scratch, filters.settings
        count, n, width = filters.P.shape
        arrays = (
            *(model.constants, model.inverse_mass, *model.terms, *model.groups),
            *(filters.step.regressors, scratch.FP, scratch.channels, *scratch.rows),
            *(tuning.Q, tuning.Q_eddy, tuning.learns, tuning.lower, tuning.upper, filters.bias_state),
            *(filters.intensity, filters.x, filters.P, filters.log_likelihood, filters.weights, ekf.rejected),
        )
        self._bank = Bank(
            *(n, width, count, len(model.terms.weight), len(model.groups.equation)),
            *(model.water, model.first, model.added_mass),
            *(settings.eddy_time, settings.likelihood_memory, settings.gate),
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
        library = compile_step(FOLDER)
    except NoCompiler as error:
        missing = str(error)
    return {name: _case(case, library, missing, rounds, seconds) for name, case in CASES.items()}


def compile_step(folder: Path, *flags: str) -> ctypes.CDLL:
    """The C step, derived and compiled into a folder.

    Raises:
        NoCompiler: there is no cc, or it does not compile this.
    """
    cc, library = shutil.which("cc"), folder / "ekf_step.so"
    if cc is None:
        raise NoCompiler("no C compiler (cc) on this machine")
    folder.mkdir(parents=True, exist_ok=True)
    from sternplane.codegen import derive_c  # with sympy, which compiling this module's kernel does not need

    (folder / "jacobians.h").write_text(derive_c.generate())
    command = [cc, *FLAGS, *flags, "-fPIC", "-shared", f"-I{folder}", "-o", str(library), str(SOURCE), "-lm"]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if built.returncode:
        raise NoCompiler(f"cc cannot compile {SOURCE.name}: {built.stderr.strip().partition(chr(10))[0]}")
    loaded = ctypes.CDLL(str(library))
    loaded.run.restype = ctypes.c_int64
    return loaded


def settled_filter(case: CoefficientParams) -> CoefficientEkf:
    """As `begun`, but with the tuning that holds when the start-up is over: both languages take it as it is."""
    ekf = begun(case)
    ekf.tuning.Q[:], ekf.tuning.learns[:] = ekf.tuning.Q_final, ekf.tuning.may_learn
    return ekf


def begun(case: CoefficientParams) -> CoefficientEkf:
    """A filter of the vehicle, at the beginning of the flight."""
    table = tomllib.loads((configs() / "npsauv2" / "vehicle.toml").read_text())
    ekf = CoefficientEkf(params.load(Vehicle, table, "vehicle.toml"), case)
    ekf.start((SPEED, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), STD)
    return ekf


def flight(model: ObserverModel, steps: int, seed: int = 1, noise: float = 1.0) -> FilterInputs:
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
    return FilterInputs(inputs, z)


def _case(case: CoefficientParams, library: ctypes.CDLL | None, missing: str, rounds: int, seconds: int) -> Any:
    inputs, z = flight(begun(case).model, seconds * 100)
    rows, variance = TURN // len(case.turbulence), STD**2
    nis = np.zeros((rows, MOVING))
    times: dict[str, list[float]] = {name: [] for name in ("numba", *(("c",) if library else ()), "called from python")}
    for _ in range(rounds):
        runs: dict[str, Run] = {"numba": InNumba(settled_filter(case)).run}
        if library:
            runs["c"] = InC(library, settled_filter(case)).run
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
