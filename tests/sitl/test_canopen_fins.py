"""A vehicle whose fins are on CANopen drives, flown as it is shipped: on the bus of the sensors, and on their own."""

from __future__ import annotations

from pathlib import Path

import pytest
from sternplane.logs.reading import Log
from sternplane.logs.replay import replay
from sternplane.sitl.flight import CONFIG

from firmware_py.app import build
from firmware_py.records.event import EventKind
from tests.sitl.fin_flight import flown_with, lags

IO = CONFIG / "io_canopen.toml"
FINS, SECONDS = 4, 12.0


@pytest.fixture(scope="module")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return flown_with(tmp_path_factory.mktemp("canopen") / "shipped", IO, SECONDS)


def test_fins_are_started_up_armed_and_follow_and_the_flight_replays(shipped: Log) -> None:
    cycles = list(shipped.cycles)
    assert [heard.ok for heard in cycles[49].frame.fins] == [True] * FINS
    armed = [cycle for cycle in cycles if cycle.applied.armed]
    assert armed[0].tick.t == 0.5
    moved = max(abs(angle) for cycle in armed for angle in cycle.applied.fins)
    assert moved > 0.1
    late = lags(cycles)
    assert len(late) > 1000
    assert max(late) < 0.02
    assert not any(shipped.end["losses"][cause] for cause in ("canopen_malformed", "canopen_other_master"))
    compared = replay(shipped, build)
    assert compared.equal, str(compared)


def test_drives_on_a_bus_of_their_own_give_the_same_flight(shipped: Log, tmp_path: Path) -> None:
    io = tmp_path / "io.toml"
    io.write_text(IO.read_text().replace('bus = ""  ', 'bus = "virtual:drives"  '))
    apart = flown_with(tmp_path / "apart", io, SECONDS)
    assert apart.cycle_bytes == shipped.cycle_bytes
    assert apart.end["losses"]["second_bus_not_sent"] == 0


def test_drives_without_power_are_told_and_flown_on_with_when_it_is_back(tmp_path: Path) -> None:
    log = flown_with(tmp_path / "fault", IO, SECONDS, "off:servo_hub@4+2")
    cycles = list(log.cycles)
    told = {event.kind for cycle in cycles for event in cycle.events}
    assert EventKind.NODE_RESTARTED in told
    assert EventKind.ACTUATOR_FAULT in told
    assert not any(heard.fresh for cycle in cycles[420:600] for heard in cycle.frame.fins)
    assert all(heard.ok for heard in cycles[-1].frame.fins)
    assert {log.end["losses"][f"{name}_restarts"] for name in ("stern_port", "rudder_lower")} == {1}
