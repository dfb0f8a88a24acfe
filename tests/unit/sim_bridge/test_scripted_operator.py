"""The scripted operator: gives each order once and in time, holds the sticks, steers the zigzag, sees the end."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import pytest

from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.health import WeightState
from firmware_py.records.order import KEEP_SETPOINT, NO_ORDER, Arming, Mode, Setpoint
from firmware_py.tick import Tick
from sim_bridge.scenarios import parse
from sim_bridge.scripted_operator import ScriptedOperator

DT_NS = 10_000_000
DEG = math.pi / 180


def operator(**table):
    return ScriptedOperator(
        parse({"description": "x.", "duration_s": 100.0, "completes": "time"} | table, "here"),
    )


def cycle(
    psi=0.0,
    mode=Mode.MANUAL,
    z=0.2,
    fix=False,
    failsafe=False,
    drop=False,
    events=(),
    t=0.0,
    weight=WeightState.UNREPORTED,
):
    return SimpleNamespace(
        tick=SimpleNamespace(t=t),
        state=SimpleNamespace(eta=SimpleNamespace(psi=psi, z=z)),
        heard=SimpleNamespace(fix=SimpleNamespace(ok=fix)),
        mode=SimpleNamespace(mode=mode, failsafe=failsafe, drop=drop),
        actuators=SimpleNamespace(drop_weight=weight),
        events=events,
    )


def changed(after, cause, *numbers):
    before = Mode.MISSION if after is Mode.SURFACE else Mode.SURFACE
    return Event(EventKind.MODE_CHANGED, Severity.WARNING, before=before, after=after, cause=cause, numbers=numbers)


def orders(ground, ticks):
    return [ground.read(Tick(k, DT_NS)) for k in range(ticks)]


def test_each_order_is_given_once_at_the_first_tick_that_is_not_before_it():
    ground = operator(
        orders=[
            {"t_s": 0.0, "arming": "arm"},
            {"t_s": 0.055, "mode": "hold", "depth_m": 5.0, "heading_deg": 90.0, "speed_m_s": 1.5},
            {"t_s": 0.1, "depth_m": 6.0},
        ]
    )
    said = orders(ground, 20)
    spoken = {k: order for k, order in enumerate(said) if order is not NO_ORDER}
    assert sorted(spoken) == [0, 6, 10]
    assert spoken[0].arming is Arming.ARM
    assert spoken[0].mode is None
    assert spoken[6].mode is Mode.HOLD
    assert spoken[6].setpoint == Setpoint(5.0, math.pi / 2, 1.5)
    assert spoken[10].setpoint.z_d == 6.0
    assert math.isnan(spoken[10].setpoint.psi_d)
    assert spoken[10].mode is None


def test_orders_of_one_time_are_given_in_the_ticks_after_it_and_none_is_lost():
    said = orders(operator(orders=[{"t_s": 0.0, "arming": "arm"}, {"t_s": 0.0, "mode": "manual"}]), 3)
    assert [o.arming for o in said] == [Arming.ARM, Arming.KEEP, Arming.KEEP]
    assert [o.mode for o in said] == [None, Mode.MANUAL, None]


def test_sticks_are_held_and_fresh_from_the_first_touch_on():
    said = orders(operator(orders=[{"t_s": 0.02, "n_rpm": 600.0}, {"t_s": 0.04, "delta_r_deg": -20.0}]), 6)
    assert [o.t_sticks for o in said[:2]] == [-math.inf] * 2
    assert [o.t_sticks for o in said[2:]] == pytest.approx([0.02, 0.03, 0.04, 0.05])
    assert said[3].sticks == pytest.approx((0.0, 0.0, 10.0))
    assert said[5].sticks == pytest.approx((0.0, -20 * DEG, 10.0))
    assert said[5].setpoint is KEEP_SETPOINT


@pytest.mark.parametrize("to_port", [-1, 1], ids=["rudder to port", "rudder to starboard"])
@pytest.mark.parametrize("base", [0.0, 3.1, -2.0])
def test_zigzag_puts_the_rudder_over_at_each_heading_whichever_way_it_turns(base, to_port):
    """On a vehicle that turns with a lag, so that its heading overshoots."""
    ground = operator(
        orders=[{"t_s": 0.0, "n_rpm": 500.0}], zigzag={"t_s": 1.0, "delta_r_deg": 15.0, "heading_deg": 20.0}
    )
    psi, r, track, rudder = base, 0.0, [], []
    for k in range(4000):
        order = ground.read(Tick(k, DT_NS))
        r += 0.01 * (to_port * order.sticks.delta_r - r)
        psi += 0.01 * r
        ground.write(cycle(math.remainder(psi, math.tau)))
        track.append((psi - base) / DEG)
        rudder.append(order.sticks.delta_r / DEG)
        assert order.sticks.n == pytest.approx(500 / 60)
    assert rudder[99] == 0.0
    assert rudder[100] == pytest.approx(15.0)
    overs = [k for k in range(101, 4000) if rudder[k] != rudder[k - 1]]
    assert len(overs) >= 4
    assert [abs(track[k - 1]) for k in overs] == pytest.approx([20.0] * len(overs), abs=0.2)
    assert all(track[a - 1] * track[b - 1] < 0 for a, b in itertools.pairwise(overs))
    assert {round(abs(r), 6) for r in rudder[100:]} == {15.0}


def test_a_surfacing_scenario_is_done_when_the_vehicle_disarmed_itself_at_the_surface():
    ground = operator(completes="surfaced")
    for mode in (Mode.DISARMED, Mode.MANUAL, Mode.MISSION, Mode.SURFACE):
        ground.write(cycle(mode=mode))
        assert (ground.completion.done, ground.completion.completed) == (False, False)
    ground.write(cycle(mode=Mode.DISARMED))
    assert (ground.completion.done, ground.completion.completed) == (True, True)


@pytest.mark.parametrize(("z", "fix", "up"), [(8.0, False, False), (8.0, True, True), (0.4, False, True)])
def test_a_vehicle_that_disarms_in_the_deep_has_not_surfaced(z, fix, up):
    ground = operator(completes="surfaced")
    for mode in (Mode.SURFACE, Mode.DISARMED):
        ground.write(cycle(mode=mode, z=z, fix=fix))
    assert (ground.completion.done, ground.completion.completed) == (up, up)


@pytest.mark.parametrize(("true_depth", "up"), [(42.4, False), (3.3, False), (1.0, False), (0.9, True)])
def test_where_the_plant_is_in_reach_its_depth_tells_and_no_estimate(true_depth, up):
    scenario = parse({"description": "x.", "duration_s": 100.0, "completes": "surfaced"}, "here")
    ground = ScriptedOperator(scenario, lambda: true_depth)
    for mode in (Mode.SURFACE, Mode.DISARMED):
        ground.write(cycle(mode=mode, z=0.1, fix=True, events=(changed(mode, Cause.SURFACED),)))
    assert (ground.completion.done, ground.completion.completed) == (up, up)
    assert ground.completion.judged_by == "truth"
    assert operator().completion.judged_by == "estimate"
    if not up:
        assert f"at a depth of {true_depth:.1f} m in truth" in ground.completion.reason


def test_a_vehicle_that_disarms_under_way_has_not_surfaced():
    ground = operator(completes="surfaced")
    for mode in (Mode.MISSION, Mode.DISARMED):
        ground.write(cycle(mode=mode))
    assert (ground.completion.done, ground.completion.completed) == (False, False)


@pytest.mark.parametrize(
    ("last", "completed"), [(Mode.HOLD, True), (Mode.MANUAL, True), (Mode.SURFACE, False), (Mode.DISARMED, False)]
)
def test_a_timed_scenario_is_completed_by_a_vehicle_that_is_still_doing_it(last, completed):
    ground = operator()
    for mode in (Mode.DISARMED, Mode.HOLD, last):
        ground.write(cycle(mode=mode))
    assert ground.completion.done is False
    assert ground.completion.completed is completed


def test_a_vehicle_that_a_rule_surfaces_has_not_completed_its_mission_and_the_rule_is_named():
    ground = operator(completes="surfaced")
    ground.write(cycle(mode=Mode.MISSION))
    ground.write(cycle(mode=Mode.SURFACE, failsafe=True, events=(changed(Mode.SURFACE, Cause.DEPTH_LIMIT, 7.0, 7.0),)))
    ground.write(cycle(mode=Mode.DISARMED, events=(changed(Mode.DISARMED, Cause.SURFACED),)))
    assert (ground.completion.done, ground.completion.completed) == (True, False)
    assert ground.completion.surfaced
    assert ground.completion.reason == "surfaced safely because of a rule: depth comes to 7.00 m, limit 7 m"


def test_the_rule_that_brought_it_up_is_named_before_one_that_only_turned_it_round():
    ground = operator(completes="surfaced")
    ground.write(cycle(mode=Mode.MISSION))
    lost = changed(Mode.RETURN, Cause.STATION_LOST, 60.0)
    ground.write(cycle(mode=Mode.RETURN, failsafe=True, events=(lost,)))
    ground.write(cycle(mode=Mode.SURFACE, failsafe=True, events=(changed(Mode.SURFACE, Cause.LEAK),)))
    ground.write(cycle(mode=Mode.DISARMED, events=(changed(Mode.DISARMED, Cause.SURFACED),)))
    assert ground.completion.reason == (
        "surfaced safely because of a rule: water in the hull; before that: no ground station heard for 60 s"
    )


def test_a_weight_that_it_cost_is_told():
    ground = operator(completes="surfaced")
    ground.write(cycle(mode=Mode.MISSION))
    ground.write(cycle(mode=Mode.SURFACE, failsafe=True, events=(changed(Mode.SURFACE, Cause.LEAK),)))
    released = Event(EventKind.WEIGHT_RELEASED, Severity.NOTICE, cause=Cause.HARDPOINT_OPEN)
    ground.write(cycle(mode=Mode.SURFACE, drop=True, events=(released,)))
    ground.write(cycle(mode=Mode.DISARMED, drop=True, events=(changed(Mode.DISARMED, Cause.SURFACED),)))
    expected = "surfaced safely, without its drop weight, because of a rule: water in the hull"
    assert ground.completion.reason == expected


def test_a_weight_whose_release_nobody_confirmed_is_not_said_to_be_gone():
    ground = operator(completes="surfaced")
    ground.write(cycle(mode=Mode.MISSION))
    ground.write(cycle(mode=Mode.SURFACE, failsafe=True, events=(changed(Mode.SURFACE, Cause.LEAK),)))
    ground.write(cycle(mode=Mode.DISARMED, drop=True, events=(changed(Mode.DISARMED, Cause.SURFACED),)))
    expected = "surfaced safely, the release of its drop weight commanded, because of a rule: water in the hull"
    assert ground.completion.reason == expected


@pytest.mark.parametrize(
    ("becomes", "after", "told"),
    [
        (WeightState.RELEASED, 0.3, "without its drop weight,"),
        (WeightState.STUCK, 3.1, "the release of its drop weight commanded,"),
        (WeightState.COMMANDED, 5.0, "the release of its drop weight commanded,"),
    ],
)
def test_a_flight_whose_weight_is_released_at_the_surface_goes_on_until_it_is_known_what_became_of_it(
    becomes, after, told
):
    ground = operator(completes="surfaced")
    ground.write(cycle(mode=Mode.MISSION))
    ground.write(cycle(mode=Mode.SURFACE, failsafe=True, events=(changed(Mode.SURFACE, Cause.LEAK),)))
    surfaced = (changed(Mode.DISARMED, Cause.SURFACED),)
    ground.write(cycle(mode=Mode.DISARMED, drop=True, events=surfaced, t=90.0, weight=WeightState.HELD))
    ended = None
    for k in range(1, 600):
        t = 90.0 + 0.01 * k
        state = becomes if t >= 90.0 + after - 1e-6 else WeightState.COMMANDED
        released = Event(EventKind.WEIGHT_RELEASED, Severity.WARNING, cause=Cause.HARDPOINT_OPEN)
        events = (released,) if state is WeightState.RELEASED else ()
        ground.write(cycle(mode=Mode.DISARMED, drop=True, events=events, t=t, weight=state))
        if ground.completion.done:
            ended = t
            break
    assert ended == pytest.approx(90.0 + after, abs=0.011)
    assert ground.completion.surfaced
    assert ground.completion.reason == f"surfaced safely, {told} because of a rule: water in the hull"


def test_a_vehicle_that_says_surfaced_in_the_deep_has_not_surfaced_safely_and_both_are_told():
    scenario = parse({"description": "x.", "duration_s": 100.0, "completes": "surfaced"}, "here")
    ground = ScriptedOperator(scenario, lambda: 42.4)
    ground.write(cycle(mode=Mode.MISSION))
    ground.write(cycle(mode=Mode.SURFACE, failsafe=True, events=(changed(Mode.SURFACE, Cause.LEAK),)))
    ground.write(cycle(mode=Mode.DISARMED, events=(changed(Mode.DISARMED, Cause.SURFACED),)))
    assert not ground.completion.surfaced
    assert ground.completion.reason == (
        "a rule ended the mission: MISSION -> SURFACE: water in the hull, then "
        "SURFACE -> DISARMED: surfaced, at a depth of 42.4 m in truth"
    )


def test_who_sinks_again_after_it_surfaced_has_completed_nothing():
    scenario = parse({"description": "x.", "duration_s": 100.0, "completes": "surfaced", "watch_s": 1.0}, "here")
    depth = [0.3]
    ground = ScriptedOperator(scenario, lambda: depth[0])
    ground.write(cycle(mode=Mode.MISSION))
    ground.write(cycle(mode=Mode.SURFACE))
    ground.write(cycle(mode=Mode.DISARMED, events=(changed(Mode.DISARMED, Cause.SURFACED),)))
    depth[0] = 28.4
    ground.write(cycle(mode=Mode.DISARMED, t=2.0))
    assert (ground.completion.done, ground.completion.completed, ground.completion.surfaced) == (False, False, False)
    assert ground.completion.reason == "it had surfaced, and sank again: it ends disarmed, 28.4 m deep in truth"
    depth[0] = 0.2
    ground.write(cycle(mode=Mode.DISARMED, t=2.1))
    assert (ground.completion.done, ground.completion.completed) == (True, True)


def test_to_be_disarmed_by_hand_at_the_surface_is_no_rule_that_brought_it_up():
    ground = operator(completes="surfaced")
    for mode in (Mode.MISSION, Mode.DISARMED):
        ground.write(cycle(mode=mode, z=0.3))
    assert not ground.completion.surfaced
    assert ground.completion.reason.startswith("it was disarmed too soon: ")


def test_the_reason_is_the_change_of_mode_whatever_else_happened_in_its_tick():
    ground = operator()
    ground.write(cycle(mode=Mode.MISSION))
    report = Event(
        EventKind.LEARNING_REPORT, Severity.INFO, cause=Cause.LEARNED_ALL, numbers=(1.0, 0.02), names=("N_r",)
    )
    ground.write(cycle(mode=Mode.SURFACE, failsafe=True, events=(changed(Mode.SURFACE, Cause.LEAK), report)))
    assert not ground.completion.surfaced
    ended = "a rule ended the mission: MISSION -> SURFACE: water in the hull"
    assert ground.completion.reason == f"{ended}; at the end in mode SURFACE, at the surface by its own estimate"
    ground.write(cycle(mode=Mode.SURFACE, z=7.0))
    assert ground.completion.reason == f"{ended}; at the end in mode SURFACE, under water by its own estimate"


@pytest.mark.parametrize(("true_depth", "where"), [(-0.1, "at the surface"), (12.0, "under water")])
def test_where_a_rule_ended_a_flight_the_truth_tells_whether_it_had_come_up(true_depth, where):
    scenario = parse({"description": "x.", "duration_s": 100.0, "completes": "surfaced"}, "here")
    ground = ScriptedOperator(scenario, lambda: true_depth)
    ground.write(cycle(mode=Mode.HOLD))
    leak = (changed(Mode.SURFACE, Cause.LEAK),)
    ground.write(cycle(mode=Mode.SURFACE, failsafe=True, z=5.0, fix=True, events=leak))
    assert ground.completion.reason.startswith("a rule ended mode HOLD: ")
    assert ground.completion.reason.endswith(f"; at the end in mode SURFACE, {where} by the truth")


def at_the_end(true_depth=None, mode=Mode.SURFACE, t=99.99, fix=False, cause=None):
    """Return the operator of 100 s whose last cycle is at t; `cause`: of the rule that changed the mode."""
    scenario = parse({"description": "x.", "duration_s": 100.0, "completes": "surfaced"}, "here")
    ground = ScriptedOperator(scenario, None if true_depth is None else lambda: true_depth)
    ground.write(cycle(mode=Mode.MISSION))
    events = () if cause is None else (changed(mode, cause),)
    ground.write(cycle(mode=mode, failsafe=cause is not None, events=events, t=50.0))
    ground.write(cycle(mode=mode, fix=fix, z=5.0, t=t))
    return ground


@pytest.mark.parametrize(
    ("mode", "doing"),
    [
        (Mode.MISSION, "flew its mission"),
        (Mode.RETURN, "was returning"),
        (Mode.SURFACE, "was coming up"),
        (Mode.MANUAL, "was in mode MANUAL"),
    ],
)
def test_a_flight_that_its_time_ended_says_so_and_what_gives_more(mode, doing):
    over = f"the scenario's 100 s were over while it {doing}, under water"
    more = "scenario.duration_s gives more"
    assert at_the_end(12.0, mode).completion.reason == f"{over} by the truth; {more}"
    assert at_the_end(None, mode).completion.reason == f"{over} by its own estimate; {more}"


def test_a_rule_that_ended_the_mission_is_told_behind_the_time_that_was_too_short():
    ground = at_the_end(12.0, Mode.RETURN, cause=Cause.LEAK)
    assert ground.completion.reason.startswith("the scenario's 100 s were over while it was returning, ")
    assert "; before that, a rule ended the mission: " in ground.completion.reason
    earlier = at_the_end(12.0, Mode.RETURN, t=80.0, cause=Cause.LEAK)  # somebody else ended the flight
    assert earlier.completion.reason.startswith("a rule ended the mission: ")


@pytest.mark.parametrize("cause", [None, Cause.LEAK])
@pytest.mark.parametrize(("t", "time"), [(99.99, "the scenario's 100 s were"), (80.0, "the time was")])
def test_who_is_at_the_surface_and_hears_no_fix_did_not_know_it(t, time, cause):
    unknown = f"it was at the surface when {time} over, but did not know it: no fix"
    assert at_the_end(0.3, t=t, cause=cause).completion.reason.startswith(unknown)
    for ground in (at_the_end(0.3, t=t, fix=True), at_the_end(None, t=t), at_the_end(0.3, Mode.MISSION, t=t)):
        assert "did not know it" not in ground.completion.reason
    assert at_the_end(12.0, t=80.0).completion.reason == "it had not surfaced when the time was over"


def test_the_end_of_a_mission_is_meant_and_its_end_by_a_rule_is_not():
    for failsafe in (True, False):
        ground = operator(completes="surfaced")
        for mode in (Mode.MISSION, Mode.SURFACE, Mode.DISARMED):
            ground.write(cycle(mode=mode, failsafe=failsafe and mode is Mode.SURFACE))
        assert ground.completion.completed is not failsafe


def test_a_vehicle_that_was_never_armed_has_the_refusal_as_reason():
    ground = operator()
    refusal = Event(EventKind.ARMING_REFUSED, Severity.WARNING, cause=Cause.CHARGE_NEEDED, numbers=(0.03, 0.2))
    ground.write(cycle(mode=Mode.DISARMED, events=(refusal,)))
    assert ground.completion.reason == "never armed: arming refused: battery at 3%, needs 20%"
    later = Event(EventKind.SENSOR_GOOD, Severity.NOTICE, names=("dvl",))
    ground.write(cycle(mode=Mode.DISARMED, events=(later,)))
    assert ground.completion.reason == "never armed: arming refused: battery at 3%, needs 20%"


def test_a_vehicle_that_is_watched_is_done_when_it_has_lain_at_the_surface_for_so_long():
    ground = operator(completes="surfaced", watch_s=60.0)
    for t, mode, done in (
        (9.0, Mode.MISSION, False),
        (10.0, Mode.SURFACE, False),
        (20.0, Mode.DISARMED, False),
        (79.0, Mode.DISARMED, False),
        (79.5, Mode.SURFACE, False),  # it sank again
        (90.0, Mode.DISARMED, False),
        (149.0, Mode.DISARMED, False),
        (150.0, Mode.DISARMED, True),
    ):
        ground.write(cycle(mode=mode, t=t))
        assert ground.completion.done is done
