"""The drop weight: released is what its hardpoint says, not what was commanded."""

from __future__ import annotations

import math

import pytest

from firmware_py.records.health import WeightState
from firmware_py.records.sensing import NO_HARDPOINT, Hardpoint, Heard
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.drop_weight import DropWeightWatch

W = 1335.0
HOLDS, OPEN, LOADED = Hardpoint(True, W), Hardpoint(False, 0.0), Hardpoint(False, 0.9 * W)
UNREPORTED, HELD, SILENT, COMMANDED, RELEASED, STUCK, NOT_CONFIRMED, GONE = WeightState


class Watched:
    """A watch that looks ten times a second at a hardpoint that reports five times a second."""

    def __init__(self, weight: float = W) -> None:
        self.watch = DropWeightWatch(ActuatorParams(), weight)
        self.k, self.heard = 0, NO_HARDPOINT
        self.states: list[tuple[float, WeightState]] = []

    def go(self, seconds: float, says: Hardpoint | None, commanded: bool = False, ok: bool = True) -> WeightState:
        for _ in range(round(10 * seconds)):
            t, self.k = 0.1 * self.k, self.k + 1
            if says is not None and self.k % 2:
                self.heard = Heard(says, t, True, ok)
            before = self.watch.state
            if self.watch.update(t, self.heard, commanded) is not before:
                self.states.append((t, self.watch.state))
        return self.watch.state


def test_a_release_is_told_when_the_hardpoint_says_so() -> None:
    held = Watched()
    assert held.go(5.0, HOLDS) is HELD
    assert held.go(1.0, HOLDS, commanded=True) is COMMANDED
    assert held.go(0.2, OPEN, commanded=True) is RELEASED
    assert held.go(60.0, OPEN, commanded=True) is RELEASED
    assert held.go(60.0, None, commanded=True) is RELEASED  # silence takes nothing back
    assert [state for _, state in held.states] == [HELD, COMMANDED, RELEASED]


def test_a_weight_that_is_held_on_is_stuck_after_the_time_and_released_if_it_goes_after_all() -> None:
    held = Watched()
    held.go(5.0, HOLDS)
    held.go(10.0, HOLDS, commanded=True)
    times = {state: t for t, state in held.states}
    assert times[STUCK] - times[COMMANDED] == pytest.approx(ActuatorParams().release_time, abs=0.2)
    assert held.go(1.0, OPEN, commanded=True) is RELEASED


@pytest.mark.parametrize("before", [0.0, 30.0])
def test_a_silent_hardpoint_does_not_confirm(before: float) -> None:
    held = Watched()
    held.go(5.0, HOLDS)
    held.go(before, None)
    assert held.watch.state is (SILENT if before else HELD)
    held.go(2.5, None, commanded=True)
    assert held.watch.state is COMMANDED
    assert held.go(1.0, None, commanded=True) is NOT_CONFIRMED
    assert held.go(1.0, HOLDS, commanded=True) is STUCK
    assert held.go(1.0, OPEN, commanded=True) is RELEASED


def test_what_a_node_says_that_is_not_believed_confirms_nothing() -> None:
    held = Watched()
    held.go(5.0, HOLDS)
    assert held.go(5.0, OPEN, commanded=True, ok=False) is NOT_CONFIRMED


def test_a_relay_says_nothing_and_nothing_is_said_of_it() -> None:
    relay = Watched()
    relay.go(60.0, None)
    relay.go(60.0, None, commanded=True)
    assert not relay.states


def test_a_vehicle_without_a_weight_does_not_look_at_a_hardpoint() -> None:
    without = Watched(math.nan)
    without.go(10.0, OPEN)
    assert not without.states


def test_a_load_that_still_hangs_is_held_whatever_the_hardpoint_says() -> None:
    held = Watched()
    held.go(5.0, HOLDS)
    assert held.go(5.0, LOADED, commanded=True) is STUCK
    assert held.go(1.0, Hardpoint(False, math.nan), commanded=True) is RELEASED


def test_one_false_report_loses_no_weight_and_a_lasting_one_does() -> None:
    held = Watched()
    held.go(5.0, HOLDS)
    held.go(0.2, OPEN)
    assert held.go(5.0, HOLDS) is HELD
    assert held.go(5.0, OPEN) is GONE
    assert held.go(30.0, None) is GONE
    assert held.go(5.0, OPEN, commanded=True) is GONE
    assert [state for _, state in held.states] == [HELD, GONE]


def test_silence_of_a_hardpoint_is_told_and_ends() -> None:
    held = Watched()
    held.go(5.0, HOLDS)
    held.go(5.0, None)
    held.go(5.0, HOLDS)
    assert [state for _, state in held.states] == [HELD, SILENT, HELD]
    assert held.states[1][0] == pytest.approx(4.8 + ActuatorParams().weight_timeout, abs=0.11)
