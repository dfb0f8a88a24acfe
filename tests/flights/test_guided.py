"""A station guides the vehicle over MAVLink, against the plant: to a place and around it, on a heading, around here."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink
from sternplane.logs.reading import Log

from firmware_py.mavlink.base.identity import Identity
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Asker, Mode
from tests.flights.station import Station, command, flown_by
from tests.straight_run import hold, under_way

SCENARIO = under_way(255.0, 8.0, hold(8.0), rpm=492.0, current=(0.05, 0.087))
"""Holds a course until a station says otherwise."""
X, Y = 60.0, 40.0
REPOSITION, YAW, LOITER, SPEED, ALTITUDE = 192, 115, 17, 178, 186


class Operator(Station):
    """Remembers how far the target was, m, in which tick, as a station shows it."""

    def __init__(self, script: dict[float, object]) -> None:
        super().__init__(script, Identity.ARDUSUB)
        self.distances: dict[int, float] = {}

    def hears(self, cycle: Cycle, message) -> None:
        if message.get_type() == "NAV_CONTROLLER_OUTPUT":
            self.distances[cycle.tick.k] = message.wp_dist


@pytest.fixture(scope="module")
def flown(tmp_path_factory) -> tuple[Operator, Log]:
    to_place = mavlink.MAVLink_command_int_message(
        1, 1, mavlink.MAV_FRAME_LOCAL_NED, REPOSITION, 0, 0, -1, 1, 0, math.nan, int(X * 1e4), int(Y * 1e4), 12.0
    )
    operator = Operator(
        {
            5.0: to_place,
            110.0: command(YAW, 200.0),
            112.0: command(ALTITUDE, -6.0, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT),
            155.0: command(LOITER),
            220.0: command(SPEED, 1, 1.2, -1),
        }
    )
    return operator, flown_by(operator, SCENARIO, tmp_path_factory.mktemp("guided"))


def during(log: Log, begin: float, end: float) -> np.ndarray:
    return (log.columns["t"] >= begin) & (log.columns["t"] < end)


def test_every_command_was_accepted_and_stands_in_the_log_with_who_gave_it(flown) -> None:
    operator, log = flown
    assert operator.results == [(number, 0) for number in (REPOSITION, YAW, ALTITUDE, LOITER, SPEED)]
    askers = [cycle.order.asker for cycle in log.cycles if cycle.order.asker.link >= 0]
    assert askers == [Asker(0, 255, 190, number) for number, _ in operator.results]
    modes = [Mode(mode) for mode in dict.fromkeys(log.columns["mode.mode"])]
    assert modes == [Mode.DISARMED, Mode.HOLD, Mode.GUIDED, Mode.LOITER]
    changed = [text for _, text in log.sentences if " -> " in text]
    assert changed == [
        "DISARMED -> HOLD: ordered",
        "HOLD -> GUIDED: ordered by station 255/190",
        "GUIDED -> LOITER: ordered by station 255/190",
    ]


def test_stations_are_shown_how_far_the_place_is_and_on_a_circle_of_no_place_how_far_off_it(flown) -> None:
    operator, log = flown
    c, radius = log.columns, 1.25 * 1.8 / math.radians(4.0)
    t, k = c["t"][[*operator.distances]], [*operator.distances]
    shown, away = np.array([*operator.distances.values()]), np.hypot(c["state.eta.x"] - X, c["state.eta.y"] - Y)[k]
    there = (t >= 5.0) & (t < 110.0)
    assert there.sum() > 200
    assert shown[there] == pytest.approx(away[there], abs=0.6)
    assert not shown[(t >= 110.0) & (t < 155.0)].any()  # on a heading
    assert shown[(t >= 190.0) & (t < 220.0)].max() < 0.2 * radius


def test_it_goes_to_the_place_at_the_depth_and_circles_it_in_a_current(flown) -> None:
    _, log = flown
    there = during(log, 65.0, 110.0)
    c = log.columns
    distance = np.hypot(c["state.eta.x"][there] - X, c["state.eta.y"][there] - Y)
    radius = 1.25 * 1.8 / math.radians(4.0)
    assert np.abs(distance - radius).max() < 1.5
    assert np.hypot(log.truth["eta.x"][there] - X, log.truth["eta.y"][there] - Y).max() < radius + 4.0  # dead reckoned
    assert log.truth["eta.z"][there] == pytest.approx(12.0, abs=0.1)
    turned = np.unwrap(log.truth["eta.psi"])[there]
    assert turned[-1] - turned[0] > math.tau * 0.3  # to starboard


def test_it_leaves_on_the_heading_and_comes_up_to_the_depth_that_are_asked_for(flown) -> None:
    _, log = flown
    late = during(log, 130.0, 155.0)
    assert np.degrees(log.truth["eta.psi"][late]) % 360.0 == pytest.approx(200.0, abs=1.5)
    assert log.truth["eta.z"][during(log, 147.0, 155.0)] == pytest.approx(6.0, abs=0.15)


def test_holding_the_position_is_a_circle_that_begins_where_it_was(flown) -> None:
    _, log = flown
    x, y = log.columns["state.eta.x"], log.columns["state.eta.y"]
    (k,) = np.flatnonzero(np.diff(log.columns["mode.mode"] == Mode.LOITER))
    after = during(log, 155.0, 255.0)
    radius = 1.25 * 1.8 / math.radians(4.0)
    assert np.hypot(x[after] - x[k], y[after] - y[k]).max() < 2.0 * radius + 6.0
    centre = x[k] - radius * math.sin(math.radians(200.0)), y[k] + radius * math.cos(math.radians(200.0))
    steady = during(log, 190.0, 220.0)
    assert np.abs(np.hypot(x[steady] - centre[0], y[steady] - centre[1]) - radius).max() < 3.0
    assert log.columns["state.nu.u"][during(log, 250.0, 255.0)] == pytest.approx(1.2, abs=0.1)
