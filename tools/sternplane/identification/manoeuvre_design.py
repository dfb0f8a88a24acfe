"""Design of the learning manoeuvres, by how much each tells.

`python -m sternplane.identification.manoeuvre_design [kind] [--grip SHARE ...]` prints a row for each candidate.

Each candidate is flown for 60 s under guidance and laws as in the vehicle, at the true state, with servos that lag.
The Cramér-Rao bound of the ten coefficients (`bound`) then says what any estimator can make of that flight at best:
DVL at 5 Hz, AHRS at 100 Hz with their noise, a steady current that is unknown too, and 70 % of each coefficient as
the 1 sigma at the start. Good is what makes the mean of the ten relative sigmas small, never has to wait and stays near
its depth; what was chosen stands at `records.mission.Manoeuvre` and `guidance.learning.LearningParams`.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from rich.progress import track
from rich.table import Table

from firmware_py.adapters import kernel_cache

if __name__ == "__main__":
    kernel_cache.use()

from firmware_py import config_files
from firmware_py.control.control import Control
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.guidance.guidance import Guidance
from firmware_py.guidance.manoeuvre import ManoeuvreParams
from firmware_py.marine import Eta, Nu
from firmware_py.records.command import ModeState
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import EventKind
from firmware_py.records.mission import Manoeuvre, ManoeuvreKind, Mission
from firmware_py.records.order import NO_ORDER, Mode
from firmware_py.tick import Tick, step_ns
from sim_bridge.plant.truth import Truth
from sim_bridge.truth_file import read_truth
from sternplane.identification.cramer_rao_bound import bound, true_states
from sternplane.logs.tracking import Array
from sternplane.plain_console import PlainConsole
from sternplane.sitl.busless_flight import SENSOR_STD, BuslessFlight, Start, fly, measurement_mask
from sternplane.sitl.flight import CONFIG

TEN = ("M_q", "M_ds", "N_r", "N_dr", "N_v", "Z_ds", "Z_q", "Y_dr", "Y_r", "Y_v")
_RATES = (5.0,) * 3 + (100.0,) * 6
_PRIOR, _CURRENT = 0.7, 0.3
_START_STD = np.array([0.1] * 3 + [math.radians(angle) for angle in (1.0, 1.0, 1.0, 2.0, 2.0, 5.0)])
"""1 sigma of what is known of u v w p q r phi theta psi at the start."""
_DEPTH = 60.0


class ManoeuvreResult(NamedTuple):
    """Result of one candidate: relative 1 sigma of the ten, and how far (m, rad) the vehicle deviated."""

    sigma: Array
    depth: float
    pitch: float
    heading: float
    waited: bool

    @property
    def mean(self) -> float:
        """Mean of the relative sigmas."""
        return float(np.mean(self.sigma))


class ManoeuvreController:
    """Guidance and laws of the configuration on a mission of one manoeuvre; a `busless_flight.Hold` at 100 Hz."""

    def __init__(self, manoeuvre: Manoeuvre, grip: float) -> None:
        configuration = config_files.read_configuration(CONFIG)
        params = config_files.autopilot_params(configuration)
        learning = dataclasses.replace(params.guidance.learning, grip=grip)
        guidance = dataclasses.replace(params.guidance, learning=learning)
        self.vehicle = config_files.vehicle(configuration)
        self._guidance = Guidance(guidance, Mission((manoeuvre,)))
        self._control = Control(params.control, self.vehicle)
        self._dt_ns = step_ns(100)
        self._k = 0
        self.waited = False

    def __call__(self, eta: Eta, nu: Nu) -> tuple[float, float]:
        """(delta_s, delta_r), rad, of the next tick."""
        state = StateEstimate(eta, nu, 0.0, 0.0, 0.0, math.nan, True, True, True, False)
        tick, mode = Tick(self._k, self._dt_ns), ModeState(Mode.MISSION if self._k else Mode.MANUAL, False, 0)
        reference = self._guidance.update(tick, mode, NO_ORDER, state)
        demand = self._control.update(tick, mode, NO_ORDER, reference, state)
        self._k += 1
        self.waited = self.waited or any(event.kind is EventKind.MANOEUVRE_WAITS for event in self._guidance.events)
        return demand.delta_s, demand.delta_r


def evaluate(truth: Truth, manoeuvre: Manoeuvre, grip: float, seconds: float = 60.0) -> ManoeuvreResult:
    """Fly a manoeuvre for so long from trim at 60 m and bounds what it tells.

    Args:
        truth: the simulated vehicle.
        manoeuvre: of any duration.
        grip: share of the laws, in [0, 1].
        seconds: how long.
    """
    controller, steps, h = ManoeuvreController(manoeuvre, grip), round(seconds * 100.0), 0.01
    start = Start(eta=Eta(0.0, 0.0, _DEPTH, 0.0, 0.0, 0.0))
    flight = fly(truth, np.zeros((steps, 2)), start.n, h, start=start, ideal_fins=False, hold=controller)
    return ManoeuvreResult(
        relative_sigma(controller, flight),
        float(np.max(np.abs(flight.eta[:, 2] - _DEPTH))),
        float(np.max(np.abs(flight.x[:, 7]))),
        float(np.max(np.abs(flight.x[:, 8]))),
        controller.waited,
    )


def relative_sigma(controller: ManoeuvreController, flight: BuslessFlight) -> Array:
    """Return the bound of the ten at the end of a flight, 1 sigma, as shares of what they are."""
    model = ObserverModel(controller.vehicle, TEN)
    believed = np.abs(np.array(model.believed))
    prior = np.concatenate([_START_STD, [_CURRENT] * 2, _PRIOR * believed])
    came = measurement_mask(len(flight.inputs), 0.01, _RATES)
    states = true_states(model, flight.x)
    covariance = bound(model, states, flight.inputs, 0.01, came, SENSOR_STD, prior)
    sigma: Array = np.sqrt(np.diag(covariance)[-len(TEN) :]) / believed
    return sigma


def candidates(kind: ManoeuvreKind) -> Iterator[Manoeuvre]:
    """Yield the candidates of a kind."""
    if kind is ManoeuvreKind.ZIGZAG:
        for amplitude, pitch, heading in itertools.product((5, 10, 15, 20), (4, 8, 12), (5, 10, 20)):
            angle = math.radians(amplitude)
            yield Manoeuvre(
                kind, delta_s=angle, delta_r=angle, pitch=math.radians(pitch), heading=math.radians(heading)
            )
        return
    for amplitude, clock in itertools.product((5, 10, 15, 20), (0.5, 1.0, 2.0, 3.0, 4.0, 6.0)):
        yield Manoeuvre(kind, delta_s=math.radians(amplitude), delta_r=math.radians(amplitude), clock=clock)
    if kind is ManoeuvreKind.PRBS:
        usual = Manoeuvre(kind).register
        yield from (Manoeuvre(kind, register=register) for register in range(1, 128, 8) if register != usual)


def main() -> None:
    """Print a row for each candidate, the most telling first."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "kind", nargs="*", type=lambda word: ManoeuvreKind[word.upper()], help="zigzag, doublets, prbs; all"
    )
    parser.add_argument("--grip", type=float, nargs="+", default=[ManoeuvreParams().grip], help="shares of the laws")
    options = parser.parse_args()
    truth = read_truth(CONFIG / "truth.toml")
    wanted = [(m, grip) for kind in options.kind or ManoeuvreKind for m in candidates(kind) for grip in options.grip]
    console = PlainConsole(stderr=True)
    rows = [(evaluate(truth, m, grip), m, grip) for m, grip in track(wanted, "flying", console=console, transient=True)]
    table = Table(
        "kind",
        "angle",
        "clock",
        "register",
        "pitch",
        "heading",
        "grip",
        "mean σ",
        "worst σ",
        "depth",
        "pitch",
        "heading",
    )
    for result, m, grip in sorted(rows, key=lambda row: row[0].mean):
        worst = int(np.argmax(result.sigma))
        steps = m.kind is not ManoeuvreKind.ZIGZAG
        table.add_row(
            m.kind.name.lower(),
            f"{math.degrees(m.delta_s):.0f}°",
            f"{m.clock:g} s" if steps else "",
            f"{m.register}" if m.kind is ManoeuvreKind.PRBS else "",
            "" if steps else f"{math.degrees(m.pitch):.0f}°",
            "" if steps else f"{math.degrees(m.heading):.0f}°",
            f"{grip:g}",
            f"{100 * result.mean:.2f} %",
            f"{100 * result.sigma[worst]:.2f} % {TEN[worst]}",
            f"{result.depth:.1f} m",
            f"{math.degrees(result.pitch):.0f}°" + (" waits" if result.waited else ""),
            f"{math.degrees(result.heading):.0f}°",
        )
    PlainConsole().print(table)


if __name__ == "__main__":
    main()
