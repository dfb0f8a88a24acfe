"""The second dive: how much sooner a vehicle knows itself that begins with what its first dive learned."""

from __future__ import annotations

import math
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from firmware_py import app, config_files
from firmware_py.adapters.io_params import StateParams
from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.records.cycle import Cycle
from firmware_py.records.passport import LearnedModel, model_of, moved
from firmware_py.run.kept_passport import FILE, PassportKeeper, encode, load_passport, resume_passport
from firmware_py.run.moment import Moment
from sim_bridge.truth_sample import TruthSample
from sternplane.logs.replay import replay
from sternplane.logs.streaming import stream
from sternplane.logs.tracking import Array
from sternplane.sitl.flight import SCENARIOS, Flight, FlightRequest, fly, prepare
from sternplane.sitl.request import parse_settings
from sternplane.sitl.taken_settings import beside
from sternplane.study.laid_settings import settings_now
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import CONFIG, starts
from sternplane.study.wrong_vehicle import Factors, coefficients, overlay

_AFTER_FIRST = Moment(utc_s=1_767_225_600.0, boot="one start of the computer", uptime_s=600.0)
"""What the clocks show when the first dive is over, 2026-01-01: no figure depends on when the study is run."""
_DAY = 86_400.0
"""Between the dives, s."""
_DURATION = 125.0
"""Of each dive: the learning manoeuvre takes 120 s."""
_OTHER_NOISE = 10_000
"""The second dive's seed is so much greater."""
_WRONG, _WEAKER = 0.5, 0.78
"""How wrong the vehicle file is, and what is left of the rudder in the changed vehicle's second dive."""
_DIVES = ("first", "second", "changed")
_SIGMAS = 4.0
_NAME = "second dive"


class _Valid:
    """Takes down when each coefficient is valid first, and how far off the truth valid values are."""

    done = False

    def __init__(self, flight: Flight, keeper: PassportKeeper) -> None:
        self._keeper = keeper
        self.names = flight.params.estimation.coefficients.names
        truth = flight.header()["truth"]["coefficients"]
        self._truth = [truth[name] for name in self.names]
        self.first = dict.fromkeys(self.names, math.inf)
        self.sigmas: list[float] = []

    def see(self, cycle: Cycle, truth: TruthSample) -> None:
        """Take one cycle."""
        del truth
        self._keeper.update(cycle)
        learned, whole = cycle.state.learned, cycle.tick.k % 100 == 0
        for name, value, std, valid, true in zip(
            self.names, learned.value, learned.std, learned.valid, self._truth, strict=True
        ):
            if valid:
                self.first[name] = min(self.first[name], cycle.tick.t)
                if whole:
                    self.sigmas.append(abs(value - true) / std)


class _Dive(NamedTuple):
    """What became of a dive: what it saw, what it left, and how many cycles a replay gives otherwise."""

    seen: _Valid
    left: LearnedModel
    differing: int


def _dive(folder: Path, config: Path, seed: int, wrong: Factors, kept: Mapping[str, Any], again: bool) -> _Dive:
    scenario = folder / "dive.toml"
    text = (SCENARIOS / "learn-prbs.toml").read_text(encoding="utf-8")
    for before, after in (('"surfaced"', '"time"'), ("duration_s = 300.0", f"duration_s = {_DURATION}")):
        assert before in text
        text = text.replace(before, after, 1)
    text = text.replace("[start]", "current_ned_m_s = [0.06, 0.08, 0.0]\n[start]", 1)
    scenario.write_text(text + overlay(wrong), encoding="utf-8")
    settings = beside(text, settings_now())
    flight = prepare(FlightRequest(scenario=str(scenario), config=config, seed=seed, settings=settings), kept)

    def keep() -> LearnedModel | None:
        return flight.autopilot.parts.estimator.learned_model()

    saved: dict[str, bytes] = {}
    keeper = PassportKeeper(saved.__setitem__, keep, flight.configuration, 30.0)
    witness, log = _Valid(flight, keeper), folder / "log.mcap"
    if fly(flight, log if again else None, witness=witness).reason == "interrupted":
        raise KeyboardInterrupt
    for name, content in saved.items():
        write_atomically(folder / name, content)
    keeper.leave(folder)
    left = keep()
    assert left is not None
    return _Dive(witness, left, replay(stream(log), app.build).differing if again else 0)


def _run(seed: int, k: int) -> RunArrays:
    del k
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(CONFIG, folder / "changed")
        truth = folder / "changed" / "truth.toml"
        truth.write_text(re.sub(r"(?m)^([NY]_dr) = (\S+)", _weaker, truth.read_text()), encoding="utf-8")
        wrong = coefficients(starts(seed, _WRONG))
        first = _dive(folder, CONFIG, seed, wrong, {}, again=False)
        configuration = config_files.read_configuration(CONFIG, factors=wrong, settings=parse_settings(settings_now()))
        kept: dict[str, Any] = {}
        if (folder / FILE).exists():  # else nothing of it was to be relied on, and the second begins as the first
            kept = {"passport": next_day(folder / FILE, configuration)}
        second = _dive(folder, CONFIG, seed + _OTHER_NOISE, wrong, kept, again=True)
        changed = _dive(folder, folder / "changed", seed + _OTHER_NOISE, wrong, kept, again=False)
    found: dict[str, Any] = {"differing": np.array(float(second.differing))}
    for label, dive in zip(_DIVES, (first, second, changed), strict=True):
        found[f"{label} valid"] = np.array([dive.seen.first[name] for name in dive.seen.names])
        found[f"{label} sigmas"] = np.array(dive.seen.sigmas)
    for label, dive in (("second", second), ("changed", changed)):
        std = [math.hypot(a, b) for a, b in zip(first.left.std, dive.left.std, strict=True)]
        groups = [one.group for one in moved(first.left, first.left.value, dive.left.value, std)]
        found[f"{label} told"] = np.array([float("rudder" in groups), float(len(groups))])
    return found


def _weaker(line: re.Match[str]) -> str:
    return f"{line[1]} = {_WEAKER * float(line[2])}"


def next_day(path: Path, configuration: config_files.Configuration) -> dict[str, Any]:
    """Return what a dive begins with a day after the first, by the study's clocks; the passport then shows them too."""
    found, after = load_passport(path), _AFTER_FIRST
    write_atomically(path, encode(model_of(found), found["vehicle"], found["configuration"], after))
    now = after._replace(utc_s=after.utc_s + _DAY, uptime_s=after.uptime_s + _DAY)
    begins, _ = resume_passport(path, configuration, StateParams(), now)
    return begins


def _last(valid: Array) -> float:
    """Return when the last of some coefficients is valid, s; never, where there are none: the dive taught nothing."""
    return float(np.max(valid)) if len(valid) else math.inf


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    rows, n = [], len(runs)
    # In some flights a coefficient whose file says half of the truth is not known to 10 % of that by the end.
    reached = [np.isfinite(run["first valid"]) for run in runs]
    median = {
        label: float(np.median([_last(run[f"{label} valid"][known]) for run, known in zip(runs, reached, strict=True)]))
        for label in _DIVES
    }
    for label in _DIVES:
        whole = 100.0 * float(np.mean([np.isfinite(run[f"{label} valid"]).all() for run in runs]))
        rows.append(Row(_NAME, f"{label} dive: flights in which all ten become valid, %", whole, None, n))
        what = f"{label} dive: all valid that the first dive makes valid, median, s"
        rows.append(Row(_NAME, what, median[label], None, n))
    rows.append(Row(_NAME, "time to all valid: second over first dive", median["second"] / median["first"], 0.6, n))
    for label in _DIVES:
        sigmas = np.concatenate([run[f"{label} sigmas"] for run in runs])
        share = 100.0 * float(np.mean(sigmas > _SIGMAS)) if len(sigmas) else math.nan
        rows.append(Row(_NAME, f"{label} dive: valid values off by more than 4 sigma, %", share, 1.0, n))
    told = np.array([[run["second told"][1], run["changed told"][0]] for run in runs])
    rows.append(Row(_NAME, "same vehicle: told that something changed, flights", float(np.sum(told[:, 0] > 0)), 0.0, n))
    rows.append(Row(_NAME, "rudder 22 % weaker: not told, share of flights", 1.0 - float(np.mean(told[:, 1])), 0.1, n))
    differing = sum(float(run["differing"]) for run in runs)
    rows.append(Row(_NAME, "second dive: cycles that a replay of its log gives otherwise", differing, 0.0, n))
    return Results(rows)


SECOND_DIVE = Case(
    _NAME,
    "The vehicle file is 50 % wrong, as above. A first dive flies the learning manoeuvre and leaves its passport; a "
    "day later the second begins with it. In a third the rudder has become 22 % weaker between. The times are those "
    "from which each coefficient has been valid; the first dive is the one without passport.",
    _run,
    _evaluate,
    40,
    1,
)
"""The passport: how much sooner everything is valid, and what it tells of a vehicle that changed."""
