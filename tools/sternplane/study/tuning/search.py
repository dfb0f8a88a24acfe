"""What is searched, and how a set of gains is judged: its errors on the nominal vehicle, and its fins' travel."""

from __future__ import annotations

import dataclasses
import math
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from firmware_py import config_files
from firmware_py.control.control import ControlParams, LawKind
from firmware_py.params import to_toml_value, toml_key
from firmware_py.units import UNITS
from sternplane.logs.tracking import Array
from sternplane.sitl.flight import CONFIG, Flight, FlightRequest, fly, prepare
from sternplane.sitl.request import parse_settings
from sternplane.sitl.taken_settings import beside
from sternplane.study.adaptation.courses import track
from sternplane.study.laid_settings import settings_now
from sternplane.study.tuning.closed_loop import AxisFigures, ClosedLoop, Recording
from sternplane.study.tuning.differential_evolution import DifferentialEvolution

DURATION, BEGIN = 58.0, 16.0
"""Of the track that is flown, s, and from when on errors count: three steps of each axis, the integrals settled."""
SEEDS = 1, 2
"""Of the sensors' noise; below 1000, as all that is tuned by."""
SIZE, GENERATIONS = 16, 24
_PENALTY = 10.0
"""Weight of the fins' travel beyond the limit, both as parts of what they are limited to."""
_QUIET = "\n[autopilot.estimation.learning]\nenabled = false\n"
"""Without the coefficient filter a flight costs half as much; no law here is designed from what it learns."""

Figures = tuple[AxisFigures, AxisFigures]


class Space(NamedTuple):
    """The gains of one axis that are searched: the table of `ControlParams` and, by field, from where to where."""

    table: str
    fields: dict[str, tuple[float, float]]

    def gains(self, params: ControlParams, point: Array) -> Any:
        """Return the table with the gains of a point; a pole is given by its distance from 0."""
        return dataclasses.replace(getattr(params, self.table), **self.values(point))

    def values(self, point: Array) -> dict[str, Any]:
        """Return the values of the fields; those of "poles 1" and "poles 2" make a pair."""
        values: dict[str, Any] = dict(zip(self.fields, point.tolist(), strict=True))
        if "poles 1" in values:
            values["poles"] = -values.pop("poles 1"), -values.pop("poles 2")
        return values

    def point(self, params: ControlParams) -> Array:
        """Return the point of the gains that the parameters have."""
        table = getattr(params, self.table)
        poles = dict(zip(("poles 1", "poles 2"), getattr(table, "poles", ()), strict=False))
        return np.array([-poles[name] if name in poles else getattr(table, name) for name in self.fields])


_SLIDING = {
    "poles 1": (0.2, 2.0),
    "poles 2": (0.2, 2.0),
    "bandwidth": (0.2, 4.0),
    "delta_sw": (0.1, 1.0),
    "integral_time": (2.0, 40.0),
}
SLIDING = Space("depth", _SLIDING), Space("heading", _SLIDING)
PID = (
    Space(
        "depth_pid",
        {"k_rate": (1.0, 30.0), "k_angle": (1.0, 30.0), "k_depth": (0.05, 1.0), "k_integral": (3e-4, 0.1)},
    ),
    Space("heading_pid", {"k_rate": (1.0, 30.0), "k_angle": (1.0, 30.0), "k_integral": (0.02, 5.0)}),
)


class Search(NamedTuple):
    """One search: of which law, and how much the fins may travel over what the shipped sliding-mode law takes."""

    name: str
    law: LawKind
    spaces: tuple[Space, Space]
    travel: float


SEARCHES = (
    Search("pid_equal_travel", LawKind.PID, PID, 1.0),
    Search("pid_free", LawKind.PID, PID, math.inf),
    Search("sliding_searched", LawKind.SLIDING, SLIDING, 1.0),
)


def cruise(config: Path) -> tuple[float, float]:
    """Return the speed at which a vehicle flies the track, its trim speed in whole tenths, m/s, and rpm at it."""
    configuration = config_files.read_configuration(config, settings=parse_settings(settings_now()))
    propeller = config_files.vehicle(configuration).propeller
    speed = math.floor(10.0 * propeller.u_trim) / 10.0
    return speed, float(round(to_toml_value(propeller.n_trim, UNITS["rpm"][1]) * speed / propeller.u_trim))


def recorded(folder: Path, seed: int, over: str = "", config: Path = CONFIG) -> tuple[Flight, Recording]:
    """Fly the track whole, with `over` (TOML) laid over the configuration; return what it was and what was seen."""
    scenario = folder / "tuning.toml"
    text = track(DURATION, cruise=cruise(config)).scenario.format(adoption="false") + _QUIET + over
    scenario.write_text(text, encoding="utf-8")
    settings = beside(text, settings_now())
    flight = prepare(FlightRequest(scenario=str(scenario), config=config, seed=seed, settings=settings), {})
    recording = Recording()
    outcome = fly(flight, None, witness=recording)
    if outcome.reason == "interrupted":
        raise KeyboardInterrupt
    return flight, recording


class Judge:
    """Judges gains by the recorded flights of `SEEDS`, by a vehicle of a configuration."""

    def __init__(self, seeds: Sequence[int] = SEEDS, config: Path = CONFIG) -> None:
        with tempfile.TemporaryDirectory() as name:
            flown = [recorded(Path(name), seed, config=config) for seed in seeds]
        self.loops = [ClosedLoop(flight, recording, BEGIN) for flight, recording in flown]
        self.shipped = self.loops[0].shipped

    def figures(self, params: ControlParams) -> Figures:
        """Return the means of the figures of both axes."""
        found = np.array([loop.fly(params) for loop in self.loops]).mean(axis=0)
        depth, heading = (AxisFigures(*axis) for axis in found.tolist())
        return depth, heading


def tuned(search: Search, judge: Judge, tell: Callable[[int, Figures], None]) -> ControlParams:
    """Return the parameters with the best gains; both axes are searched in the same flights.

    Args:
        search: what is searched.
        judge: of the gains.
        tell: is told each generation and the figures of its best gains.
    """
    shipped = dataclasses.replace(judge.shipped, law=search.law)
    limits = [search.travel * axis.travel for axis in judge.figures(judge.shipped)]
    populations = []
    for space in search.spaces:
        low, high = np.array(list(space.fields.values())).T
        populations.append(DifferentialEvolution(low, high, SIZE, 1, space.point(shipped)))

    def judged(points: Sequence[Array]) -> tuple[Figures, list[float]]:
        """Return the figures of a pair of points, and what each costs."""
        figures = judge.figures(_with(shipped, search, points))
        return figures, [_cost(axis, limit) for axis, limit in zip(figures, limits, strict=True)]

    for generation in range(GENERATIONS):
        for i in range(SIZE):
            _, costs = judged([one.ask(i) for one in populations])
            for population, cost in zip(populations, costs, strict=True):
                population.tell(i, cost)
        figures = _settle(populations, judged)
        tell(generation, figures)
        best = [one.best for one in populations]
        for population in populations:
            population.breed()
    return _with(shipped, search, best)


def _settle(
    populations: Sequence[DifferentialEvolution], judged: Callable[[Sequence[Array]], tuple[Figures, list[float]]]
) -> Figures:
    """Judge the best of both axes together until they stay the best; return their figures.

    A point is judged beside a point of the other axis, and one that turns badly disturbs the depth too: what seemed
    the best beside another may not be so beside the best.
    """
    while True:
        before = [one.best for one in populations]
        figures, costs = judged(before)
        for population, cost in zip(populations, costs, strict=True):
            population.correct(cost)
        if all(np.array_equal(one.best, point) for one, point in zip(populations, before, strict=True)):
            return figures


def _cost(axis: AxisFigures, limit: float) -> float:
    beyond = max(axis.travel / limit - 1.0, 0.0) if math.isfinite(axis.travel) else math.inf
    return axis.rms * (1.0 + _PENALTY * beyond)


def _with(shipped: ControlParams, search: Search, points: Sequence[Array]) -> ControlParams:
    tables = {s.table: s.gains(shipped, point) for s, point in zip(search.spaces, points, strict=True)}
    return dataclasses.replace(shipped, **tables)


def as_toml(search: Search, params: ControlParams, comments: Iterable[str] = ()) -> str:
    """Return the gains of a search as tables that a scenario lays over autopilot.toml, rounded to four digits."""
    lines = [
        *(f"# {comment}" for comment in comments),
        "[autopilot.control]",
        f'law = "{to_toml_value(params.law, 1.0)}"',
    ]
    for space in search.spaces:
        gains = getattr(params, space.table)
        names = dict.fromkeys(name.split()[0] for name in space.fields)
        keys = {f.name: toml_key(f) for f in dataclasses.fields(gains)}
        lines += ["", f"[autopilot.control.{space.table}]"]
        lines += [f"{keys[name]} = {_text(getattr(gains, name))}" for name in names]
    return "\n".join(lines) + "\n"


def drawn(search: Search, params: ControlParams, count: int) -> list[ControlParams]:
    """Return sets of gains about those that the parameters have: each up to twice or half."""
    random, shipped = np.random.default_rng(1), dataclasses.replace(params, law=search.law)
    points = [space.point(shipped) for space in search.spaces]
    return [
        _with(shipped, search, [point * 2.0 ** random.uniform(-1.0, 1.0, len(point)) for point in points])
        for _ in range(count)
    ]


def _text(value: float | tuple[float, ...]) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_text, value))}]"
    return f"{float(f'{value:.4g}')!r}"


def words(figures: Figures, over: Figures) -> Iterator[str]:
    """Yield a line for each axis: error and travel, and both over those of another set."""
    for name, unit, axis, other in zip(("depth", "heading"), ("m", "deg"), figures, over, strict=True):
        yield (
            f"{name} {axis.rms:.4f} {unit} ({axis.rms / other.rms:.2f} x), "
            f"fins {axis.travel:.2f} deg/s ({axis.travel / other.travel:.2f} x)"
        )
