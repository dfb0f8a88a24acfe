"""A vehicle, motions to try it in, and slopes taken two ways."""

from __future__ import annotations

import dataclasses
import tomllib
from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from firmware_py import params
from firmware_py.estimation.model.equations import COEFFICIENTS
from firmware_py.estimation.model.observer_model import GROUPS, ObserverModel
from firmware_py.estimation.model.prediction import water_velocity
from firmware_py.estimation.model.transition import linearise
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.plant.truth import Truth

CONFIGS = Path(__file__).resolve().parents[2] / "configs" / "npsauv2"
VEHICLE = params.load(Vehicle, tomllib.loads((CONFIGS / "vehicle.toml").read_text()), "vehicle.toml")
TRUTH = params.load(Truth, tomllib.loads((CONFIGS / "truth.toml").read_text()), "truth.toml")
TEN = ("M_q", "M_ds", "Z_q", "Z_ds", "N_r", "N_dr", "N_v", "Y_dr", "Y_r", "Y_v")
WIDE = (*TEN, *GROUPS, "C_dy", "C_dz")
ALL = tuple(name for name in COEFFICIENTS if name not in ("K_prop", "N_prop"))

MOVING = ("u", "v", "w", "p", "q", "r", "phi", "theta", "psi")

seeds = st.integers(0, 2**32 - 1)


@dataclasses.dataclass
class Case:
    nu: tuple[float, ...]
    angles: tuple[float, ...]
    current: tuple[float, float]
    inputs: np.ndarray


def case(seed: int) -> Case:
    """Ahead through the water by more than 0.3 m/s, however it points; every motion at once."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform((-0.8, -1.0, -3.0), (0.8, 1.0, 3.0))
    u = rng.uniform(1.3, 3.0)  # over ground: a current takes 0.7 m/s at most
    nu = (u, *rng.uniform(-0.5, 0.5, 5))
    inputs = np.array([*rng.uniform(-0.4, 0.4, 2), 0.0, rng.uniform(0.0, 15.0)])
    return Case(nu, tuple(angles), tuple(rng.uniform(-0.5, 0.5, 2)), inputs)


def state(model: ObserverModel, at: Case) -> np.ndarray:
    x = model.state(at.nu, at.angles)
    x[9:11] = at.current
    return x


def apart(a: object, b: object) -> float:
    """The largest difference, as a part of the largest entry."""
    a, b = np.asarray(a), np.asarray(b)
    return float(np.abs(a - b).max() / np.abs(b).max())


def slopes(model: ObserverModel, x: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """d rates / d x, (9, size), from the kernels."""
    x_dot = model.rates(x, inputs)
    linearise(model.arrays, inputs, tuple(x[:9]), x_dot, water_velocity(x, model.water), model.linearisation)
    A, full = model.linearisation.A, np.zeros((9, model.size))
    full[:, :9] = A[:, :9]
    for j in range(model.water):
        full[:, 9 + j] = A[:, 9 + (j if j < 2 else j - 2)]
    full[:6, model.first :] = model.arrays.inverse_mass @ model.unit_forces()
    return full


def differences(function: object, x: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Central differences of fourth order."""
    columns = []
    for i in range(len(x)):
        h = step * max(1.0, abs(x[i])) if i < 14 else 1e-3 * max(abs(x[i]), 1e-2)
        at = [function(x + k * h * np.eye(len(x))[i]) for k in (-2, -1, 1, 2)]
        columns.append((at[0] - 8.0 * at[1] + 8.0 * at[2] - at[3]) / (12.0 * h))
    return np.array(columns).T
