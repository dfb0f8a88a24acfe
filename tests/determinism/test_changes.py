"""What a station changes in flight: it changes what the vehicle does, is in the log, and is replayed to the byte."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.ground.mavlink_ground import Grounds
from firmware_py.app import build
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.records.mission import Mission, Waypoint
from firmware_py.records.order import NO_ORDER, MissionChange, Mode, Order, ParameterChange
from firmware_py.tick import Tick
from tests.dive import dive

MISSION = MissionChange(Mission((Waypoint(0.0, 200.0, 6.0, 1.5),)))
PID, LAG, LIMIT, FLY, BAD = 700, 900, 1100, 1200, 1400
ORDERS: dict[int, Order] = {
    PID: Order(changes=(ParameterChange((("control.law", "pid"),)),)),
    LAG: Order(
        changes=(ParameterChange((("estimation.attitude.tau_rate_s", 0.1), ("guidance.pitch_max_deg", 5))),),
    ),
    LIMIT: Order(changes=(ParameterChange((("safety.depth_max_m", 40.0),)), MISSION)),
    FLY: Order(mode=Mode.MISSION),
    BAD: Order(changes=(ParameterChange((("control.u_min_m_s", 4.5),)), ParameterChange((("weather", 1),)))),
}


class Station:
    """Orders what it has for a tick."""

    def read(self, tick: Tick) -> Order:
        return ORDERS.get(tick.k, NO_ORDER)

    def write(self, cycle: Cycle) -> None:
        pass


def flown(folder: Path, *others: Any) -> Log:
    scenario = folder / "scenario.toml"
    scenario.write_text(dive(16.0))
    outcome = fly(
        prepare(FlightRequest(scenario=str(scenario)), {}),
        folder / "log.mcap",
        command=lambda pilot: Grounds(pilot, *others),
    )
    assert outcome.completed, outcome
    return read(folder / "log.mcap")


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return flown(tmp_path_factory.mktemp("quiet"))


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return flown(tmp_path_factory.mktemp("changed"), Station())


def test_a_law_that_is_chosen_in_flight_steers_from_that_tick(quiet: Log, changed: Log) -> None:
    sigma, rudder = changed.columns["demand.sigma_z"], changed.columns["demand.delta_r"]
    assert changed.cycle_bytes[:PID] == quiet.cycle_bytes[:PID]
    assert (sigma[300:PID] != 0.0).all()
    assert (sigma[PID:] == 0.0).all()
    assert (quiet.columns["demand.sigma_z"][PID:] != 0.0).all()
    assert rudder[PID] != quiet.columns["demand.delta_r"][PID]


def test_what_the_parts_remembered_goes_on_over_a_change(quiet: Log, changed: Log) -> None:
    for name in ("state.eta.z", "state.eta.psi", "reference.z_d", "reference.psi_d"):
        before, after = changed.columns[name][LAG - 1], changed.columns[name][LAG]
        assert abs(after - before) < 0.05, name
    assert (changed.columns["mode.mode"][LAG : FLY - 1] == Mode.HOLD).all()
    assert changed.columns["state.learned.dropped"][-1] == quiet.columns["state.learned.dropped"][-1]


def test_a_mission_that_comes_in_flight_can_be_flown(changed: Log) -> None:
    assert (changed.columns["mode.mode"][FLY:] == Mode.MISSION).all()
    heading = changed.columns["reference.psi_d"]
    assert abs(heading[-1] - 1.5707963) < abs(heading[FLY] - 1.5707963)


def test_a_change_that_cannot_be_made_is_said_and_changes_nothing(changed: Log) -> None:
    failed = [e for _, events in changed.events for e in events if e.kind is EventKind.CHANGE_FAILED]
    assert len(failed) == 2
    assert "u_min_m_s = 4.5: must be below u_max_m_s = 4" in failed[0].names[0]
    assert "weather" in failed[1].names[0]


def test_the_log_gives_the_orders_back_as_they_were(changed: Log) -> None:
    given = {cycle.tick.k: cycle.order.changes for cycle in changed.cycles if cycle.order.changes}
    assert given == {k: order.changes for k, order in ORDERS.items() if order.changes}


def test_a_replay_makes_the_same_changes_and_gives_every_byte_again(changed: Log) -> None:
    result = replay(changed, build)
    assert result.cycles == 1600
    assert result.equal, str(result)


def test_without_what_was_changed_a_replay_is_another_flight(changed: Log) -> None:
    topics = {name: topic for name, topic in changed.topics.items() if name != "/changes"}
    result = replay(dataclasses.replace(changed, topics=topics), build)
    assert result.first is not None
    assert result.first.tick == PID


def test_an_autopilot_thawed_after_the_changes_goes_on_as_the_one_that_made_them(changed: Log) -> None:
    cycles = list(changed.cycles)
    one, other = (build(changed.header["configuration"]) for _ in range(2))
    for cycle in cycles[: FLY + 50]:
        one.step(cycle.tick, cycle.frame, cycle.order)
    other.thaw(one.freeze())
    for cycle in cycles[FLY + 50 : FLY + 150]:
        again = other.step(cycle.tick, cycle.frame, cycle.order)
        assert changed.codec.encode(again) == changed.codec.encode(cycle)
