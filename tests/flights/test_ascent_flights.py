"""Coming up with what is left, judged by where the plant really is."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from sternplane.logs.run import Run
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.records.command import AscentStage
from firmware_py.records.event import EventKind
from firmware_py.records.order import Mode
from tests.shared_flights import Flights
from tests.straight_run import hold, surface, under_way


def text(
    *faults: str, depth: float = 15.0, dive: float = 15.0, at: float = 12.0, time: float = 150.0, watch: float = 0.0
) -> str:
    """Return a flight in which something breaks; SURFACE is ordered at a time, s, unless a rule does it before."""
    orders = hold(dive), surface(at)
    return under_way(
        time, depth, *orders, completes="surfaced", faults=faults, bottom=60.0, eddies=0.1, rpm=492.0, watch=watch
    )


def accused(log: Run) -> set[str]:
    """Return the sensors that were ever suspect."""
    return {e.names[0] for _, events in log.events for e in events if e.kind is EventKind.SENSOR_SUSPECT}


@pytest.mark.parametrize("at", [10.0, 30.0], ids=["in a dive", "from level"])
def test_remus_100_comes_up_under_power(flown: Flights, at: float) -> None:
    """It dived and put its bow down to 48 deg: its heave turned it faster than the pitch law."""
    told = under_way(120.0, 8.0, hold(20.0), surface(at), completes="surfaced", bottom=45.0, eddies=0.05, rpm=1700.0)
    outcome, log = flown(told, vehicle="remus100")
    up = log.columns["mode.mode"] == Mode.SURFACE
    assert outcome.completed
    assert (log.columns["mode.ascent"][up] <= AscentStage.LEVEL).all()
    assert not log.columns["mode.drop"].any()
    coming = log.columns["tick.t"] > at + 5.0 if "tick.t" in log.columns else slice(int(100 * (at + 5.0)), None)
    assert log.truth["eta.theta"][coming].min() > math.radians(-8.0)


@pytest.mark.parametrize("learning", [True, False])
def test_in_a_current_from_astern_it_climbs_without_its_weight_too(flown: Flights, learning: bool) -> None:
    """By the speed over the ground its propeller stood: it stayed at 22 m, sound, with a leak, for good."""
    orders, stuck = (hold(10.0), surface(45.0)), ("stuck:weight@0",)
    told = under_way(170.0, 10.0, *orders, completes="surfaced", faults=stuck, current=(1.2, 0.0), learning=learning)
    _, log = flown(told)
    assert log.truth["eta.z"].max() < 11.0
    assert log.truth["eta.z"][-1] < 0.6
    assert log.columns["mode.mode"][-1] == Mode.DISARMED


def test_planes_jammed_in_a_dive_cost_the_weight_and_not_the_vehicle(flown: Flights) -> None:
    jam = ("jam:stern_port=23@8", "jam:stern_starboard=23@8")
    _, log = flown(text(*jam, depth=12.0, dive=25.0), seed=1001)
    c = log.columns
    assert c["mode.drop"][-1]
    assert (c["mode.ascent"] == AscentStage.REVERSE).any()
    assert c["applied.n"].min() < -10.0
    assert log.truth["eta.z"].max() < 22.0
    assert c["mode.mode"][-1] == Mode.DISARMED
    assert log.truth["eta.z"][-1] < 0.6
    assert accused(log) == set()


def test_planes_jammed_unreported_are_told_by_their_consequence_and_depth_stays_known_without_bottom_in_reach(
    flown: Flights,
) -> None:
    jam = ("silent:servo_hub@3", "jam:stern_port=23@10", "jam:stern_starboard=23@10")
    _, log = flown(text(*jam, at=140.0), seed=1001)
    assert log.columns["mode.drop"][-1]
    assert log.truth["eta.z"].max() < 21.0
    assert log.columns["mode.mode"][-1] == Mode.DISARMED
    assert log.truth["eta.z"][-1] < 0.6
    assert accused(log) <= {"dvl"}  # the bottom is out of its reach
    assert abs(log.columns["state.eta.z"][-1] - log.truth["eta.z"][-1]) < 0.5


def test_a_vehicle_that_rolls_over_stops_at_once_and_comes_up_without_its_weight(flown: Flights) -> None:
    _, log = flown(text("ballast:z_G=-0.081@5", at=140.0), seed=1001)  # 6.1 cm below the middle before
    c = log.columns
    over = abs(log.truth["eta.phi"]) > math.radians(100.0)
    assert over.any()
    released = c["t"][c["mode.drop"].argmax()]
    assert c["mode.drop"][-1]
    assert released < log.truth["t"][over.argmax()] + 15.0
    assert (c["mode.ascent"] == AscentStage.STOPPED).any()
    assert log.truth["eta.z"].max() < 18.0
    assert c["mode.mode"][-1] == Mode.DISARMED
    assert log.truth["eta.z"][-1] < 0.6
    assert "pressure" not in accused(log)


@pytest.mark.parametrize("faults", [("off:pressure@5",), ("off:pressure@5", "off:dvl@3")], ids=["dvl", "no dvl"])
def test_without_depth_a_fix_tells_of_the_surface_and_the_bow_does_not_hang_out(
    flown: Flights, faults: tuple[str, ...]
) -> None:
    _, log = flown(text(*faults, depth=4.0, dive=4.0), seed=1001)
    c = log.columns
    assert not c["mode.drop"][-1]
    assert c["mode.mode"][-1] == Mode.DISARMED
    assert log.truth["eta.z"][-1] < 0.6


def test_a_fix_that_comes_without_a_variance_tells_of_the_surface_too(tmp_path: Path) -> None:
    scenario, log = tmp_path / "up.toml", tmp_path / "log.mcap"
    scenario.write_text(text(depth=3.0, dive=3.0, at=2.0, time=60.0))
    request = FlightRequest(scenario=str(scenario), settings=("sensors.fix.noise_m=0",))
    assert fly(prepare(request, {}), log).completed


def test_a_pitch_that_follows_its_own_wrong_gyro_is_not_flown_up_by(flown: Flights) -> None:
    wrong = ("drift:ahrs.pitch=0.5@5", "bias:ahrs.q=0.5@5")
    _, log = flown(text(*wrong, depth=12.0, dive=12.0, at=30.0, time=250.0), seed=1001)
    assert log.truth["eta.z"].max() < 20.0
    assert log.columns["mode.mode"][-1] == Mode.DISARMED
    assert log.truth["eta.z"][-1] < 0.6


@pytest.mark.parametrize("seed", [1003, 1005])
def test_who_hangs_below_the_surface_comes_up_without_its_weight(flown: Flights, seed: int) -> None:
    _, log = flown(text("ballast:weight=2@5", depth=5.0, dive=5.0, time=200.0), seed=seed)
    c = log.columns
    assert c["mode.drop"][-1]
    assert c["mode.mode"][-1] == Mode.DISARMED
    assert log.truth["eta.z"][-1] < 0.6


def test_a_leak_costs_the_weight_at_the_surface_and_what_came_in_does_not_pull_it_down_again(flown: Flights) -> None:
    faults = ("set:leak=100@5", "ballast:weight=0.8@5")
    _, log = flown(text(*faults, depth=4.0, dive=4.0, time=200.0, watch=60.0), seed=1000)
    c = log.columns
    disarmed = c["t"][(c["mode.mode"] == Mode.DISARMED) & (c["t"] > 5.0)]
    assert disarmed[-1] - disarmed[0] >= 59.9
    assert c["mode.drop"][-1]
    assert log.truth["eta.z"][-1] < 0.6


def test_who_sinks_after_it_disarmed_itself_comes_up_again(flown: Flights) -> None:
    _, log = flown(text("ballast:weight=0.8@5", depth=4.0, dive=4.0, time=250.0, watch=60.0), seed=1000)
    c, z = log.columns, log.truth["eta.z"]
    modes = [m for m, before in zip(c["mode.mode"][1:], c["mode.mode"][:-1], strict=True) if m != before]
    assert modes[-4:] == [Mode.SURFACE, Mode.DISARMED, Mode.SURFACE, Mode.DISARMED]
    assert c["mode.drop"][-1]
    assert z[c["t"] > 40.0].max() < 4.5  # it gathers way before it climbs by power alone, the first time
    assert z[-1] < 0.6


def test_at_the_surface_a_pressure_that_is_off_from_the_start_does_not_keep_it_from_being_done(flown: Flights) -> None:
    off = ("bias:pressure=0.3@0", "bias:pressure=0.3@1")
    _, log = flown(under_way(120.0, 3.0, hold(3.0), surface(12.0), completes="surfaced", faults=off), seed=1000)
    assert log.columns["mode.mode"][-1] == Mode.DISARMED
    assert not log.columns["mode.drop"][-1]
    assert log.truth["eta.z"][-1] < 0.6
