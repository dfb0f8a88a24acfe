"""Parts of one's own in whole flights: of an installed package, in process, failing, and a sensor that is heard."""

from __future__ import annotations

import dataclasses
import os
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import sternplane
from sternplane.logs.reading import read
from sternplane.logs.replay import replay
from sternplane.logs.streaming import stream
from sternplane.sitl.flight import FlightRequest, prepare

from firmware_py import app
from firmware_py.__main__ import main as vehicle
from firmware_py.app import build
from firmware_py.run import over_can
from firmware_py.run.usage_error import UsageError
from tests.command import called
from tests.own_package import install

HOLD = {
    "description": "Hold a depth.",
    "duration_s": 6.0,
    "completes": "time",
    "environment": {"bottom_depth_m": 40.0},
    "start": {"depth_m": 5.0, "u_m_s": 1.8, "n_rpm": 500.0},
    "orders": [{"t_s": 0.1, "arming": "arm"}, {"t_s": 0.2, "mode": "hold", "depth_m": 5.0, "speed_m_s": 1.8}],
    "autopilot": {"estimation": {"learning": {"enabled": False}}},
}
TOML = """
description = "Hold a depth."
duration_s = 4.0
completes = "time"
[start]
depth_m = 5.0
u_m_s = 1.8
n_rpm = 500.0
[[orders]]
t_s = 0.1
arming = "arm"
[[orders]]
t_s = 0.2
mode = "hold"
"""
LAW = ("--set", "autopilot.control.law=tiny", "--set", "autopilot.control.own.k=3.5")


class Failing(sternplane.Law):
    """Steers straight on, and fails after three seconds of it."""

    def update(self, tick, reference, state):
        if tick.t > 3.0:
            raise np.linalg.LinAlgError("Singular matrix")
        return 0.0, 0.0


class TooShallow(sternplane.StateEstimator):
    """Says ten metres less than the depth is, from two seconds on."""

    def update(self, tick, frame, applied, built_in):
        off = 10.0 * min(max(tick.t - 2.0, 0.0) / 2.0, 1.0)
        return dataclasses.replace(built_in, eta=built_in.eta._replace(z=built_in.eta.z - off))


class Probe(sternplane.PayloadSensor):
    """Water that is colder below."""

    keys = ("ctd.temperature", "ctd.salinity")

    def measure(self, plant, chance):
        return 12.0 - 0.1 * plant.eta.z + 0.01 * chance.standard_normal(), 35.0


class Listening(sternplane.GuidanceLaw):
    """Goes down until the water is as cold as it wants."""

    depth = 5.0

    def update(self, tick, proposed, state):
        for reading in state.payload:
            if reading.key == "ctd.temperature":
                self.depth = state.eta.z + 10.0 * (reading.value - 11.2)
        return self.depth, proposed.psi_d, proposed.u_d


def test_a_law_of_an_installed_package_flies_is_reported_and_replays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path / "site")
    (tmp_path / "hold.toml").write_text(TOML)
    with monkeypatch.context() as path:
        path.syspath_prepend(str(tmp_path / "site"))
        flown = called("sitl", "--scenario", "hold.toml", "--out", "run", *LAW, cwd=tmp_path)
        assert flown.returncode == 0, flown.stderr
        log = read(tmp_path / "run" / "log.mcap")
        (own,) = log.header["own_parts"].values()
        assert (own["name"], own["class"], own["package"]) == ("tiny", "tiny_laws:Tiny", "tiny-laws 0.3")
        assert "tiny_laws:Tiny, source " in (tmp_path / "run" / "report.html").read_text()
        again = called("replay", "run", cwd=tmp_path)
        assert (again.returncode, again.stdout) == (0, "400 cycles replayed: every byte equal\n")
        source = tmp_path / "site" / "tiny_laws.py"
        source.write_text(source.read_text() + "\n")
        assert "control.law = tiny flew with source" in called("replay", "run", cwd=tmp_path).stdout
    sys.modules.pop("tiny_laws", None)
    missing = called("replay", "run", cwd=tmp_path)
    assert missing.returncode == 2
    assert missing.stderr.count("\n") == 1
    for words in ("control.law = tiny: no installed package", "it flew with tiny_laws:Tiny of tiny-laws 0.3"):
        assert words in missing.stderr


def test_the_vehicle_s_own_program_knows_such_a_law_and_says_where_it_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made = []
    install(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(over_can, "check", lambda *_: (_ for _ in ()).throw(UsageError("it would fly now")))
    monkeypatch.setattr(app, "build", lambda configuration: made.append(build(configuration)) or made[-1])
    for law, said in (("teeny", "did you mean tiny?"), ("tiny", "it would fly now")):
        assert vehicle(["--set", f"autopilot.control.law={law}", "--out", str(tmp_path / "run")]) == 2
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1
    sys.modules.pop("tiny_laws", None)
    (autopilot,) = made
    assert autopilot.reconfigurator.own.law.name == "tiny"


def test_a_law_that_fails_in_flight_is_replaced_told_and_replays() -> None:
    flight = sternplane.fly(HOLD, law=Failing)
    assert flight.completed
    assert (3.01, "law " + _name(Failing) + " failed, the built-in one goes on: LinAlgError: Singular matrix") in [
        (round(t, 2), text) for t, text in flight.recording.events
    ]
    columns, t = flight.recording.columns, flight.recording.t
    assert not columns["demand.delta_s"][(t > 0.3) & (t < 3.0)].any()
    assert columns["demand.delta_s"][t > 3.2].all()
    assert abs(flight.recording.truth["z"][-1] - 5.0) < 1.0
    assert sternplane.replay(flight.recording).equal


@pytest.mark.parametrize(
    ("kind", "base"),
    [("law", sternplane.Law), ("estimator", sternplane.StateEstimator), ("guidance", sternplane.GuidanceLaw)],
)
@pytest.mark.parametrize("held", [threading.Lock, partial(open, os.devnull), lambda: lambda: None])
def test_a_part_that_holds_what_no_log_can_keep_does_not_fly(kind: str, base: type, held: Callable) -> None:
    class Holding(base):
        def __init__(self, vehicle, params):
            super().__init__(vehicle, params)
            self.held = held()

    with pytest.raises(sternplane.ParamError, match=r"its memory cannot be kept \(.*hold no lock, file or function"):
        sternplane.fly(HOLD, **{kind: Holding})


def test_an_estimator_that_lies_about_the_depth_does_not_blind_the_supervisor() -> None:
    flight = sternplane.fly({**HOLD, "duration_s": 20.0}, estimator=TooShallow, set={"autopilot.safety.depth_max": 7.0})
    recording = flight.recording
    surfaced = [t for t, text in recording.events if "HOLD -> SURFACE: depth" in text]
    assert len(surfaced) == 1
    assert not flight.completed
    assert recording.truth["z"].max() < 10.5
    flown_by_mine = recording.t < surfaced[0]
    off = recording.truth["z"] - recording.estimate["z"]
    assert off[flown_by_mine & (recording.t > 4.1)].min() > 9.0
    assert abs(off[recording.t > surfaced[0]]).max() < 0.5  # what brings it up knows where it is
    assert sternplane.replay(recording).equal


def test_a_sensor_of_one_s_own_is_logged_heard_in_flight_and_replays(tmp_path: Path) -> None:
    mission = {
        **HOLD,
        "orders": [{"t_s": 0.1, "arming": "arm"}, {"t_s": 0.2, "mode": "mission"}],
        "waypoints": [{"x_m": 200.0, "y_m": 0.0, "depth_m": 5.0, "speed_m_s": 1.8}],
    }
    flight = sternplane.fly(mission, sensors=[Probe], guidance=Listening, out=tmp_path)
    t, temperature = flight.recording.payload["ctd.temperature"]
    assert len(t) == 60
    depth = np.interp(t, flight.recording.t, flight.recording.truth["z"])
    noise = temperature - (12.0 - 0.1 * depth)
    assert 0.003 < noise.std() < 0.03
    assert set(flight.recording.payload["ctd.salinity"][1]) == {35.0}
    assert flight.recording.columns["reference.z_d"][-1] > 5.2  # on its way to 8 m
    assert sternplane.replay(flight.recording).equal
    assert replay(stream(tmp_path / "log.mcap"), build).equal


def test_its_noise_is_the_seed_s_and_leaves_the_other_sensors_as_they_were() -> None:
    brief = {**HOLD, "duration_s": 1.0}
    one, two, other = (sternplane.fly(brief, sensors=[Probe, Probe], seed=seed).recording for seed in (1, 1, 2))
    temperatures = [run.payload["ctd.temperature"][1].tolist() for run in (one, two, other)]
    assert temperatures[0] == temperatures[1] != temperatures[2]
    assert temperatures[0][0] != temperatures[0][1]  # the two of them
    without = sternplane.fly(brief, seed=1).recording
    assert np.array_equal(one.columns["frame.dvl.value.u"], without.columns["frame.dvl.value.u"], equal_nan=True)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"keys": None}, "Wrong: its keys cannot be read: TypeError: 'NoneType' object is not iterable"),
        ({"keys": property(lambda self: self.nowhere)}, "its keys cannot be read: AttributeError: "),
        ({"keys": "depth"}, "keys = 'depth': must be a list of texts, such as ('depth',)"),
        ({"keys": (None, 1)}, "key None: must be 1 to 58 characters of ASCII"),
        ({"keys": ("depth", "")}, "key '': must be 1 to 58 characters of ASCII"),
        ({"measure": lambda self, plant, chance: (1.0,)}, "measured 1 values for 2 keys"),
        ({"measure": lambda self, plant, chance: 1 / 0}, "failed at 0.00 s: ZeroDivisionError"),
    ],
)
def test_a_sensor_that_is_wrong_ends_the_simulation_in_one_line(changed: dict, said: str) -> None:
    with pytest.raises(sternplane.ParamError) as caught:
        sternplane.fly(HOLD, sensors=[type("Wrong", (Probe,), changed)])
    assert said in str(caught.value)


def test_two_nodes_under_one_id_are_refused() -> None:
    with pytest.raises(sternplane.ParamError, match="node = 60: another device has this id"):
        sternplane.fly(HOLD, sensors=[Probe, Probe], set={"sensors.payload.1.node": 60})


def test_over_a_simulator_s_link_there_is_no_bus_for_its_messages() -> None:
    with_probe = {**HOLD, "sensors": {"payload": [{"sensor": "nowhere:At", "rate_hz": 1}]}}
    with pytest.raises(sternplane.ParamError, match="payload: there is no bus over mavlink-hil"):
        prepare(FlightRequest("hold", link="mavlink-hil:127.0.0.1:4560", table=with_probe), {})


def _name(cls: type) -> str:
    return f"{cls.__module__}:{cls.__qualname__}"
