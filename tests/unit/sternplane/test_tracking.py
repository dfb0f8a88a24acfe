"""Distances to a path, and angles for people."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sternplane.logs.reading import Piece
from sternplane.logs.tracking import FlownMissions, Planned, distance, missions, path_error, unwrapped_deg, wrapped_deg

from firmware_py.records.fence import NO_FENCE
from firmware_py.records.mission import Mission, Waypoint
from firmware_py.records.order import Change, FenceChange, MissionChange, Mode

EAST = [[0.0, 100.0, 5.0, 1.8]]
NORTH = [[100.0, 0.0, 5.0, 1.8], [200.0, 0.0, 5.0, 1.8]]
PLACE = st.tuples(st.integers(-100, 100), st.integers(-100, 100))


def test_the_distance_to_a_path_with_a_corner() -> None:
    path = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 60.0]])
    places = np.array([[30.0, 4.0], [30.0, -4.0], [-3.0, -4.0], [63.0, -4.0], [57.0, 2.5], [62.0, 30.0], [55.0, 900.0]])
    assert distance(places, path) == pytest.approx([4.0, 4.0, 5.0, 5.0, 2.5, 2.0, 5.0])


@given(st.lists(PLACE, min_size=2, max_size=6), PLACE)
def test_it_is_that_of_the_nearest_of_all_points(path: list[tuple[int, int]], place: tuple[int, int]) -> None:
    way, places = np.array(path, dtype=float), np.array([place], dtype=float)
    share = np.linspace(0.0, 1.0, 400)[:, None]
    points = np.vstack([a + share * (b - a) for a, b in itertools.pairwise(way)])
    nearest = np.hypot(*(points - place).T).min()
    ended = distance(places, np.vstack((way, way[-1])))[0]
    assert ended <= nearest + 1e-9
    assert ended >= nearest - 0.36  # half a step of the longest leg: 283 m / 399 / 2
    beyond = way[-1] + np.arange(3000.0)[:, None] * (way[-1] - way[-2])
    endless = distance(places, way)[0]
    assert endless <= ended
    assert endless <= np.hypot(*(beyond - place).T).min() + 1e-9
    assert endless == pytest.approx(distance(places, np.vstack((way, beyond[-1], beyond[-1])))[0])


def test_an_estimate_that_is_not_there_yet_does_not_hide_the_rest() -> None:
    path = np.array([[math.nan, math.nan], [60.0, 0.0], [60.0, 60.0]])
    assert distance(np.array([[58.0, 30.0]]), path) == pytest.approx([2.0])


@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=50), st.floats(-20.0, 20.0), st.sets(st.integers(0, 49)))
def test_unwrapped_has_no_jumps_and_is_the_same_angle(steps: list[float], begin: float, unknown: set[int]) -> None:
    true = np.degrees(begin + np.cumsum(steps))
    psi = np.angle(np.exp(1j * np.radians(true)))
    psi[[i for i in unknown if i < len(psi)]] = math.nan
    found = unwrapped_deg(psi)
    assert np.array_equal(np.isnan(found), np.isnan(psi))
    known = np.isfinite(psi)
    assert wrapped_deg(np.radians(found) - psi)[known] == pytest.approx(0.0, abs=1e-6)
    if known.all():
        assert np.diff(found) == pytest.approx(np.diff(true), abs=1e-6)
    if known.any():
        assert -45.0 - 1e-9 <= np.median(found[known]) <= 315.0 + 1e-9


@pytest.mark.parametrize(("degrees", "shown"), [(-90.0, 270.0), (-10.0, -10.0), (359.0, -1.0), (180.0, 180.0)])
def test_a_course_is_written_as_a_compass_has_it_except_about_north(degrees: float, shown: float) -> None:
    assert unwrapped_deg(np.radians([degrees] * 3)) == pytest.approx(shown)


def log(modes: list[Mode], changes: dict[int, tuple[Change, ...]]) -> Any:
    """A log of a cycle a second that begins with a mission to the east; its vehicle goes north."""
    n = len(modes)
    columns = {
        "t": np.arange(n) * 1.0,
        "mode.mode": np.array(modes),
        "reference.cross_track": np.zeros(n),
        "reference.waypoint": np.zeros(n, dtype=int),
        "mode.mission_done": np.zeros(n, dtype=bool),
    }
    header = {"mission": {"waypoints": EAST}}
    return SimpleNamespace(columns=columns, header=header, changes=changes, count=n, row=lambda t_ns: t_ns // 10**9)


def flown_last(run: Any) -> Planned:
    """Shown in pieces of three cycles."""
    flown = FlownMissions(run)
    for begin in range(0, run.count, 3):
        flown.add(Piece(begin, {name: column[begin : begin + 3] for name, column in run.columns.items()}, {}))
    return flown.last


def sent(waypoints: list[list[float]]) -> tuple[Change, ...]:
    return FenceChange(NO_FENCE), MissionChange(Mission(tuple(Waypoint(*place) for place in waypoints)))


def test_a_mission_that_a_station_sends_is_the_one_that_was_to_be_flown_from_then_on() -> None:
    run = log([Mode.MISSION] * 10, {4_000_000_000: sent(NORTH)})
    assert [(m.begin, m.end, len(m.waypoints)) for m in missions(run)] == [(0, 4, 1), (4, 10, 2)]
    track = {"eta.x": np.arange(10) * 1.0, "eta.y": np.zeros(10)}
    assert path_error(run, run.columns, track) == pytest.approx([0.0, 1.0, 2.0, 3.0, *[0.0] * 6])


def test_what_was_sent_and_not_flown_is_not_the_mission_that_was_flown_last() -> None:
    assert flown_last(log([Mode.MISSION] * 10, {})).waypoints.tolist() == EAST
    only_before = log([Mode.MISSION] * 4 + [Mode.HOLD] * 6, {5_000_000_000: sent(NORTH)})
    assert flown_last(only_before).waypoints.tolist() == EAST
    both = log([Mode.MISSION] * 4 + [Mode.HOLD] * 2 + [Mode.MISSION] * 4, {5_000_000_000: sent(NORTH)})
    assert flown_last(both).waypoints.tolist() == NORTH
    assert flown_last(log([Mode.HOLD] * 10, {5_000_000_000: sent(NORTH)})).waypoints.tolist() == NORTH
