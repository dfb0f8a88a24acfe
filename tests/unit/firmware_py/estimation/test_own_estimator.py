"""An estimator of one's own answers for motion and learning; sensors, leak and the supervisor's view stay built in."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest

from firmware_py import config_files
from firmware_py.adapters.storage import memory_pickle
from firmware_py.estimation.estimator import Estimator
from firmware_py.estimation.own_estimator import OwnEstimator
from firmware_py.estimation.state_estimator import StateEstimator
from firmware_py.marine import Origin
from firmware_py.own_part import NoParams, OwnClass
from firmware_py.records.command import Applied
from firmware_py.records.order import Mode
from firmware_py.records.sensing import Ahrs, Heard, PayloadReading, silence
from firmware_py.tick import Tick

CONFIG = config_files.read_configuration(Path(__file__).resolve().parents[4] / "configs" / "npsauv2")
PARAMS, VEHICLE = config_files.autopilot_params(CONFIG).estimation, config_files.vehicle(CONFIG)
STILL = Applied((0.0,) * 4, 0.0, False, False)


class Shifted(StateEstimator):
    """North by a metre; what the test says beyond."""

    says: object = None
    seen: tuple = ()

    def update(self, tick, frame, applied, built_in):
        Shifted.seen += frame.payload
        if Shifted.says is not None:
            return Shifted.says(built_in)
        return dataclasses.replace(
            built_in, eta=built_in.eta._replace(x=built_in.eta.x + 1.0), leak=True, depth_ok=True
        )


@pytest.fixture
def estimator() -> OwnEstimator:
    Shifted.says, Shifted.seen = None, ()
    built_in = Estimator(PARAMS, Origin(0.6, -2.1), VEHICLE)
    return OwnEstimator(built_in, OwnClass("mine", Shifted, NoParams()), VEHICLE)


def frame(t: float, **others: object):
    ahrs = Heard(Ahrs(0.0, 0.01, 0.1, 0.0, 0.0, 0.0), t, True, True)
    return dataclasses.replace(silence(4), ahrs=ahrs, **others)


def step(estimator: OwnEstimator, k: int, mode: Mode = Mode.HOLD, **others: object):
    tick = Tick(k, 10_000_000)
    judged = estimator.update(tick, frame(tick.t, **others), STILL)
    return judged, estimator.flown_by(mode, judged)


def test_laws_fly_by_it_and_the_supervisor_by_the_built_in_one(estimator: OwnEstimator) -> None:
    judged, flown = step(estimator, 0)
    assert flown.eta.x == judged.eta.x + 1.0
    assert (flown.leak, flown.depth_ok) == (judged.leak, judged.depth_ok) == (False, False)
    judged, flown = step(estimator, 1, Mode.SURFACE)
    assert flown is judged


def test_it_hears_the_sensors_of_one_s_own(estimator: OwnEstimator) -> None:
    reading = PayloadReading("ctd.t", 9.5, 0.0)
    step(estimator, 0, payload=(reading,))
    assert Shifted.seen == (reading,)


@pytest.mark.parametrize(
    "says",
    [
        lambda state: dataclasses.replace(state, eta=state.eta._replace(theta=math.nan)),
        lambda state: dataclasses.replace(state, learned=dataclasses.replace(state.learned, value=(1.0,))),
        lambda state: None,
        lambda state: 1 / 0,
        lambda state: dataclasses.replace(state, eta=(0.0, 1.0)),
        lambda state: dataclasses.replace(state, water=(0.1, math.nan)),
        lambda state: dataclasses.replace(state, water=(math.inf, 0.0)),
    ],
)
def test_a_wrong_answer_ends_it_until_it_is_disarmed_again(estimator: OwnEstimator, says: object) -> None:
    step(estimator, 0)
    Shifted.says = says
    judged, flown = step(estimator, 1)
    assert flown is judged
    assert [event.names[:2] for event in estimator.told()] == [("estimator", "mine")]
    Shifted.says = None
    judged, flown = step(estimator, 2)
    assert flown is judged
    step(estimator, 3, Mode.DISARMED)
    judged, flown = step(estimator, 4, Mode.DISARMED)
    assert flown.eta.x == judged.eta.x + 1.0
    Shifted.says = says
    told = [len(estimator.told()) for k in range(5, 15) if step(estimator, k, Mode.DISARMED)]
    assert sum(told) == 1  # not a hundred times a second while it lies disarmed


def test_what_it_learns_is_offered_to_the_laws_design_which_guards_itself(estimator: OwnEstimator) -> None:
    def learns(state):
        value = tuple(2.0 for _ in state.learned.value)
        return dataclasses.replace(state, learned=dataclasses.replace(state.learned, value=value))

    Shifted.says = learns
    judged, _ = step(estimator, 0)
    assert set(judged.learned.value) == {2.0}


def test_it_goes_on_after_other_parameters_and_in_the_middle_of_a_log(estimator: OwnEstimator) -> None:
    for k in range(20):
        step(estimator, k)
    memory = memory_pickle.decode(memory_pickle.encode(estimator.freeze()))
    other = OwnEstimator(
        Estimator(PARAMS, Origin(0.6, -2.1), VEHICLE), OwnClass("mine", Shifted, NoParams()), VEHICLE
    ).with_params(dataclasses.replace(PARAMS), Origin(0.6, -2.1))
    other.thaw(memory)
    assert repr(step(other, 20)) == repr(step(estimator, 20))
