"""Stations send missions, fences and rally points over MAVLink, and the vehicle flies them against the plant."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink
from sternplane.logs.reading import Log
from sternplane.logs.replay import replay
from sternplane.logs.summary import summarise

from firmware_py.app import build
from firmware_py.mavlink.base.identity import Identity
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import MissionChange, Mode, RallyChange
from firmware_py.tick import Tick
from tests.flights.station import Station, command, flown_by
from tests.straight_run import hold, under_way

MISSION, FENCE, RALLY = range(3)
START, LOCAL, TERRAIN = mavlink.MAV_CMD_MISSION_START, 1, mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT
WAYPOINT, TURNS, RETURN, JUMP = 16, 18, 20, 177
OUTSIDE = mavlink.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION
INSIDE, RALLY_POINT = mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, mavlink.MAV_CMD_NAV_RALLY_POINT


def at(command: int, x: float, y: float, z: float = 0.0, *params: float, kind: int = MISSION, frame: int = LOCAL):
    filled = (*params, *(0.0,) * (4 - len(params)))
    place = round(x * 1e4), round(y * 1e4)
    return mavlink.MAVLink_mission_item_int_message(1, 1, 0, frame, command, 0, 1, *filled, *place, z, kind)


class Planner(Station):
    """Sends each plan at its time, item by item as it is asked for, and commands at theirs."""

    def __init__(self, script: dict[float, object]) -> None:
        super().__init__(script, Identity.GENERIC)
        self.items: list = []
        self.next: list = []
        self.acks: list[tuple[int, int]] = []
        self.reached: list[int] = []
        self.broken: set[int] = set()
        self.targets: list[tuple[Mode, int, float, float, float, float]] = []
        """Mode, item, place; and of the target distance, m, and bearing, deg, as a station shows them."""

    def says(self, tick: Tick) -> list:
        said = super().says(tick)
        if said and isinstance(said[0], list):
            (self.items,) = said
            for i, each in enumerate(self.items):
                each.seq = i
            said = [mavlink.MAVLink_mission_count_message(1, 1, len(self.items), self.items[0].mission_type)]
        said, self.next = [*self.next, *said], []
        return said

    def hears(self, cycle: Cycle, message) -> None:
        kind = message.get_type()
        if kind == "MISSION_REQUEST_INT":
            self.next.append(self.items[message.seq])
        elif kind == "MISSION_ACK":
            self.acks.append((message.mission_type, message.type))
        elif kind == "MISSION_ITEM_REACHED":
            self.reached.append(message.seq)
        elif kind == "FENCE_STATUS":
            self.broken.add(message.breach_status)
        elif kind == "NAV_CONTROLLER_OUTPUT":
            here = *cycle.state.eta[:2], message.wp_dist, message.target_bearing
            self.targets.append((cycle.mode.mode, cycle.reference.item, *here))

    def seen(self, mode: Mode, item: int, x: float, y: float) -> bool:
        """Whether the target was there throughout, m, and often enough to tell."""
        found = [said[2:] for said in self.targets if said[0] is mode and (mode is not Mode.MISSION or said[1] == item)]
        for here_x, here_y, distance, bearing in found:
            north, east = x - here_x, y - here_y
            off = math.radians(bearing) - math.atan2(east, north)
            far = math.hypot(north, east)
            if abs(distance - far) > 0.6 or (far > 3.0 and abs(math.remainder(off, math.tau)) > math.radians(0.6)):
                return False
        return len(found) > 10


def flown(folder: Path, planner: Planner, duration: float, completes: str, more: str = "") -> Log:
    """Hold a course until a station has something else to do."""
    course = under_way(duration, 6.0, hold(6.0), completes=completes, bottom=25.0, rpm=492.0)
    return flown_by(planner, course + more, folder)


@pytest.fixture(scope="module")
def mission(tmp_path_factory) -> tuple[Planner, Log]:
    low = at(WAYPOINT, 0, 0, 12.0, frame=TERRAIN)
    low.x, low.y = round((36.8 + 120.0 / 111_000) * 1e7), round(-121.8 * 1e7)
    items = [
        at(WAYPOINT, 50, 0, 6.0),
        low,
        at(WAYPOINT, 150, 40, 10.0),
        at(JUMP, 0, 0, 0.0, 5, 1, frame=mavlink.MAV_FRAME_MISSION),
        at(WAYPOINT, 5000, 5000, 6.0),
        at(TURNS, 150, 90, 8.0, 1.0, 0, -25),
        at(RETURN, 0, 0),
    ]
    planner = Planner({1.0: items, 2.0: [at(RALLY_POINT, 100, 90, kind=RALLY)], 3.0: command(START, 0, 0)})
    return planner, flown(tmp_path_factory.mktemp("mission"), planner, 330.0, "surfaced")


def test_a_mission_that_came_over_mavlink_is_flown_item_by_item_to_a_rally_point(mission) -> None:
    planner, log = mission
    assert planner.acks == [(MISSION, 0), (RALLY, 0)]
    assert planner.results == [(START, 0)]
    assert log.end["completed"], log.end
    assert planner.reached == [0, 1, 2, 5, 6]
    item, mode = log.columns["reference.item"], log.columns["mode.mode"]
    flown = item[mode == Mode.MISSION]
    assert [*flown[np.flatnonzero(np.diff(flown, prepend=-1))]] == [0, 1, 2, 5, 6, 7]
    surfacing = np.flatnonzero(mode == Mode.SURFACE)[0]
    x, y = (log.columns[f"state.eta.{axis}"] for axis in "xy")
    assert math.hypot(x[surfacing] - 100.0, y[surfacing] - 90.0) < 6.0
    summary = summarise(log)  # of this mission, which the log does not begin with
    assert (summary["waypoints_passed"], summary["waypoints_total"]) == (4, 4)
    assert summary["path_error_rms_m"] is not None


def test_a_leg_above_the_bottom_and_a_circle_are_where_they_should_be(mission) -> None:
    _, log = mission
    c = log.columns
    flying, item = c["mode.mode"] == Mode.MISSION, c["reference.item"]
    low = np.flatnonzero(flying & (item == 1))
    assert c["state.altitude"][low[-1]] == pytest.approx(12.0, abs=1.0)
    around = np.flatnonzero(flying & (item == 5))
    x, y = c["state.eta.x"][around] - 150.0, c["state.eta.y"][around] - 90.0
    bearing = np.unwrap(np.arctan2(y, x))
    assert bearing[-1] - bearing.max() < -1.9 * math.pi  # once around, to port
    quarter = np.flatnonzero(bearing < bearing[-1] + 0.5 * math.pi)
    assert np.abs(np.hypot(x, y)[quarter] - 32.2).max() < 2.0  # at 1.8 m/s no tighter circle can be flown
    assert abs(c["state.eta.z"][around[-1]] - 8.0) < 0.5


def test_stations_are_shown_how_far_the_current_item_is(mission) -> None:
    planner, _ = mission
    for item, x, y in ((0, 50, 0), (1, 120, 0), (2, 150, 40), (5, 150, 90), (6, 100, 90)):
        assert planner.seen(Mode.MISSION, item, x, y), item
    assert planner.seen(Mode.SURFACE, -1, 100, 90)
    assert {said[4] for said in planner.targets if said[0] is Mode.HOLD} == {0}


def test_what_stations_sent_is_in_the_log_and_is_replayed_to_the_byte(mission) -> None:
    _, log = mission
    kinds = [type(change) for changes in log.changes.values() for change in changes]
    assert kinds == [MissionChange, RallyChange]
    assert replay(log, build).equal


def test_return_to_launch_is_to_the_nearest_rally_point_that_no_exclusion_is_before_and_then_up(tmp_path: Path) -> None:
    rally = [at(RALLY_POINT, x, y, kind=RALLY) for x, y in ((400, 0), (20, 80), (30, -60))]
    planner = Planner({0.75: [at(OUTSIDE, 15, -30, 0, 8, kind=FENCE)], 1.0: rally, 2.0: command(RETURN)})
    log = flown(tmp_path, planner, 150.0, "surfaced")
    assert log.end["completed"], log.end
    assert planner.results == [(RETURN, 0)]
    assert planner.seen(Mode.RETURN, -1, 20, 80)
    modes = [text for _, text in log.sentences if " -> " in text]
    assert modes[1:3] == ["HOLD -> RETURN: ordered by station 255/190", "RETURN -> SURFACE: return done"]
    c = log.columns
    k = np.flatnonzero(c["mode.mode"] == Mode.SURFACE)[0]
    assert math.hypot(c["state.eta.x"][k] - 20.0, c["state.eta.y"][k] - 80.0) < 6.0
    assert c["state.eta.z"][k] == pytest.approx(6.0, abs=0.5)
    assert c["state.eta.z"][-1] < 1.0
    assert not c["mode.mission_done"].any()
    assert replay(log, build).equal


def test_return_to_launch_without_a_rally_point_is_home_and_then_up(tmp_path: Path) -> None:
    planner = Planner({30.0: command(RETURN)})
    log = flown(tmp_path, planner, 150.0, "surfaced", "[autopilot.estimation.position]\nstd_start_m = 5.0\n")
    assert log.end["completed"], log.end
    assert planner.results == [(RETURN, 0)]
    assert planner.seen(Mode.RETURN, -1, 0, 0)
    assert [text for _, text in log.sentences if "home" in text] == ["home reached"]
    x, y, z = (log.truth[f"eta.{axis}"] for axis in "xyz")
    up = log.columns["t"][log.columns["mode.mode"] == Mode.SURFACE][0]
    k = np.searchsorted(log.truth["t"], up)
    assert math.hypot(x[k], y[k]) < 8.0
    assert z[k] == pytest.approx(6.0, abs=0.5)
    assert z[-1] < 1.0


def test_a_return_to_launch_that_replaces_the_mission_in_flight_is_flown_from_there(tmp_path: Path) -> None:
    script = {1.0: [at(WAYPOINT, 900, 0, 6.0)], 2.0: command(START, 0, 0), 20.0: [at(RETURN, 0, 0)]}
    log = flown(tmp_path, Planner(script), 150.0, "surfaced", "[autopilot.estimation.position]\nstd_start_m = 5.0\n")
    assert log.end["completed"], log.end
    modes = [text for _, text in log.sentences if " -> " in text]
    assert modes[-2:] == ["MISSION -> SURFACE: mission done", "SURFACE -> DISARMED: surfaced"]
    c = log.columns
    k = np.flatnonzero(c["mode.mode"] == Mode.SURFACE)[0]
    assert math.hypot(c["state.eta.x"][k], c["state.eta.y"][k]) < 8.0


def test_beyond_the_fence_it_surfaces_says_why_and_turns_to_the_rally_point(tmp_path: Path) -> None:
    fence = [at(INSIDE, 0, 0, 0, 60, kind=FENCE), at(OUTSIDE, -50, 0, 0, 10, kind=FENCE)]
    planner = Planner({1.0: fence, 2.0: [at(RALLY_POINT, -10, 10, kind=RALLY)], 3.0: [at(WAYPOINT, 70, 0, 5)]})
    log = flown(tmp_path, planner, 60.0, "time")
    assert planner.acks == [(FENCE, 0), (RALLY, 0), (MISSION, mavlink.MAV_MISSION_INVALID_PARAM5_X)]
    assert planner.broken == {0, 1}
    (text,) = [text for _, text in log.sentences if "fence" in text]
    assert text == "HOLD -> SURFACE: outside the fence"
    c = log.columns
    k = np.flatnonzero(c["mode.mode"] == Mode.SURFACE)[0]
    assert math.hypot(c["state.eta.x"][k], c["state.eta.y"][k]) == pytest.approx(61.8, abs=0.5)  # a second beyond it
    assert math.degrees(abs(c["reference.psi_d"][-1] - c["reference.psi_d"][k])) > 75.0
    assert c["state.eta.z"][-1] < 1.0
