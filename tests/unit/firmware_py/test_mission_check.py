"""The missions of files pass the checks of uploaded ones."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from firmware_py import config_files
from firmware_py.mission_check import refuse_mission, refuse_near_bottom
from firmware_py.params import ParamError
from firmware_py.records.fence import NO_FENCE, Disc, Fence
from firmware_py.records.manoeuvrability import RESERVE, UNLIMITED
from firmware_py.records.mission import Jump, Loiter, Manoeuvre, ManoeuvreKind, Mission, MissionItem, Surface, Waypoint

SHIPPED = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
PARAMS = config_files.autopilot_params(config_files.read_configuration(SHIPPED))
GOOD = (Waypoint(100.0, 0.0, 5.0, 1.8), Waypoint(200.0, 0.0, 29.0, 0.0), Waypoint(300.0, 0.0, 3.0, 1.0, True))
WALL = Fence(without=(Disc(150.0, 0.0, 10.0),))


def said(*items: MissionItem, fence: Fence = NO_FENCE) -> str:
    try:
        refuse_mission(Mission(items), PARAMS, fence, "here.toml", "items")
    except ParamError as error:
        return str(error)
    return ""


def test_a_mission_within_the_limits_is_taken() -> None:
    assert said(*GOOD) == ""
    assert said(*GOOD, Jump(0, 2), Manoeuvre(ManoeuvreKind.PRBS), Surface()) == ""


@pytest.mark.parametrize(
    ("item", "words"),
    [
        (GOOD[0]._replace(z=30.1), "here.toml: items[3]: depth 30.1 m is over safety.depth_max_m = 30"),
        (GOOD[2]._replace(z=1.9), "here.toml: items[3]: 1.9 m above the bottom, minimum 2 m"),
        (GOOD[0]._replace(u=2.6), "here.toml: items[3]: speed_m_s = 2.6 is over guidance.speed_max_m_s = 2.5"),
        (
            Loiter(0.0, 0.0, 31.0, 1.0, False, 0.0, 1.0, 0.0),
            "here.toml: items[3]: depth 31.0 m is over safety.depth_max_m = 30",
        ),
        (
            replace(Manoeuvre(ManoeuvreKind.PRBS), speed=3.0),
            "here.toml: items[3]: speed_m_s = 3 is over guidance.speed_max_m_s = 2.5",
        ),
    ],
)
def test_an_item_beyond_a_limit_is_named_with_file_and_limit(item: MissionItem, words: str) -> None:
    assert said(*GOOD, item) == words


def test_a_mission_is_held_to_what_the_vehicle_can_do() -> None:
    able = UNLIMITED._replace(turn=1.0 / (RESERVE * 80.0), speed=0.5)
    near = Fence(within=(Disc(0.0, 0.0, 60.0),))
    circle = Loiter(0.0, 0.0, 10.0, 1.0, False, 0.0, 1.0, 0.0)
    refuse_mission(Mission((circle,)), PARAMS, near, "here.toml", "items")
    with pytest.raises(ParamError, match="outside the fence"):
        refuse_mission(Mission((circle,)), PARAMS, near, "here.toml", "items", able)
    with pytest.raises(ParamError, match=r"speed_m_s = 0.4 is under 0.50 m/s, below which planes do not hold the trim"):
        refuse_mission(Mission((GOOD[0]._replace(u=0.4),)), PARAMS, NO_FENCE, "here.toml", "items", able)


def test_a_leg_through_the_fence_is_named_by_the_item_that_it_leads_to() -> None:
    assert said(*GOOD, fence=WALL) == "here.toml: items[1]: the leg to it is within exclusion 1 of the fence"
    assert said(GOOD[1], GOOD[2], GOOD[0], fence=WALL).startswith("here.toml: items[2]: the leg to it is within")
    around = (GOOD[0], Waypoint(100.0, 50.0, 5.0, 0.0), Waypoint(200.0, 50.0, 5.0, 0.0), GOOD[1])
    assert said(*around, fence=WALL) == ""
    assert said(*around, Jump(0, 1), fence=WALL).startswith("here.toml: items[4]: the leg back is within exclusion 1")


def test_a_depth_nearer_to_the_bottom_than_the_limit_is_named_with_the_bottom_there() -> None:
    mission = Mission((*GOOD, Surface()))
    refuse_near_bottom(mission, (40.0, 31.0, 2.5, math.nan), 2.0, "here.toml", "waypoints")
    with pytest.raises(ParamError) as caught:
        refuse_near_bottom(mission, (40.0, 30.9, 40.0, math.nan), 2.0, "here.toml", "waypoints")
    assert str(caught.value) == (
        "here.toml: waypoints[1]: depth 29 m, and the bottom is 30.9 m deep there: nearer than "
        "safety.altitude_min_m = 2"
    )
