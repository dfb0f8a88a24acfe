"""Fixes against the depth: under water none can be heard, and who was heard there says nothing of the surface."""

from __future__ import annotations

import math

import pytest

from firmware_py.estimation.integrity.fix_check import FixCheck
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.estimation.integrity.vertical_check import VerticalCheck
from firmware_py.records.health import SourceFault
from firmware_py.records.sensing import Fix, Heard

PARAMS = IntegrityParams()
DEEP, SHALLOW = 15.0, 0.5


class Receiver:
    """One that tells of the same place once a second, and what carries the depth meanwhile."""

    def __init__(self) -> None:
        self.check = FixCheck(PARAMS.fix_sigmas, PARAMS.fix_deep, PARAMS.surface)
        self.watch = SourceWatch(3.0, math.inf, 9, 0)
        self.vertical = VerticalCheck(PARAMS)
        self.t = 0.0

    def hear(self, seconds: int, depth: float, pressure: bool, *, silent: bool = False, carries: str = "dvl") -> bool:
        """Go on for so many seconds at a depth, m, that is carried on; return whether the last fix was used."""
        used, memory = False, self.vertical.memory
        for _ in range(seconds):
            self.t += 1.0
            memory.carried, memory.residual = depth, 0.0
            memory.t_carried = self.t if carries != "nothing" else memory.t_carried
            memory.blind += carries == "model"
            self.check.drift(self.t, pressure, self.vertical)
            if not silent:
                heard = Heard(Fix(0.5, 0.1, 2.0), self.t, True, True)
                used = self.check.check(heard, self.t, depth if pressure else math.nan, depth, self.watch)
            self.watch.judge(self.t, 1.0, 5.0, 0.0)
        return used


def test_a_receiver_heard_under_water_stays_impossible_until_a_depth_says_that_the_vehicle_came_up() -> None:
    receiver = Receiver()
    assert receiver.hear(10, SHALLOW, pressure=True)
    assert not receiver.hear(10, DEEP, pressure=True)
    assert not receiver.hear(300, DEEP, pressure=False, carries="nothing")  # however long the pressure is lost
    assert receiver.watch.memory.fault is SourceFault.IMPOSSIBLE
    assert not receiver.hear(10, 2.0, pressure=False)
    assert receiver.hear(10, SHALLOW, pressure=False)


def test_under_a_good_pressure_again_it_is_judged_by_that() -> None:
    receiver = Receiver()
    receiver.hear(10, DEEP, pressure=True)
    receiver.hear(10, DEEP, pressure=False)
    assert receiver.hear(10, 2.0, pressure=True)


def test_after_a_silence_it_begins_anew() -> None:
    receiver = Receiver()
    receiver.hear(10, DEEP, pressure=True)
    receiver.hear(200, 5.0, pressure=False, silent=True)
    assert receiver.hear(10, 5.0, pressure=False)  # what carries the depth may be off by more


@pytest.mark.parametrize(("carries", "holds"), [("dvl", 60), ("model", 20), ("nothing", 5)])
def test_a_depth_that_is_carried_on_speaks_against_fixes_for_as_long_as_it_is_surely_deep(
    carries: str, holds: int
) -> None:
    receiver = Receiver()
    receiver.hear(10, DEEP, pressure=True, silent=True)
    assert not receiver.hear(holds, DEEP, pressure=False, carries=carries)
    assert receiver.hear(2 * holds, DEEP, pressure=False, carries=carries)


def test_where_no_depth_was_ever_known_fixes_tell_of_the_surface() -> None:
    assert Receiver().hear(10, math.nan, pressure=False)


def test_thawed_it_goes_on_as_the_frozen_one() -> None:
    one, other = Receiver(), Receiver()
    one.hear(10, DEEP, pressure=True)
    other.check.thaw(one.check.freeze())
    other.vertical.thaw(one.vertical.freeze())
    other.t = one.t
    assert one.hear(20, 2.0, pressure=False) is other.hear(20, 2.0, pressure=False) is False
    assert one.check.memory == other.check.memory
