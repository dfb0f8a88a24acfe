"""A plant of NPS AUV II, deep under, for tests to push about."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from firmware_py import params
from firmware_py.marine import Eta, Nu
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import Truth

CONFIG = Path(__file__).resolve().parents[3] / "configs" / "npsauv2" / "truth.toml"
TRUTH = params.load(Truth, tomllib.loads(CONFIG.read_text()), "truth.toml")
DEEP = Eta(0.0, 0.0, 50.0, 0.0, 0.0, 0.0)
TRIM = 500.0 / 60.0
CRUISE = Nu(1.8288, 0.0, 0.0, 0.0, 0.0, 0.0)
CENTRED = (0.0, 0.0, 0.0, 0.0)
STILL = EnvironmentParams()


def new_plant(truth: Truth = TRUTH, dt: float = 0.01, sea: EnvironmentParams = STILL, **start: Any) -> Plant:
    start.setdefault("eta0", DEEP)
    return Plant(truth, Environment(sea, 5, dt), dt, **start)


def run(plant: Plant, seconds: float, fins: tuple[float, ...] = CENTRED, n: float = 0.0) -> Plant:
    for _ in range(round(seconds / plant.dt)):
        plant.step(fins, n)
    return plant
