"""Parts made again for a station's change: the change takes effect, and what a part remembers stays."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from firmware_py import app, config_files
from firmware_py.autopilot import Parts
from firmware_py.marine import Eta, Nu
from firmware_py.reconfiguration import PartsFactory
from firmware_py.records.command import Applied, FinCommand, ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event_text import texts
from firmware_py.records.fence import HOME, Disc, Fence
from firmware_py.records.health import sound
from firmware_py.records.mission import Mission, Surface, Waypoint
from firmware_py.records.order import Arming, FenceChange, MissionChange, Mode, Order, ParameterChange
from firmware_py.records.sensing import Ahrs, Battery, Heard, silence
from firmware_py.tick import Tick

SHIPPED = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
STATE = StateEstimate(
    Eta(0.0, 0.0, 5.0, 0.0, 0.0, 0.0), Nu(1.5, 0.0, 0.0, 0.0, 0.0, 0.0), 1.0, 0.1, 0.01, 50.0, True, True, True, False
)
TO_THE_NORTH = Mission(tuple(Waypoint(x, 0.0, 5.0, 1.5) for x in (100.0, 200.0, 300.0)))
TO_THE_EAST = Mission(tuple(Waypoint(0.0, y, 5.0, 1.5) for y in (100.0, 200.0, 300.0)))


def made() -> tuple[PartsFactory, Parts]:
    """A factory and its parts; none of these changes touches the estimator, which takes long to make."""
    configuration = config_files.read_configuration(SHIPPED)
    factory = app.parts_factory({**configuration, "mission": {"waypoints": []}, "kept": {}})
    estimator: Any = None
    return factory, Parts(estimator, *(factory.makers()[name]() for name in Parts._fields[1:]))


def speed_up(parts: Parts, k: int, heard: bool = True) -> Applied:
    """What the gate makes of a step to 10 rev/s from rest; the AHRS is heard in that tick, or never."""
    tick, still = Tick(k, 10_000_000), (0.0,) * 4
    frame = silence(4)
    if heard:
        frame = dataclasses.replace(frame, ahrs=Heard(Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), tick.t, True, True))
    previous = Applied(still, 0.0, armed=True, limited=False)
    return parts.gate.limit(tick, ModeState(Mode.HOLD, False, 0), frame, FinCommand(still, 10.0), previous)


def test_a_limit_of_the_gate_that_is_changed_in_flight_holds_from_then_on() -> None:
    factory, parts = made()
    assert speed_up(parts, 0).n == pytest.approx(500.0 / 60.0 * 0.01)
    parts, told = factory.apply((ParameterChange((("safety.gate.n_rate_rpm_s", 60.0),)),), parts)
    assert texts(told) == ["safety.gate.n_rate_rpm_s changed from 500 to 60"]
    assert speed_up(parts, 1).n == pytest.approx(0.01)
    assert speed_up(parts, 40, heard=False).n == pytest.approx(0.01)  # it still knows when the AHRS was last heard
    assert speed_up(parts, 60, heard=False).n == 0.0


def test_what_takes_effect_with_the_next_start_is_refused_in_flight_and_all_stays_as_it_was() -> None:
    factory, parts = made()
    changes = (("control.adoption.enabled", False), ("estimation.learning.enabled", False))
    after, told = factory.apply((ParameterChange(changes),), parts)
    assert after is parts
    assert factory.params.control.adoption.enabled
    assert "estimation.learning.enabled takes effect with the next start alone" in texts(told)[0]


def flown(parts: Parts, k: int, order: Order, x: float = 0.0) -> Reference:
    state = dataclasses.replace(STATE, eta=STATE.eta._replace(x=x))
    return parts.guidance.update(Tick(k, 10_000_000), ModeState(Mode.MISSION, False, 0), order, state)


def test_a_new_mission_is_flown_from_its_first_item_and_a_new_fence_goes_on_with_the_same() -> None:
    factory, parts = made()
    parts, _ = factory.apply((MissionChange(TO_THE_NORTH),), parts)
    assert flown(parts, 0, Order(jump=2)).item == 2
    parts, _ = factory.apply((FenceChange(Fence((Disc(0.0, 0.0, 1000.0),))),), parts)
    assert flown(parts, 1, Order()).item == 2
    parts, failed = factory.apply((MissionChange(TO_THE_EAST),), parts)
    assert not failed
    reference = flown(parts, 2, Order())
    assert (reference.item, reference.waypoint) == (0, 0)
    assert reference.target_distance == pytest.approx(100.0)
    assert reference.target_bearing == pytest.approx(0.5 * math.pi)


def test_a_return_that_replaces_the_mission_in_flight_goes_home_from_there() -> None:
    factory, parts = made()
    parts, _ = factory.apply((MissionChange(TO_THE_NORTH),), parts)
    flown(parts, 0, Order(), 60.0)
    parts, failed = factory.apply((MissionChange(Mission((Surface(rally=True),))),), parts)
    assert not failed
    reference = flown(parts, 1, Order(), 60.0)
    assert reference.rally == HOME
    assert reference.cross_track == pytest.approx(0.0)


def test_a_changed_parameter_that_safety_rests_on_is_told_with_both_values_and_others_are_not() -> None:
    factory, parts = made()
    changes = (
        ("safety.ascent.level_depth_m", 2.0),
        ("safety.ahrs_action", "none"),
        ("safety.ascent.pitch_deg", 12.0),  # as it is
        ("estimation.integrity.enabled", False),
        ("guidance.surface_speed_m_s", 1.2),
    )
    estimator = SimpleNamespace(with_params=lambda *_: estimator)
    parts, told = factory.apply((ParameterChange(changes),), parts._replace(estimator=estimator))
    assert texts(told) == [
        "safety.ascent.level_depth_m changed from 1.5 to 2",
        "safety.ahrs_action changed from surface to none",
        "estimation.integrity.enabled changed from true to false",
    ]
    t = 0.0
    frame = dataclasses.replace(
        silence(4),
        ahrs=Heard(Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), t, True, True),
        pressure=Heard(1.5e5, t, True, True),
        battery=Heard(Battery(48.0, 1.0, 0.9), t, True, True),
        fins=(Heard(0.0, t, True, True),) * 4,
    )
    parts.supervisor.update(Tick(0, 10_000_000), frame, STATE, sound(4), Order(arming=Arming.CHECK), False)
    said = texts(parts.supervisor.events)
    off = "safety.ahrs_action = none, estimation.integrity.enabled = false"
    assert said[-1] == f"set so that it is not brought up: {off}"
