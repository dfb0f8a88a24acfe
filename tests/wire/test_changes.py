"""Changes in the log: each comes back as it was, to the last bit."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from firmware_py.records.fence import Disc, Fence, Place, Polygon
from firmware_py.records.mission import Jump, Loiter, Manoeuvre, ManoeuvreKind, Mission, Surface, Waypoint
from firmware_py.records.order import Change, FenceChange, MissionChange, ParameterChange, RallyChange
from firmware_py.wire.log.cdr_codec import CdrCodec
from firmware_py.wire.log.changes import LoggedChanges, decode, encode

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
PLACES = st.builds(Place, NUMBERS, NUMBERS)
WAYPOINTS = st.builds(Waypoint, NUMBERS, NUMBERS, NUMBERS, NUMBERS, st.booleans())
LOITERS = st.builds(Loiter, *[NUMBERS] * 4, st.booleans(), *[NUMBERS] * 3)
JUMPS = st.builds(Jump, st.integers(0, 2500), st.integers(-1, 10_000))
MANOEUVRES = st.builds(Manoeuvre, st.sampled_from(ManoeuvreKind), st.floats(1.0, 1e4), register=st.integers(1, 127))
ITEMS = WAYPOINTS | LOITERS | JUMPS | st.builds(Surface, st.booleans()) | MANOEUVRES
AREAS = st.builds(Disc, NUMBERS, NUMBERS, NUMBERS) | st.builds(
    Polygon, st.lists(st.tuples(NUMBERS, NUMBERS), min_size=3, max_size=8).map(tuple)
)
LISTS = st.lists(AREAS, max_size=3).map(tuple)
VALUES = st.booleans() | st.integers(-1000, 1000) | NUMBERS | st.text(max_size=8) | st.lists(NUMBERS, max_size=3)
CHANGES = (
    st.builds(ParameterChange, st.dictionaries(st.text(min_size=1), VALUES, max_size=3).map(lambda d: tuple(d.items())))
    | st.builds(MissionChange, st.builds(Mission, st.lists(ITEMS, max_size=6).map(tuple)))
    | st.builds(FenceChange, st.builds(Fence, LISTS, LISTS))
    | st.builds(RallyChange, st.lists(PLACES, max_size=4).map(tuple))
)


def bits(change: Change) -> str:
    return repr(change)  # tells -0.0 from 0.0, True from 1 and 1 from 1.0


@given(st.lists(CHANGES, max_size=4))
def test_every_change_comes_back_from_the_log(changes: list[Any]) -> None:
    codec = CdrCodec.like(LoggedChanges(0, ()))
    logged = LoggedChanges(7, tuple(map(encode, changes)))
    again = codec.decode(codec.encode(logged))
    assert again == logged
    assert [bits(decode(change)) for change in again.changes] == [bits(change) for change in changes]


def test_a_mission_is_numbers_in_the_order_of_its_fields() -> None:
    mission = Mission((Waypoint(1.0, 2.0, 3.0, 4.0, above=True), Jump(0, -1)))
    logged = encode(MissionChange(mission))
    assert (logged.kind.name, logged.text) == ("MISSION", "")
    assert logged.numbers == (0, 1.0, 2.0, 3.0, 4.0, True, 2, 0, -1)


def test_a_fence_is_its_areas_one_after_another() -> None:
    corners = ((0.0, 0.0), (0.0, 9.0), (9.0, math.pi))
    logged = encode(FenceChange(Fence((Polygon(corners),), (Disc(1.0, 2.0, 3.0),))))
    assert logged.numbers == (0, 3, 0.0, 0.0, 0.0, 9.0, 9.0, math.pi, 1, 0, 1.0, 2.0, 3.0)
