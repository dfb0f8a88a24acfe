"""Learning manoeuvres flown whole, with the sensors as they are, judged by where the vehicle really went."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sternplane.logs.reading import Columns, Log
from sternplane.logs.replay import replay
from sternplane.logs.summary import summarise
from sternplane.sitl.flight import SCENARIOS, Outcome

from firmware_py.app import build
from firmware_py.guidance.manoeuvre import ManoeuvreParams
from firmware_py.records.order import Mode
from tests.shared_flights import LEARNING_OFF, Flights

LIMITS = ManoeuvreParams()
SHIPPED = ("learn-zigzag", "learn-doublets", "learn-prbs")
DEPTH = 20.0
"""Where the shipped scenarios learn here, m: from their 60 m it takes two minutes to the surface."""


def shipped(name: str) -> str:
    """Return the text of a shipped scenario, moved up with its bottom."""
    text = (SCENARIOS / f"{name}.toml").read_text()
    moved = text.replace("\ndepth_m = 60.0", f"\ndepth_m = {DEPTH}").replace(
        "depth_m = 100.0", f"depth_m = {DEPTH + 40.0}"
    )
    assert moved.count(f"depth_m = {DEPTH}") == moved.count(f"depth_m = {DEPTH + 40.0}") == 1
    return moved


def learning(log: Log) -> np.ndarray:
    """The cycles in which a manoeuvre moves the fins."""
    moving: np.ndarray = log.columns["reference.grip"] < 1.0
    return moving


def angles(c: Columns) -> tuple[np.ndarray, np.ndarray]:
    """(stern planes, rudder) as the servos report them."""
    fins = c["frame.fins.value"]
    return fins[:, :2].mean(axis=1), fins[:, 2:].mean(axis=1)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scenario_learns_inside_its_limits_and_surfaces(flown: Flights, name: str) -> None:
    outcome, log = flown(shipped(name))
    kind = name.removeprefix("learn-")
    assert outcome == Outcome(True, "completed")
    events = [text for _, text in log.sentences]
    assert f"{kind} begins: 120 s about {DEPTH:.1f} m" in events
    done = events.index(f"{kind} done: 120 s, and 0.0 s of waiting")
    assert events[done + 1].startswith(f"{kind}: learned all 10, 1 sigma up to ")
    while_learning, truth = learning(log), log.truth
    assert np.count_nonzero(while_learning) == 12_000
    assert np.abs(truth["eta.z"] - DEPTH)[while_learning].max() < LIMITS.depth_band
    assert np.abs(truth["eta.theta"])[while_learning].max() < LIMITS.pitch_max
    assert truth["eta.z"].max() < DEPTH + LIMITS.depth_band
    assert log.columns["mode.mode"][-1] == Mode.DISARMED


@pytest.mark.parametrize("name", SHIPPED)
def test_the_fins_move_both_ways_and_the_vehicle_with_them(flown: Flights, name: str) -> None:
    _, log = flown(shipped(name))
    while_learning = learning(log)
    planes, rudder = (angle[while_learning] for angle in angles(log.columns))
    for angle in (planes, rudder):
        assert angle.max() > math.radians(12.0)
        assert angle.min() < math.radians(-12.0)
    assert abs(np.corrcoef(planes, rudder)[0, 1]) < 0.25  # what one does is not what the other does
    assert np.std(log.truth["nu.q"][while_learning]) > math.radians(0.5)
    assert np.std(log.truth["nu.r"][while_learning]) > math.radians(0.5)


def test_unless_laws_and_navigation_use_it_learning_only_looks_on(flown: Flights) -> None:
    off = "[autopilot.control.adoption]\nenabled = false\n[autopilot.estimation.velocity]\nfilter_std_m_s = 0.0\n"
    scenario = written('[[items]]\nmanoeuvre = { kind = "prbs" }', duration=12.0) + off
    learned, without = (flown(text)[1].columns for text in (scenario, scenario + LEARNING_OFF))
    assert learned["state.learned.excited"].any()
    for name in (name for name in without if not name.startswith("state.learned.")):
        np.testing.assert_array_equal(learned[name], without[name], err_msg=name)


def test_a_run_of_nothing_but_a_manoeuvre_has_no_path_to_be_off(flown: Flights) -> None:
    summary = summarise(flown(shipped("learn-prbs"))[1])
    assert summary["path_error_rms_m"] is None
    assert summary["waypoints_total"] == 0


SCENARIO = """
description = "A manoeuvre of its own."
duration_s = {duration}
completes = "time"
[environment]
bottom_depth_m = {bottom}
[start]
depth_m = 60.0
u_m_s = 1.8
n_rpm = 492.0
[autopilot.safety]
depth_max_m = 80.0
[[orders]]
t_s = 0.5
arming = "arm"
mode = "mission"
{orders}
{items}
"""


def written(items: str, duration: float = 80.0, bottom: float = 100.0, orders: str = "") -> str:
    return SCENARIO.format(duration=duration, bottom=bottom, items=items, orders=orders)


def test_what_would_leave_the_limits_waits_and_goes_on(flown: Flights) -> None:
    wild = '[[items]]\nmanoeuvre = { kind = "prbs", delta_s_deg = 23, delta_r_deg = 23, clock_s = 6.0 }'
    outcome, log = flown(written(wild) + LEARNING_OFF)
    assert outcome.completed
    events = [text.split(":")[0] for _, text in log.sentences[1:]]
    assert events[0] == "prbs begins"
    assert events[1:3] == ["prbs waits", "prbs goes on"]
    assert np.abs(log.truth["eta.z"] - 60.0).max() < LIMITS.depth_band
    assert np.abs(log.truth["eta.theta"]).max() < LIMITS.pitch_max
    c = log.columns
    waiting = (c["mode.mode"] == Mode.MISSION) & ~learning(log)
    assert np.count_nonzero(waiting) > 100
    assert np.count_nonzero(learning(log)) > 2500
    assert not c["reference.delta_s"][waiting].any()


def test_over_a_bottom_that_is_near_it_gives_up_and_the_mission_goes_on(flown: Flights) -> None:
    items = (
        '[[items]]\nmanoeuvre = { kind = "prbs" }\n'
        "[[items]]\nwaypoint = { x_m = 200.0, y_m = 0.0, depth_m = 58.0, speed_m_s = 1.8 }"
    )
    over = "[autopilot.guidance.learning]\npatience_s = 10.0\n"
    outcome, log = flown(written(over + items, duration=40.0, bottom=65.5))
    assert outcome.completed
    assert not learning(log).any()
    assert [text.split(":")[0] for _, text in log.sentences[1:] if " law: " not in text] == [
        *("prbs begins", "prbs waits", "prbs given up after 0.0 s", "prbs")
    ]
    assert log.columns["reference.cross_track"][-1] == pytest.approx(0.0, abs=1.0)


def test_an_order_to_surface_takes_the_fins_from_the_manoeuvre_at_once(flown: Flights) -> None:
    orders = '[[orders]]\nt_s = 20.0\nmode = "surface"'
    _, log = flown(written('[[items]]\nmanoeuvre = { kind = "prbs" }', duration=40.0, orders=orders) + LEARNING_OFF)
    t, while_learning = log.columns["t"], learning(log)
    assert while_learning[(t >= 0.5) & (t < 20.0)].all()
    assert not while_learning[t >= 20.0].any()
    assert log.truth["eta.z"][-1] < 57.0


def test_the_path_error_leaves_the_manoeuvre_out(flown: Flights) -> None:
    items = (
        "[[items]]\nwaypoint = { x_m = 40.0, y_m = 0.0, depth_m = 60.0, speed_m_s = 1.8 }\n"
        '[[items]]\nmanoeuvre = { kind = "zigzag", delta_s_deg = 0, duration_s = 25.0, heading_deg = 40 }\n'
        "[[items]]\nwaypoint = { x_m = 150.0, y_m = 0.0, depth_m = 60.0, speed_m_s = 1.8 }"
    )
    outcome, log = flown(written(items, duration=70.0) + LEARNING_OFF)
    assert outcome.completed
    off = np.abs(log.truth["eta.y"])[learning(log)].max()
    summary = summarise(log)
    assert off > 3.0
    assert summary["path_error_max_m"] < 0.6 * off


TAUGHT_TWICE = (
    '[[items]]\nmanoeuvre = { kind = "doublets", delta_r_deg = 0, duration_s = 40.0 }\n'
    '[[items]]\nmanoeuvre = { kind = "prbs", duration_s = 40.0 }'
)


def test_a_rudder_at_rest_is_named_in_log_and_report_until_it_has_moved(flown: Flights) -> None:
    _, log = flown(written(TAUGHT_TWICE, duration=81.0))
    first, second = (text for _, text in log.sentences if ": learned " in text)
    assert first.startswith("doublets: learned 4 of 10, 4 valid, ")
    lost = first.partition("; not identifiable: ")[2]  # eddies move a little of it: by themselves or in combinations
    assert all(name in lost for name in ("N_r", "N_dr", "N_v", "Y_dr", "(never excited)", "Y_r", "Y_v")), lost
    assert second.startswith("prbs: learned ")
    assert "identifiable" not in second
    assert [text for _, text in summarise(log)["learned"]["taught"]] == [first, second]


def test_a_replay_gives_manoeuvres_and_what_they_taught_again(flown: Flights) -> None:
    result = replay(flown(written(TAUGHT_TWICE, duration=81.0))[1], build)
    assert result.equal, str(result)


def test_an_order_to_surface_ends_it_with_what_it_taught_so_far(flown: Flights) -> None:
    orders = '[[orders]]\nt_s = 4.0\nmode = "surface"'
    _, log = flown(written('[[items]]\nmanoeuvre = { kind = "prbs" }', duration=6.0, orders=orders))
    said = [(round(t, 2), text) for t, text in log.sentences if ": learned " in text]
    assert [t for t, _ in said] == [4.0]
    assert said[0][1].startswith("prbs: learned 0 of 10, 0 valid; not identifiable: M_q, ")  # the water is found first
