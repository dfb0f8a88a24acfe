"""Two devices of a role in flight, and the first of them all fail: judged by where the plant goes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.reading import Log, read
from sternplane.logs.replay import replay
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.adapters.installation import configs
from firmware_py.app import build
from firmware_py.params import ParamError
from firmware_py.records.event import EventKind
from firmware_py.records.health import Role
from tests.straight_run import hold, under_way

IO = configs() / "npsauv2" / "io_spares.toml"
DEPTH = 8.0
FAULTS = ["freeze:pressure@8", "off:dvl@9", "off:ahrs@10"]


def flight(folder: Path, faults: list[str], name: str = "log") -> Log:
    scenario = folder / "scenario.toml"
    scenario.write_text(under_way(20.0, DEPTH, hold(DEPTH), faults=faults))
    log = folder / f"{name}.mcap"
    outcome = fly(prepare(FlightRequest(str(scenario), io=IO), {}), log)
    assert outcome.completed
    return read(log)


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> Log:
    return flight(tmp_path_factory.mktemp("sound"), [])


@pytest.fixture(scope="module")
def struck(tmp_path_factory) -> Log:
    return flight(tmp_path_factory.mktemp("struck"), FAULTS)


def told(log: Log) -> list[tuple[float, str, float]]:
    """When which role believed which of its devices, from 1."""
    return [
        (t, event.names[0], event.numbers[0])
        for t, events in log.events
        for event in events
        if event.kind is EventKind.CANDIDATE_BELIEVED
    ]


def test_without_a_fault_the_first_of_each_is_believed_and_flies_as_alone(sound: Log) -> None:
    assert told(sound) == []
    c = sound.columns
    assert c["frame.spare_pressure.fresh"].sum() > 300
    first, second = c["frame.pressure.value"], c["frame.spare_pressure.value"][:, 0]
    assert 20.0 < np.std((first - second)[c["t"] > 1.0]) < 200.0  # noise of its own


def test_when_the_first_of_each_fails_the_second_flies_on(sound: Log, struck: Log) -> None:
    (t_p, *pressure), (t_d, *dvl), (t_a, *ahrs) = told(struck)
    assert (pressure, dvl, ahrs) == (["pressure", 2.0], ["dvl", 2.0], ["ahrs", 2.0])
    assert (8.0 < t_p < 9.0, 9.0 < t_d < 10.3, 10.0 < t_a < 10.4) == (True, True, True)
    late = sound.truth["t"] > 8.0
    for name, most in (("eta.z", 0.05), ("eta.psi", 0.02), ("nu.u", 0.05)):
        assert np.max(np.abs(struck.truth[name] - sound.truth[name])[late]) < most
    assert struck.columns["state.depth_ok"].all()
    assert struck.columns["state.attitude_ok"][20:].all()


def test_the_log_shows_the_loser_and_why(struck: Log) -> None:
    c = struck.columns
    roles, believed = c["state.candidates.role"][-1], c["state.candidates.believed"][-1]
    assert roles.tolist() == [Role.AHRS] * 2 + [Role.DVL] * 2 + [Role.PRESSURE] * 2
    assert believed.tolist() == [False, True] * 3
    frozen = c["frame.pressure.value"][c["t"] > 9.0]
    assert np.ptp(frozen) == 0.0
    assert np.ptp(c["frame.spare_pressure.value"][c["t"] > 9.0]) > 0.0


def test_it_flies_and_replays_to_the_byte(tmp_path: Path, struck: Log) -> None:
    again = flight(tmp_path, FAULTS, "again")
    assert again.cycle_bytes == struck.cycle_bytes
    assert replay(struck, build).differing == 0


def test_a_fault_of_a_device_that_the_io_file_does_not_have_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParamError, match=r"the io file has no fix\.2"):
        flight(tmp_path, ["off:fix.2@5"])
