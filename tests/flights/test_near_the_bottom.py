"""A bottom that rises, and dives by hand, judged by where the plant really is: it turns back in time."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_py.records.event import Cause
from tests.shared_flights import Flights
from tests.straight_run import hold, under_way

FLAT, TOP = 40.0, 8.0
FOOT = 20.0
"""Depths before the slope and above it, and where it begins, north, m."""


def over_a_slope(rise: float, foot: float = FOOT, current: float = 0.0, learning: bool = False) -> str:
    """Return a flight at 20 m over a bottom that rises by so much a metre from 40 m to 8 m, with no fault at all."""
    places = ((-50.0, FLAT), (foot, FLAT), (foot + (FLAT - TOP) / rise, TOP), (900.0, TOP))
    bottom = ", ".join(f"{{ north_m = {north}, depth_m = {depth} }}" for north, depth in places)
    orders = hold(20.0)
    text = under_way(260.0, 20.0, orders, bottom=FLAT, rpm=492.0, current=(current, 0.0), learning=learning)
    return text.replace("[environment]\n", f"[environment]\nbottom = [{bottom}]\n", 1)


@pytest.mark.parametrize(("rise", "drops"), [(0.15, False), (0.2, False), (0.3, True)])
def test_over_a_bottom_that_rises_it_climbs_away_or_stops(flown: Flights, rise: float, drops: bool) -> None:
    """Up to a slope as steep as its climb; a steeper one it sees in time to stop, and floats up without its weight."""
    outcome, log = flown(over_a_slope(rise))
    truth = log.truth
    bottom = np.clip(FLAT - rise * (truth["eta.x"] - FOOT), TOP, FLAT)
    assert (bottom - truth["eta.z"]).min() > 0.9, outcome.reason
    assert truth["eta.z"][-1] < 0.6
    told = [event.numbers for _, events in log.events for event in events if event.cause is Cause.ALTITUDE_LIMIT]
    assert told[0][0] < told[0][1] == 2.0  # not the altitude of now
    assert log.columns["applied.drop"].any() == drops


@pytest.mark.parametrize(("rise", "current"), [(0.22, 0.5), (0.15, 1.0)])
def test_in_a_current_from_astern_the_bottom_comes_by_the_ground_and_the_climb_is_made_through_the_water(
    flown: Flights, rise: float, current: float
) -> None:
    """It ran aground: its climb was counted by the speed over the ground, and so was SURFACE's power."""
    foot = 120.0
    outcome, log = flown(over_a_slope(rise, foot, current, learning=True).replace('"time"', '"surfaced"'))
    truth = log.truth
    bottom = np.clip(FLAT - rise * (truth["eta.x"] - foot), TOP, FLAT)
    assert (bottom - truth["eta.z"]).min() > 0.5, outcome.reason
    assert truth["eta.z"][-1] < 0.6


@pytest.mark.parametrize(("bottom", "stick", "limit"), [(60.0, 6.0, 30.0), (24.0, 6.0, 30.0), (30.0, 7.0, 60.0)])
def test_a_dive_by_hand_with_full_power_ends_before_the_limit_and_the_bottom(
    flown: Flights, bottom: float, stick: float, limit: float
) -> None:
    """Only SURFACE ends it, which brings the pitch up by 4 deg/s: 40 m deep, or aground, if it began at the limit."""
    orders = '[[orders]]\nt_s = 0.5\narming = "arm"\n'
    mode = 'mode = "manual"\n'
    for second in range(1, 60):
        sticks = f"delta_s_deg = {stick}\ndelta_r_deg = 0.0\nn_rpm = 1000.0\n"
        orders += f"[[orders]]\nt_s = {second}.0\n{mode if second == 1 else ''}{sticks}"
    limits = f"[autopilot.safety]\ndepth_max_m = {limit}\n"
    outcome, log = flown(under_way(150.0, 4.0, limits, orders, bottom=bottom, rpm=492.0))
    deepest = log.truth["eta.z"].max()
    assert deepest < min(limit + 1.0, bottom - 0.5), outcome.reason
    assert deepest > 15.0
    assert log.truth["eta.z"][-1] < 0.6
