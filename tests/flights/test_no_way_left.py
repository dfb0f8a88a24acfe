"""The bottom, or the deep, comes nearer while ways to turn back are gone: judged by the truth."""

from __future__ import annotations

import numpy as np
import pytest
from sternplane.logs.reading import Log

from tests.shared_flights import Flights
from tests.straight_run import hold, mission, under_way

FLAT = 40.0


def clearance(log: Log, bottom: float = FLAT) -> float:
    """Return the least distance of the middle of the hull from a flat bottom, m."""
    return float((bottom - log.truth["eta.z"]).min())


def released(log: Log) -> bool:
    return bool(log.columns["applied.drop"].any())


@pytest.mark.parametrize(("percent", "rate"), [(1.8, 0.4), (1.0, 0.2)])
def test_a_false_depth_keeps_no_weight_of_a_vehicle_that_sinks_by_its_altitude(
    flown: Flights, percent: float, rate: float
) -> None:
    """The pressure rises as the vehicle sinks, without thrust and without attitude: it ran aground, 0.5 m "deep"."""
    legs = mission(((45.0, 6.0), (85.0, 10.0), (175.0, 28.0), (205.0, 28.0)))
    faults = f"ballast:weight={percent}@0", "off:ahrs@100", f"drift:pressure={-rate}@101", "off:esc@102"
    outcome, log = flown(under_way(260.0, 4.0, legs, faults=faults, rpm=492.0))
    assert released(log)
    assert "aground" not in outcome.reason
    assert clearance(log) > 5.0
    assert log.truth["eta.z"][-1] < 2.0


@pytest.mark.parametrize("percent", [1.5, 1.0])
def test_a_heavy_hull_that_loses_its_way_over_the_bottom_is_lifted_before_its_stern_strikes(
    flown: Flights, percent: float
) -> None:
    """Bow up, its stern is a metre lower than its middle: the weight went as it struck."""
    slower = "[[orders]]\nt_s = 40.0\nspeed_m_s = 0.0\n"
    faults = (f"ballast:weight={percent}@50",)
    outcome, log = flown(under_way(200.0, 19.5, hold(19.5), slower, faults=faults, bottom=22.6))
    assert "surfaced safely" in outcome.reason
    pitch, depth = log.truth["eta.theta"], log.truth["eta.z"]
    assert (22.6 - depth - 2.6 * np.sin(np.maximum(pitch, 0.0))).min() > 0.3
    assert depth[-1] < 1.0


@pytest.mark.parametrize("learning", [False, True])
def test_over_a_slope_that_begins_close_below_it_stops_and_is_lifted(flown: Flights, learning: bool) -> None:
    """8 m above its foot, one in four: going astern took its bow down on it, with the weight aboard, and no fault."""
    foot, rise = 60.0, 0.25
    text = under_way(150.0, 22.0, hold(22.0), bottom=30.0, rpm=492.0, learning=learning)
    places = ((-50.0, 30.0), (foot, 30.0), (foot + 27.0 / rise, 3.0), (900.0, 3.0))
    bottom = ", ".join(f"{{ north_m = {north}, depth_m = {depth} }}" for north, depth in places)
    outcome, log = flown(text.replace("[environment]\n", f"[environment]\nbottom = [{bottom}]\n", 1))
    under = np.clip(30.0 - rise * (log.truth["eta.x"] - foot), 3.0, 30.0)
    assert "aground" not in outcome.reason
    assert (under - log.truth["eta.z"]).min() > 1.5
    assert released(log)


def test_without_its_weight_below_the_limit_it_goes_on_trying_to_drive_up(flown: Flights) -> None:
    """In water that sinks by 0.3 m/s each attempt ended in the tick in which it began, until it was aground."""
    orders = '[[orders]]\nt_s = 0.5\narming = "arm"\n[[orders]]\nt_s = 1.0\nmode = "manual"\nn_rpm = 1000\n'
    sticks = "delta_s_deg = {}\ndelta_r_deg = 0.0\n"
    orders += sticks.format(0.0) + "[[orders]]\nt_s = 12.0\n" + sticks.format(6.0)
    text = under_way(330.0, 4.0, orders, faults=("off:dvl@5",), rpm=492.0)
    outcome, log = flown(text.replace("[0.0, 0.0, 0.0]", "[0.0, 0.0, 0.3]"))
    assert released(log)
    assert "aground" not in outcome.reason
    assert clearance(log) > 3.0
    assert log.truth["eta.z"][-1] < 1.0


@pytest.mark.parametrize("other", ["hold", "mission"])
def test_who_changes_modes_faster_than_limits_count_passes_none(flown: Flights, other: str) -> None:
    """A dive by hand and HOLD in turns, each for 0.4 s: every change began the time of the limit anew."""
    between = f'mode = "{other}"\n' + ("depth_m = 21.0\nspeed_m_s = 2.5\n" if other == "hold" else "")
    turns = ['mode = "manual"\n', between]
    changes = [f"[[orders]]\nt_s = {10.0 + 0.4 * k:.2f}\n{turns[k % 2]}" for k in range(80)]
    changes[0] += "delta_s_deg = 23.0\ndelta_r_deg = 0.0\nn_rpm = 1000\n"
    legs = "[[waypoints]]\nx_m = 400.0\ny_m = 0.0\ndepth_m = 21.0\nspeed_m_s = 2.5\n"
    outcome, log = flown(under_way(90.0, 4.0, hold(6.0), *changes, legs, bottom=24.0, rpm=492.0), seed=2)
    assert log.truth["eta.z"].max() > 12.0
    assert "aground" not in outcome.reason
    assert clearance(log, 24.0) > 0.6


def test_one_false_altitude_after_a_silence_ends_nothing(flown: Flights) -> None:
    """It was the only one for two seconds, the DVL silent: SURFACE, with 28 m of water below."""
    silent = "off:dvl@10", "off:altimeter@20+5", "off:altimeter@25.1+3"
    outcome, log = flown(under_way(40.0, 12.0, hold(12.0), faults=(*silent, "spike:altimeter=-26@25.0")))
    assert outcome.reason == "completed"
    assert set(log.columns["mode.mode"][400:].tolist()) == {2}
