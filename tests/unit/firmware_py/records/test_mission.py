"""Missions as files and logs say them."""

from __future__ import annotations

import json
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.params import ParamError, load
from firmware_py.records.mission import (
    Jump,
    Loiter,
    Manoeuvre,
    ManoeuvreKind,
    Mission,
    MissionItem,
    Surface,
    Waypoint,
    leads_nowhere,
)
from firmware_py.records.mission_tables import (
    ItemTable,
    WaypointTable,
    mission_from_plain,
    mission_of,
    mission_to_plain,
)

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


PLACES = [*[st.floats(-1e5, 1e5)] * 2, st.floats(0, 6000), st.floats(0, 10)]
OTHERS = st.one_of(
    st.builds(Waypoint, *PLACES, st.just(True)),
    st.builds(Loiter, *PLACES, st.booleans(), st.floats(-1000, 1000), st.floats(0, 1e4), st.floats(0, 1e6)),
    st.builds(Jump, st.integers(0, 9), st.integers(-1, 9)),
    st.builds(Surface, st.booleans()),
)


@given(st.lists(POINTS | MANOEUVRES | OTHERS, max_size=8))
def test_a_mission_survives_a_log(items: list[MissionItem]) -> None:
    mission = Mission(tuple(items))
    assert mission_from_plain(json.loads(json.dumps(mission_to_plain(mission)))) == mission


def test_a_log_from_before_there_were_manoeuvres_can_be_flown_again() -> None:
    mission = mission_from_plain({"waypoints": [[1.0, 2.0, 3.0, 1.5]]})
    assert mission.items == mission.waypoints == (Waypoint(1.0, 2.0, 3.0, 1.5),)


def test_a_manoeuvre_stands_in_a_log_by_how_many_waypoints_come_before_it() -> None:
    prbs, zigzag = Manoeuvre(ManoeuvreKind.PRBS), Manoeuvre(ManoeuvreKind.ZIGZAG)
    table = mission_to_plain(Mission((prbs, Waypoint(1, 2, 3, 4), zigzag, prbs)))
    assert [(m["after"], m["kind"]) for m in table["manoeuvres"]] == [(0, "prbs"), (1, "zigzag"), (1, "prbs")]
    assert table["waypoints"] == [[1, 2, 3, 4]]


def test_every_kind_of_item_can_be_written_in_a_file() -> None:
    text = """
    items = [
        { waypoint = { x_m = 1.0, y_m = 2.0, altitude_m = 8.0, speed_m_s = 0.0 } },
        { loiter = { centre = { x_m = 3.0, y_m = 4.0, depth_m = 5.0, speed_m_s = 1.0 }, radius_m = -40.0, turns = 2 } },
        { jump = { to = 0, times = 3 } },
        { surface = { rally = true } },
    ]
    """
    items = [load(ItemTable, table, "here") for table in tomllib.loads(text)["items"]]
    assert mission_of((), items).items == (
        Waypoint(1.0, 2.0, 8.0, 0.0, above=True),
        Loiter(3.0, 4.0, 5.0, 1.0, False, -40.0, 2.0, 0.0),
        Jump(0, 3),
        Surface(rally=True),
    )
    with pytest.raises(ParamError, match="jump to = 4: there are 4 items"):
        mission_of((), [*items[:3], load(ItemTable, {"jump": {"to": 4, "times": 1}}, "here")])


PLACE = Waypoint(0.0, 0.0, 5.0, 0.0)


@pytest.mark.parametrize(
    ("items", "nowhere"),
    [
        ([Jump(0, 1)], True),
        ([Jump(0, 0)], True),
        ([Jump(1, 2), Jump(0, 2)], True),
        ([Jump(0, -1), PLACE], True),
        ([Jump(1, -1), Jump(0, 2), PLACE], False),
        ([Jump(2, 1), Jump(1, -1), PLACE], False),
        ([Jump(0, 0), PLACE], False),
        ([Surface()], False),
        ([], False),
    ],
)
def test_jumps_that_lead_to_jumps_alone_are_no_mission(items: list, nowhere: bool) -> None:
    assert leads_nowhere(items) is nowhere


def test_a_file_whose_jumps_lead_nowhere_is_refused() -> None:
    jump = load(ItemTable, {"jump": {"to": 0, "times": 1}}, "here")
    with pytest.raises(ParamError, match=r"^items: jumps lead to jumps alone; add an item that is flown"):
        mission_of((), [jump])


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "depth_m is missing; or give altitude_m"),
        ({"depth_m": 1.0, "altitude_m": 1.0}, "there are depth_m and altitude_m"),
    ],
)
def test_a_place_has_a_depth_or_an_altitude(table: dict[str, float], words: str) -> None:
    with pytest.raises(ParamError, match=words):
        load(WaypointTable, {"x_m": 0.0, "y_m": 0.0, "speed_m_s": 0.0, **table}, "here")


def test_items_are_waypoints_and_manoeuvres_in_their_order() -> None:
    point = {"x_m": 1.0, "y_m": 2.0, "depth_m": 3.0, "speed_m_s": 0.0}
    items = [load(ItemTable, table, "here") for table in ({"manoeuvre": {"kind": "doublets"}}, {"waypoint": point})]
    assert mission_of((), items).items == (Manoeuvre(ManoeuvreKind.DOUBLETS), Waypoint(1.0, 2.0, 3.0, 0.0))
    assert mission_of([load(WaypointTable, point, "here")], ()).items == (Waypoint(1.0, 2.0, 3.0, 0.0),)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "here: an item is one of waypoint, manoeuvre, loiter, jump, surface = {...}"),
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
        load(ItemTable, table, "here")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_waypoints_beside_items_have_no_order_and_are_refused() -> None:
    point = WaypointTable(x=0.0, y=0.0, depth=1.0, speed=1.0)
    with pytest.raises(ParamError, match=r"there are \[\[waypoints\]\] and \[\[items\]\]; write all of them as"):
        mission_of([point], [ItemTable(manoeuvre=Manoeuvre(ManoeuvreKind.PRBS))])
