"""Missions as files and logs say them."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.params import ParamError, dump, load
from firmware_py.records.mission import Item, Point, from_plain, mission_of, plain
from firmware_py.records.order import Kind, Manoeuvre, Mission, Waypoint

POINTS = st.builds(Waypoint, *[st.floats(-1e5, 1e5)] * 2, st.floats(0, 6000), st.floats(0, 10))
ANGLES = st.floats(0.01, 90)
TABLES = st.fixed_dictionaries(
    {
        "kind": st.sampled_from(["zigzag", "doublets", "prbs"]),
        "duration_s": st.floats(1, 1e4),
        "delta_s_deg": ANGLES,
        "delta_r_deg": ANGLES,
        "clock_s": st.floats(0.1, 100),
        "register": st.integers(1, 127),
    }
)
MANOEUVRES = TABLES.map(lambda table: load(Manoeuvre, table, "here"))


@given(st.lists(POINTS | MANOEUVRES, max_size=8))
def test_a_mission_survives_a_log(items: list[Waypoint | Manoeuvre]) -> None:
    mission = Mission(tuple(items))
    assert from_plain(json.loads(json.dumps(plain(mission)))) == mission


def test_a_log_from_before_there_were_manoeuvres_can_be_flown_again() -> None:
    mission = from_plain({"waypoints": [[1.0, 2.0, 3.0, 1.5]]})
    assert mission.items == mission.waypoints == (Waypoint(1.0, 2.0, 3.0, 1.5),)


def test_a_manoeuvre_stands_in_a_log_by_how_many_waypoints_come_before_it() -> None:
    prbs, zigzag = Manoeuvre(Kind.PRBS), Manoeuvre(Kind.ZIGZAG)
    table = plain(Mission((prbs, Waypoint(1, 2, 3, 4), zigzag, prbs)))
    assert [(m["after"], m["kind"]) for m in table["manoeuvres"]] == [(0, "prbs"), (1, "zigzag"), (1, "prbs")]
    assert table["waypoints"] == [[1, 2, 3, 4]]


def test_items_are_waypoints_and_manoeuvres_in_their_order() -> None:
    point = {"x_m": 1.0, "y_m": 2.0, "depth_m": 3.0, "speed_m_s": 0.0}
    items = [load(Item, table, "here") for table in ({"manoeuvre": {"kind": "doublets"}}, {"waypoint": point})]
    assert mission_of((), items).items == (Manoeuvre(Kind.DOUBLETS), Waypoint(1.0, 2.0, 3.0, 0.0))
    assert mission_of([load(Point, point, "here")], ()).items == (Waypoint(1.0, 2.0, 3.0, 0.0),)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "here: an item is either a waypoint = {...} or a manoeuvre = {...}"),
        ({"manoeuvre": {}}, 'here: manoeuvre: kind is missing (one of "zigzag", "doublets", "prbs")'),
        ({"manoeuvre": {"kind": "loop"}}, "here: manoeuvre: kind = 'loop': must be one of"),
        ({"manoeuvre": {"kind": "prbs", "register": 0}}, "register = 0: out of bounds"),
        ({"manoeuvre": {"kind": "prbs", "clock": 2}}, "clock has the wrong unit; write clock_s"),
        ({"manoeuvre": {"kind": "prbs", "delta_s_deg": 0, "delta_r_deg": 0}}, "are both 0: nothing would move"),
        ({"manoeuver": {"kind": "prbs"}}, "here: manoeuver is unknown; did you mean manoeuvre?"),
    ],
)
def test_what_is_wrong_with_an_item_is_said_in_a_line(table: dict[str, object], words: str) -> None:
    with pytest.raises(ParamError) as caught:
        load(Item, table, "here")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_waypoints_beside_items_have_no_order_and_are_refused() -> None:
    point = load(Point, dict(zip(dump(Point(0, 0, 1, 1)), (0.0, 0.0, 1.0, 1.0), strict=True)), "here")
    with pytest.raises(ParamError, match=r"there are \[\[waypoints\]\] and \[\[items\]\]; write all of them as"):
        mission_of([point], [Item(manoeuvre=Manoeuvre(Kind.PRBS))])
