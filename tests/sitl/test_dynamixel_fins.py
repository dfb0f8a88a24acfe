"""A vehicle whose fins are on Dynamixel servos, flown as it is shipped."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import pytest
from sternplane.logs.reading import Log
from sternplane.logs.replay import replay
from sternplane.sitl.flight import CONFIG

from firmware_py.app import build
from firmware_py.records.event import EventKind
from firmware_py.records.health import ActuatorFault
from firmware_py.records.order import Mode
from firmware_py.wire.serial.dynamixel_x import COUNTS_PER_TURN
from sim_bridge.devices.dynamixel_servos import DynamixelFins
from tests.sitl.fin_flight import flown_with, lags

IO = CONFIG / "io_dynamixel.toml"
FINS, SECONDS = 4, 8.0


@pytest.fixture(scope="module")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return flown_with(tmp_path_factory.mktemp("dynamixel") / "shipped", IO, SECONDS)


def test_servos_are_set_up_armed_and_follow_and_the_flight_replays(shipped: Log) -> None:
    cycles = list(shipped.cycles)
    assert [heard.ok for heard in cycles[49].frame.fins] == [True] * FINS
    armed = [cycle for cycle in cycles if cycle.applied.armed]
    assert armed[0].tick.t == 0.5
    assert max(abs(angle) for cycle in armed for angle in cycle.applied.fins) > 0.1
    late = lags(cycles)
    assert len(late) > 500
    assert max(late) < 0.02
    assert not any(
        count for cause, count in shipped.end["losses"].items() if "fins" in cause or cause.endswith("_missed")
    )
    compared = replay(shipped, build)
    assert compared.equal, str(compared)


def test_the_same_flight_again_is_the_same_byte_for_byte(shipped: Log, tmp_path: Path) -> None:
    assert flown_with(tmp_path / "again", IO, SECONDS).cycle_bytes == shipped.cycle_bytes


def test_servos_without_power_are_told_and_flown_on_with_when_it_is_back(tmp_path: Path) -> None:
    log = flown_with(tmp_path / "fault", IO, SECONDS, "off:servo_hub@3+2")
    cycles = list(log.cycles)
    told = {event.kind for cycle in cycles for event in cycle.events}
    assert {EventKind.NODE_RESTARTED, EventKind.ACTUATOR_FAULT, EventKind.ACTUATOR_GOOD} <= told
    assert not any(heard.fresh for cycle in cycles[320:500] for heard in cycle.frame.fins)
    assert all(heard.ok for heard in cycles[-1].frame.fins)
    assert {log.end["losses"][f"{name}_restarts"] for name in ("stern_port", "rudder_lower")} == {1}


def test_one_silent_servo_is_steered_on_and_the_others_are_heard(tmp_path: Path) -> None:
    log = flown_with(tmp_path / "silent", IO, SECONDS, "silent:stern_port@2+4")
    cycles = list(log.cycles)
    assert not any(cycle.frame.fins[0].fresh for cycle in cycles[210:600])
    for fin in (1, 2, 3):
        assert sum(cycle.frame.fins[fin].fresh for cycle in cycles[300:600]) > 90
    assert cycles[-1].frame.fins[0].ok
    faulty = [event for cycle in cycles for event in cycle.events if event.kind is EventKind.ACTUATOR_FAULT]
    assert {name for event in faulty for name in event.names} == {"stern_port"}


def test_a_sound_fin_that_is_reported_a_turn_away_is_a_warning_and_costs_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told, truly = itertools.count(), DynamixelFins.publish_status

    def a_turn_away(self: DynamixelFins, fins: Sequence[float], servos: Sequence[float] = ()) -> None:
        truly(self, fins, servos)
        if next(told) > 300:
            self._servos[0].position += COUNTS_PER_TURN

    monkeypatch.setattr(DynamixelFins, "publish_status", a_turn_away)
    log = flown_with(tmp_path / "turn", IO, SECONDS)
    cycles = list(log.cycles)
    faults = {(name, event.cause) for cycle in cycles for event in cycle.events for name in event.names}
    assert cycles[-1].actuators.fins == (ActuatorFault.SILENT, *[ActuatorFault.NONE] * 3)
    assert {name for name, _ in faults} == {"stern_port"}
    assert {cycle.mode.mode for cycle in cycles[100:]} == {Mode.HOLD}
    assert not any(cycle.applied.drop for cycle in cycles)
    assert log.end["losses"]["stern_port_impossible_angles"] > 100
