"""A guidance law of one's own chooses setpoints in a mission, within the limits, and nowhere else."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import pytest

from firmware_py.adapters.storage import memory_pickle
from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.guidance.own_guidance import GuidanceLaw, OwnGuidance
from firmware_py.own_part import NoParams, OwnClass
from firmware_py.params import load
from firmware_py.records.command import ModeState
from firmware_py.records.order import NO_ORDER, Mode
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Vehicle
from tests.unit.firmware_py.guidance.test_guidance import SQUARE, state

CONFIG = Path(__file__).resolve().parents[4] / "configs" / "npsauv2"
VEHICLE = load(Vehicle, tomllib.loads((CONFIG / "vehicle.toml").read_text()), "vehicle.toml")
PARAMS = GuidanceParams()
DEEPEST = 20.0


class Deeper(GuidanceLaw):
    """Two metres deeper than the mission; what the test says beyond."""

    says: object = None
    done = False
    asked = 0

    def update(self, tick, proposed, state):
        Deeper.asked += 1
        self.finished = Deeper.done
        if isinstance(Deeper.says, Exception):
            raise Deeper.says
        return Deeper.says or proposed._replace(z_d=proposed.z_d + 2.0)


@pytest.fixture
def guidance() -> OwnGuidance:
    Deeper.says, Deeper.done, Deeper.asked = None, False, 0
    return OwnGuidance(OwnClass("mine", Deeper, NoParams()), VEHICLE, PARAMS, SQUARE, DEEPEST, 2.0)


def fly(guidance: Guidance, mode: Mode, seconds: float, k: int = 0) -> list:
    return [
        guidance.update(Tick(k + i, 50_000_000), ModeState(mode, False, 0), NO_ORDER, state())
        for i in range(round(20 * seconds))
    ]


def test_a_mission_is_flown_as_it_says_and_smoothed_as_ever(guidance: OwnGuidance) -> None:
    built_in = Guidance(PARAMS, SQUARE, DEEPEST, 2.0)
    mine, theirs = fly(guidance, Mode.MISSION, 60.0), fly(built_in, Mode.MISSION, 60.0)
    assert mine[-1].z_d == pytest.approx(theirs[-1].z_d + 2.0, abs=1e-6)
    assert mine[-1].psi_d == theirs[-1].psi_d
    assert max(abs(one.z_d_dot) for one in mine) <= PARAMS.climb_max


def test_what_it_wants_is_held_to_depth_and_speed(guidance: OwnGuidance) -> None:
    Deeper.says = (500.0, 20.0 * math.pi, 90.0)
    last = fly(guidance, Mode.MISSION, 120.0)[-1]
    assert (last.z_d, last.u_d) == pytest.approx((DEEPEST, PARAMS.speed_max), abs=1e-3)
    Deeper.says = (-5.0, 0.0, -1.0)
    last = fly(guidance, Mode.MISSION, 240.0, k=2400)[-1]
    assert (last.z_d, last.u_d) == pytest.approx((0.0, 0.0), abs=1e-3)


@pytest.mark.parametrize("mode", [mode for mode in Mode if mode is not Mode.MISSION])
def test_it_is_asked_in_no_other_mode(guidance: OwnGuidance, mode: Mode) -> None:
    fly(guidance, mode, 1.0)
    assert Deeper.asked == 0


@pytest.mark.parametrize("wrong", [(math.nan, 0.0, 1.0), (1.0,), ValueError("x")], ids=str)
def test_a_wrong_answer_ends_it_and_the_legs_go_on(guidance: OwnGuidance, wrong: object) -> None:
    fly(guidance, Mode.MISSION, 1.0)
    Deeper.says = wrong
    told = []
    for k in range(20, 1500):
        fly(guidance, Mode.MISSION, 0.05, k)
        told += guidance.events
    assert [event.names[:2] for event in told if event.names] == [("guidance", "mine")]
    legs = Guidance(PARAMS, SQUARE, DEEPEST, 2.0)
    fly(legs, Mode.MISSION, 75.0)
    assert guidance.last.z_d == pytest.approx(legs.last.z_d, abs=1e-6)
    assert Deeper.asked == 21


def test_it_may_end_the_mission(guidance: OwnGuidance) -> None:
    fly(guidance, Mode.MISSION, 1.0)
    assert not guidance.finished
    Deeper.done = True
    fly(guidance, Mode.MISSION, 0.05, 20)
    assert guidance.finished


def test_its_memory_is_data_and_goes_on(guidance: OwnGuidance) -> None:
    fly(guidance, Mode.MISSION, 5.0)
    memory = memory_pickle.decode(memory_pickle.encode(guidance.freeze()))
    other = OwnGuidance(OwnClass("mine", Deeper, NoParams()), VEHICLE, PARAMS, SQUARE, DEEPEST, 2.0)
    other.thaw(memory)
    assert fly(other, Mode.MISSION, 5.0, 100) == fly(guidance, Mode.MISSION, 5.0, 100)
