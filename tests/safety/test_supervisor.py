"""The supervisor's table, one below, at and one above every bound; arming; and what people are told."""

from __future__ import annotations

import itertools
import math
from dataclasses import fields, replace
from operator import attrgetter
from typing import Any

import pytest

from firmware_py.marine import Eta, Nu
from firmware_py.params import dump, load
from firmware_py.records.command import AscentStage, ModeState
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import Cause
from firmware_py.records.event_text import texts
from firmware_py.records.health import ALL_GOOD, SourceFault, SourceHealth, SourceState, sound
from firmware_py.records.manoeuvrability import UNLIMITED
from firmware_py.records.order import NO_ORDER, Arming, Asker, Mode, Order
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix, Heard, SensorFrame, never
from firmware_py.safety.action import Action
from firmware_py.safety.rules import ARMING, RULES, SafetyParams, safer
from firmware_py.safety.station_params import StationParams
from firmware_py.safety.supervisor import Supervisor, VehicleFin
from firmware_py.tick import Tick

DT_NS = 10_000_000
PARAMS = SafetyParams()
AT_ONCE = replace(PARAMS, depth_max_time=0.0)
"""For tests in which being too deep is the rule that holds, and not what it takes."""
ARM = Order(arming=Arming.ARM)
DISARM = Order(arming=Arming.DISARM)
FORCE = Order(arming=Arming.FORCE_DISARM)
STATE = StateEstimate(Eta(0, 0, 5, 0, 0, 0), Nu(1, 0, 0, 0, 0, 0), 1, 0.1, 0.1, 20.0, True, True, True, False)
LEVEL, CHARGED = Ahrs(0, 0, 0, 0, 0, 0), Battery(48.0, 1.0, 0.8)
NEVER = never(math.nan)
NEVER_DVL = never(Dvl(*[math.nan] * 5))
NEVER_FIX = never(Fix(*[math.nan] * 3))


class SupervisedVehicle:
    """A supervisor with everything in order around it, until told otherwise."""

    def __init__(
        self,
        params: SafetyParams = PARAMS,
        has_mission: bool = True,
        fins: tuple[VehicleFin, ...] = (),
        weight: bool = True,
    ) -> None:
        self.fins = fins
        self.supervisor = Supervisor(params, has_mission, fins=fins, drop_weight=weight)
        self.k = 0
        self.mode = Mode.DISARMED
        self.events: tuple[str, ...] = ()
        self.answer = ModeState(Mode.DISARMED, False, 0)
        self._state: dict[str, Any] = {}
        self._estimate = STATE

    def frame(self, **parts: Any) -> SensorFrame:
        t = Tick(self.k, DT_NS).t
        straight = Heard(0.0, t, True, True)
        good = {
            "ahrs": Heard(LEVEL, t, True, True),
            "dvl": NEVER_DVL,
            "pressure": Heard(1.5e5, t, True, True),
            "altitude": NEVER,
            "fix": NEVER_FIX,
            "fins": (straight,) * (len(self.fins) or 4),
            "n": straight,
            "battery": Heard(CHARGED, t, True, True),
            "leak": Heard(0.3, t, True, True),
        }
        return SensorFrame(**(good | parts))

    def tick(
        self, order: Order = NO_ORDER, *, done: bool = False, late_ns: int = 0, frame: Any = None, **state: Any
    ) -> Mode:
        z = state.pop("z", 5.0)
        actuators, reference = state.pop("actuators", sound(len(self.fins))), state.pop("reference", None)
        left = state.pop("left", UNLIMITED)
        eta = STATE.eta._replace(z=z, theta=state.pop("theta", 0.0))
        state = {"eta": eta} | state
        if state != self._state:
            self._state, self._estimate = state, replace(STATE, **state)
        tick = Tick(self.k, DT_NS, late_ns)
        seen = tick, self.frame(**(frame or {})), self._estimate, actuators
        self.answer = self.supervisor.update(*seen, order, done, reference, left)
        self.mode, self.k = self.answer.mode, self.k + 1
        self.events = tuple(texts(self.supervisor.events))
        return self.mode

    def ticks_until(self, mode: Mode, most: int, **inputs: Any) -> int:
        """How many ticks with the same inputs it takes to come to a mode."""
        for i in range(1, most + 1):
            if self.tick(**inputs) is mode:
                return i
        raise AssertionError(f"{mode.name} not within {most} ticks, still {self.mode.name}")


def sailing(
    mode: Mode = Mode.HOLD, params: SafetyParams = PARAMS, fins: tuple[VehicleFin, ...] = ()
) -> SupervisedVehicle:
    vehicle = SupervisedVehicle(params, fins=fins)
    assert vehicle.tick(Order(arming=Arming.ARM, mode=mode)) is mode, vehicle.events
    return vehicle


def old(age: float, value: Any, k: int) -> Heard[Any]:
    return Heard(value, Tick(k, DT_NS).t - age, False, True)


def test_begins_disarmed_and_says_nothing() -> None:
    vehicle = SupervisedVehicle()
    assert vehicle.tick() is Mode.DISARMED
    assert vehicle.events == ()


def test_arming_leads_to_manual_or_to_what_is_ordered_with_it() -> None:
    vehicle = SupervisedVehicle()
    assert vehicle.tick(ARM) is Mode.MANUAL
    assert vehicle.events == ("DISARMED -> MANUAL: ordered",)
    assert vehicle.tick(ARM) is Mode.MANUAL
    assert vehicle.events == ()
    for mode in (Mode.MANUAL, Mode.HOLD, Mode.MISSION, Mode.SURFACE):
        assert sailing(mode).mode is mode


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.MISSION, Mode.SURFACE, Mode.GUIDED])
def test_a_mode_ordered_while_disarmed_is_the_one_that_arming_leads_to(mode: Mode) -> None:
    vehicle = SupervisedVehicle()
    assert vehicle.tick(Order(mode=mode)) is Mode.DISARMED
    assert vehicle.events == (f"{mode.name} chosen; arming begins it",)
    assert vehicle.answer.chosen is mode
    assert vehicle.tick(Order(mode=mode)) is Mode.DISARMED
    assert vehicle.events == ()
    vehicle.tick(ARM, frame={"fins": (old(1.1, 0.1, vehicle.k),) * 4})
    assert vehicle.answer.chosen is mode  # refused, it is still chosen
    assert vehicle.tick(ARM) is mode
    assert vehicle.answer.chosen is Mode.MANUAL
    assert vehicle.tick(FORCE) is Mode.DISARMED
    assert vehicle.tick(ARM) is Mode.MANUAL  # a choice holds once: nobody wants the mission again unasked


def test_a_choice_is_changed_and_taken_back_and_a_mode_with_arming_goes_before_it() -> None:
    vehicle = SupervisedVehicle()
    for mode in (Mode.MISSION, Mode.HOLD, Mode.MANUAL):
        vehicle.tick(Order(mode=mode))
        assert vehicle.answer.chosen is mode
    vehicle.tick(Order(mode=Mode.MISSION))
    vehicle.tick(DISARM)
    assert vehicle.answer.chosen is Mode.MANUAL
    vehicle.tick(Order(mode=Mode.MISSION))
    assert vehicle.tick(Order(arming=Arming.ARM, mode=Mode.GUIDED)) is Mode.GUIDED


def test_ready_is_said_of_the_mode_that_is_chosen() -> None:
    vehicle = SupervisedVehicle()
    low = {"frame": {"battery": Heard(Battery(48.0, 1.0, 0.05), 0.0, True, True)}}
    vehicle.tick(**low)
    assert not vehicle.answer.ready
    vehicle.tick(Order(mode=Mode.SURFACE), **low)  # to come up, any charge will do
    assert vehicle.answer.ready


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.MISSION, Mode.SURFACE])
@pytest.mark.parametrize("order", [DISARM, Order(mode=Mode.DISARMED), Order(arming=Arming.DISARM, mode=Mode.MISSION)])
def test_disarming_is_obeyed_at_the_surface_and_refused_under_water(mode: Mode, order: Order) -> None:
    vehicle = sailing(mode)
    assert vehicle.tick(order, z=1.01) is mode
    assert vehicle.events == ("DISARMED refused: under water, at 1.0 m; surface first, or force it (param2 = 21196)",)
    assert vehicle.tick(order, z=1.0) is Mode.DISARMED
    assert vehicle.events == (f"{mode.name} -> DISARMED: ordered",)
    assert vehicle.tick() is Mode.DISARMED


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.MISSION, Mode.SURFACE])
def test_forced_disarming_is_always_obeyed(mode: Mode) -> None:
    vehicle = sailing(mode)
    assert vehicle.tick(FORCE, z=99.0, leak=True, attitude_ok=False) is Mode.DISARMED
    assert vehicle.events == (f"{mode.name} -> DISARMED: ordered",)
    assert vehicle.tick() is Mode.DISARMED


def test_disarming_without_a_depth_needs_a_fix_or_force() -> None:
    vehicle = sailing(Mode.SURFACE)
    assert vehicle.tick(DISARM, z=0.0, depth_ok=False) is Mode.SURFACE
    assert vehicle.events[0].startswith("DISARMED refused: depth not known; surface first")
    fix = Heard(Fix(0.1, 0.2, 2.0), Tick(vehicle.k, DT_NS).t, True, True)
    assert vehicle.tick(DISARM, z=5.0, depth_ok=False, frame={"fix": fix}) is Mode.DISARMED


def test_modes_change_by_order_while_armed() -> None:
    vehicle = sailing(Mode.MANUAL)
    for mode in (Mode.HOLD, Mode.MISSION, Mode.MANUAL, Mode.SURFACE):
        was = vehicle.mode
        assert vehicle.tick(Order(mode=mode)) is mode
        assert vehicle.events == (f"{was.name} -> {mode.name}: ordered",)


def test_events_name_the_station_that_ordered_or_was_refused() -> None:
    vehicle = SupervisedVehicle(has_mission=False)
    one, two = Asker(0, 255, 190, 400), Asker(1, 254, 1, 176)
    assert vehicle.tick(Order(mode=Mode.HOLD, asker=two)) is Mode.DISARMED
    assert vehicle.events == ("HOLD chosen by station 254/1; arming begins it",)
    vehicle.tick(replace(ARM, asker=one), frame={"fins": (old(1.1, 0.1, vehicle.k),) * 4})
    assert vehicle.events == ("arming refused to station 255/190: not every fin heard within 1 s (fin_needed)",)
    vehicle.tick(replace(ARM, asker=one))
    assert vehicle.events == ("DISARMED -> HOLD: ordered by station 255/190",)
    vehicle.tick(Order(mode=Mode.MISSION, asker=two))
    assert vehicle.events == ("MISSION refused to station 254/1: no mission is loaded",)
    vehicle.tick(Order(mode=Mode.MANUAL, asker=two), depth_ok=False)  # it is a rule that surfaces
    assert vehicle.events == ("HOLD -> SURFACE: no good depth for 1 s",)
    vehicle.tick(replace(FORCE, asker=two))
    assert vehicle.events == ("SURFACE -> DISARMED: ordered by station 254/1",)


def test_without_a_mission_there_is_no_mission_mode() -> None:
    vehicle = SupervisedVehicle(has_mission=False)
    assert vehicle.tick(Order(arming=Arming.ARM, mode=Mode.MISSION)) is Mode.DISARMED
    assert vehicle.events == ("MISSION refused: no mission is loaded",)
    vehicle.tick(ARM)
    assert vehicle.tick(Order(mode=Mode.MISSION)) is Mode.MANUAL
    assert vehicle.events == ("MISSION refused: no mission is loaded",)


def test_surface_is_latched_until_disarmed() -> None:
    vehicle = sailing(params=AT_ONCE)
    assert vehicle.tick(z=PARAMS.depth_max + 1.0) is Mode.SURFACE
    for mode in (Mode.MANUAL, Mode.HOLD, Mode.MISSION):
        assert vehicle.tick(Order(arming=Arming.ARM, mode=mode)) is Mode.SURFACE
        assert vehicle.events == (f"{mode.name} refused: surfacing, which only disarming ends",)
    assert vehicle.tick(Order(mode=Mode.SURFACE)) is Mode.SURFACE
    assert vehicle.events == ()
    assert vehicle.tick(FORCE) is Mode.DISARMED
    assert vehicle.tick(ARM) is Mode.MANUAL


REFUSALS: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
    ("attitude", {"attitude_ok": False}, {}),
    ("attitude", {}, {"ahrs": never(Ahrs(*[math.nan] * 6))}),
    ("depth", {"depth_ok": False}, {}),
    ("depth", {}, {"pressure": never(math.nan)}),
    ("water in the hull", {"leak": True}, {}),
    ("battery at 19%", {}, {"battery": Heard(Battery(48.0, 1.0, 0.19), 0.0, True, True)}),
    ("battery not heard", {}, {"battery": Heard(Battery(48.0, 1.0, math.nan), 0.0, True, True)}),
    ("battery not heard", {}, {"battery": Heard(Battery(48.0, 1.0, 0.9), 0.0, True, False)}),
    ("fin", {}, {"fins": (Heard(0.0, 0.0, True, True),) * 3 + (never(math.nan),)}),
    ("fin", {}, {"fins": (Heard(0.0, 0.0, True, True),) * 3 + (Heard(math.nan, 0.0, True, True),)}),
    ("rolled", {"eta": STATE.eta._replace(phi=-0.79)}, {}),
    ("rolled", {"eta": STATE.eta._replace(theta=0.79)}, {}),
    ("depth comes to 31.00 m", {"z": 31.0}, {}),
    ("altitude comes to 1.00 m", {"altitude": 1.0}, {}),
]


@pytest.mark.parametrize(("why", "state", "frame"), REFUSALS)
def test_arming_is_refused_and_says_why(why: str, state: dict[str, Any], frame: dict[str, Any]) -> None:
    vehicle = SupervisedVehicle()
    assert vehicle.tick(ARM, frame=frame, **state) is Mode.DISARMED
    assert len(vehicle.events) == 1
    assert vehicle.events[0].startswith("arming refused: ")
    assert why in vehicle.events[0]
    vehicle.k = 0
    assert vehicle.tick(ARM) is Mode.MANUAL


@pytest.mark.parametrize(("why", "state", "frame"), REFUSALS)
def test_a_check_says_what_arming_would_and_does_nothing(
    why: str, state: dict[str, Any], frame: dict[str, Any]
) -> None:
    vehicle = SupervisedVehicle()
    check = Order(arming=Arming.CHECK)
    assert vehicle.tick(check, frame=frame, **state) is Mode.DISARMED
    (said,) = vehicle.events
    vehicle.k = 0
    vehicle.tick(ARM, frame=frame, **state)
    assert vehicle.events == (said.replace("would be", "is").replace("arming is refused", "arming refused"),)
    assert why in said
    vehicle.k = 0
    assert vehicle.tick(check) is Mode.DISARMED
    assert vehicle.events == ("ready to be armed",)
    sailor = sailing()
    assert sailor.tick(check) is Mode.HOLD
    assert sailor.events == ()


def test_all_reasons_to_refuse_are_told_at_once() -> None:
    vehicle = SupervisedVehicle()
    vehicle.tick(ARM, attitude_ok=False, depth_ok=False, leak=True)
    assert all(word in vehicle.events[0] for word in ("attitude", "depth", "water"))
    assert vehicle.events[0].count("no good attitude") == 1


def test_bounds_of_arming() -> None:
    for angle, mode in ((0.785, Mode.MANUAL), (math.radians(45.0), Mode.MANUAL), (0.786, Mode.DISARMED)):
        assert SupervisedVehicle().tick(ARM, eta=STATE.eta._replace(theta=-angle)) is mode
    for charge, mode in ((0.199, Mode.DISARMED), (0.2, Mode.MANUAL), (0.201, Mode.MANUAL)):
        battery = Heard(Battery(48.0, 1.0, charge), 0.0, True, True)
        assert SupervisedVehicle().tick(ARM, frame={"battery": battery}) is mode
    for age, mode in ((0.99, Mode.MANUAL), (1.0, Mode.MANUAL), (1.01, Mode.DISARMED)):
        vehicle = SupervisedVehicle()
        vehicle.k = 200
        assert vehicle.tick(ARM, frame={"fins": (old(age, 0.0, 200),) * 4}) is mode
    unknown = Heard(Battery(48.0, 1.0, math.nan), 0.0, True, True)
    assert SupervisedVehicle(replace(PARAMS, battery_arm=0.0)).tick(ARM, frame={"battery": unknown}) is Mode.MANUAL
    silent = replace(PARAMS, fin_needed=False)
    assert SupervisedVehicle(silent).tick(ARM, frame={"fins": (never(math.nan),) * 4}) is Mode.MANUAL


def test_what_lies_at_depth_may_be_armed_to_come_up() -> None:
    low = {"battery": Heard(Battery(48.0, 1.0, 0.05), 0.0, True, True)}
    bad = {"frame": low, "leak": True, "depth_ok": False, "altitude": 0.5}
    assert SupervisedVehicle().tick(Order(arming=Arming.ARM, mode=Mode.SURFACE), **bad) is Mode.SURFACE
    assert SupervisedVehicle().tick(Order(arming=Arming.ARM, mode=Mode.HOLD), **bad) is Mode.DISARMED
    blind = SupervisedVehicle()
    assert blind.tick(Order(arming=Arming.ARM, mode=Mode.SURFACE), attitude_ok=False) is Mode.DISARMED


def charge(value: float) -> dict[str, Any]:
    return {"frame": {"battery": Heard(Battery(48.0, 1.0, value), 0.0, True, True)}}


# condition at its bound: (inputs just inside, at, just outside, ticks it must hold, word in the sentence)
AT_BOUNDS: list[tuple[str, dict[str, Any], dict[str, Any], dict[str, Any], int]] = [
    ("depth", {"z": 29.99}, {"z": 30.0}, {"z": 30.001}, 31),
    ("altitude", {"altitude": 2.01}, {"altitude": 2.0}, {"altitude": 1.999}, 101),
    ("water", {"leak": False}, {"altitude": math.nan}, {"leak": True}, 51),
    ("attitude", {}, charge(math.nan), {"attitude_ok": False}, 1),
    ("depth", {}, {}, {"depth_ok": False}, 1),
]


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.MISSION])
@pytest.mark.parametrize(("word", "inside", "at", "outside", "ticks"), AT_BOUNDS)
def test_each_rule_at_its_bound(
    mode: Mode, word: str, inside: dict[str, Any], at: dict[str, Any], outside: dict[str, Any], ticks: int
) -> None:
    vehicle = sailing(mode)
    for inputs in (inside, at):
        for _ in range(ticks + 1):
            assert vehicle.tick(**inputs) is mode
    for _ in range(ticks - 1):
        assert vehicle.tick(**outside) is mode
        assert vehicle.events == ()
    vehicle.tick(**inside)  # a break, and the count begins anew
    assert vehicle.ticks_until(Mode.SURFACE, ticks, **outside) == ticks
    assert len(vehicle.events) == 1
    assert vehicle.events[0].startswith(f"{mode.name} -> SURFACE: ")
    assert word in vehicle.events[0]


@pytest.mark.parametrize(("part", "value", "limit"), [("ahrs", Ahrs(0, 0, 0, 0, 0, 0), 0.5), ("pressure", 1.5e5, 1.0)])
def test_the_age_is_judged_here_too_whatever_the_estimator_says(part: str, value: Any, limit: float) -> None:
    vehicle = sailing()
    vehicle.k = 1000  # t = 10 s: limits that binary fractions hold exactly
    for age in (limit - 0.01, limit):
        assert vehicle.tick(frame={part: old(age, value, vehicle.k)}) is Mode.HOLD
        vehicle.k = 1000
    assert vehicle.tick(frame={part: old(limit + 0.01, value, vehicle.k)}) is Mode.SURFACE


def test_late_cycles_of_the_last_second_are_counted() -> None:
    for late_ns, count in ((DT_NS - 1, 0), (DT_NS, 0), (DT_NS + 1, 1)):
        vehicle = sailing()
        vehicle.tick(late_ns=late_ns)
        assert vehicle.answer.late == count
    vehicle = sailing()
    vehicle.tick(late_ns=DT_NS + 1)
    for _ in range(99):
        vehicle.tick()
        assert vehicle.answer.late == 1
    vehicle.tick()
    assert vehicle.answer.late == 0
    for i in range(1, 11):
        assert vehicle.tick(late_ns=2 * DT_NS) is Mode.HOLD
        assert vehicle.answer.late == i
    assert vehicle.tick(late_ns=2 * DT_NS) is Mode.SURFACE
    assert vehicle.events == ("HOLD -> SURFACE: 11 cycles late within a second, limit 10",)


def test_a_mission_ends_in_surfacing_and_surfacing_in_disarmed() -> None:
    vehicle = sailing(Mode.MISSION)
    assert vehicle.tick() is Mode.MISSION
    assert vehicle.tick(done=True) is Mode.SURFACE
    assert vehicle.answer.mission_done
    assert vehicle.events == ("MISSION -> SURFACE: mission done",)
    for _ in range(300):
        assert vehicle.tick(z=0.5, done=True, frame=heard_fix(vehicle)) is Mode.SURFACE
    for _ in range(200):
        assert vehicle.tick(z=0.499, frame=heard_fix(vehicle)) is Mode.SURFACE
    assert vehicle.tick(z=0.51, frame=heard_fix(vehicle)) is Mode.SURFACE
    for _ in range(200):
        assert vehicle.tick(z=0.499, frame=heard_fix(vehicle)) is Mode.SURFACE
    assert vehicle.tick(z=0.499, frame=heard_fix(vehicle)) is Mode.DISARMED
    assert vehicle.events == ("SURFACE -> DISARMED: surfaced",)


def test_an_order_given_as_the_mission_ends_is_obeyed() -> None:
    vehicle = sailing(Mode.MISSION)
    assert vehicle.tick(Order(mode=Mode.HOLD), done=True) is Mode.HOLD


def test_a_mission_that_was_done_before_does_not_end_the_next_one() -> None:
    vehicle = sailing(Mode.HOLD)
    assert vehicle.tick(Order(mode=Mode.MISSION), done=True) is Mode.MISSION  # the guidance has not yet begun it anew
    assert vehicle.tick(done=False) is Mode.MISSION


def test_only_surfacing_is_over_at_the_surface() -> None:
    for mode in (Mode.MANUAL, Mode.HOLD, Mode.MISSION):
        vehicle = sailing(mode)
        for _ in range(300):
            assert vehicle.tick(z=0.0) is mode


def heard_fix(vehicle: SupervisedVehicle, age: float = 0.5) -> dict[str, Any]:
    return {"fix": old(age, Fix(0.1, 0.2, 2.0), vehicle.k)}


def test_a_fix_and_a_good_depth_tell_of_the_surface_and_neither_does_alone() -> None:
    vehicle = sailing(Mode.SURFACE)
    for age, z in ((2.01, 0.3), (0.5, 0.5), (0.5, 5.0)):  # an old fix; deep by a good pressure
        for _ in range(300):
            assert vehicle.tick(z=z, frame=heard_fix(vehicle, age)) is Mode.SURFACE
    for _ in range(200):
        assert vehicle.tick(z=0.3, frame=heard_fix(vehicle)) is Mode.SURFACE
    assert vehicle.tick(z=0.3, frame=heard_fix(vehicle)) is Mode.DISARMED


def test_without_depth_the_way_made_upwards_is_the_second_witness() -> None:
    vehicle = sailing(Mode.SURFACE)
    for _ in range(300):  # by dead reckoning it is still deep; or the bottom has not sunk far enough
        assert vehicle.tick(depth_ok=False, z=4.0, altitude=23.0, frame=heard_fix(vehicle)) is Mode.SURFACE
    for _ in range(300):
        assert vehicle.tick(depth_ok=False, z=0.0) is Mode.SURFACE
    for _ in range(200):
        assert vehicle.tick(depth_ok=False, z=0.4, frame=heard_fix(vehicle)) is Mode.SURFACE
    assert vehicle.tick(depth_ok=False, z=0.4, frame=heard_fix(vehicle)) is Mode.DISARMED
    vehicle = sailing(Mode.SURFACE)
    frames = ({"depth_ok": False, "altitude": 24.5, "frame": heard_fix(vehicle, 0.0)} for _ in range(201))
    assert [vehicle.tick(**inputs) for inputs in frames][-1] is Mode.DISARMED


def test_without_a_receiver_depth_and_the_height_made_tell_of_the_surface() -> None:
    params = replace(PARAMS, ascent=replace(PARAMS.ascent, fix_needed=False))
    still, risen = sailing(Mode.SURFACE, params), sailing(Mode.SURFACE, params)
    for vehicle, theta in ((still, 0.0), (risen, 0.2)):
        for _ in range(2200):
            vehicle.tick(theta=theta)  # at 1 m/s
    for _ in range(300):
        assert still.tick(z=0.3) is Mode.SURFACE
    assert risen.ticks_until(Mode.DISARMED, 201, z=0.3) == 201


def test_attitude_that_stays_away_is_no_reason_to_disarm() -> None:
    vehicle = sailing(Mode.MISSION)
    for _ in range(4600):
        assert vehicle.tick(attitude_ok=False) is Mode.SURFACE
    assert vehicle.answer.ascent is AscentStage.STOPPED  # nothing is gained, and there is no weight to release


def test_the_most_severe_rule_wins_and_further_reasons_are_told_once() -> None:
    vehicle = sailing(params=AT_ONCE)
    assert vehicle.tick(z=31.0, depth_ok=False) is Mode.SURFACE
    assert vehicle.events == ("HOLD -> SURFACE: no good depth for 1 s",)
    told = []
    for _ in range(150):
        vehicle.tick(leak=True)
        told += vehicle.events
    assert told == ["water in the hull"]


def test_an_order_never_wins_over_a_rule() -> None:
    vehicle = sailing(Mode.HOLD, AT_ONCE)
    assert vehicle.tick(Order(mode=Mode.MISSION), z=31.0) is Mode.SURFACE
    assert vehicle.events == ("HOLD -> SURFACE: depth comes to 31.00 m, limit 30 m",)


def test_frozen_and_thawed_it_goes_on_the_same() -> None:
    vehicle, twin = sailing(Mode.MISSION), SupervisedVehicle()
    for _ in range(30):
        vehicle.tick(altitude=1.0, late_ns=2 * DT_NS if vehicle.k % 9 == 0 else 0)
    twin.supervisor.thaw(vehicle.supervisor.freeze())
    twin.k = vehicle.k
    for _ in range(90):
        assert twin.tick(altitude=1.0) is vehicle.tick(altitude=1.0)
        assert (twin.answer, twin.events) == (vehicle.answer, vehicle.events)
        assert twin.supervisor.freeze() == vehicle.supervisor.freeze()
    assert vehicle.mode is Mode.SURFACE


def test_the_table_names_its_parameters_and_ends_with_what_was_ordered() -> None:
    for rule in RULES:
        assert rule.time == "" or isinstance(attrgetter(rule.time)(PARAMS), float)
        named = attrgetter(rule.answer)(PARAMS) if isinstance(rule.answer, str) else rule.answer
        assert isinstance(named, Action | Mode)
    assert all(rule.time == "" and rule.answer is Mode.DISARMED for rule in ARMING)
    several = Cause.STATION_LOST, Cause.PROPELLER_FAULT  # a rule for each mode; stuck or lost, and running away
    once = [rule.cause for rule in RULES if rule.cause not in several]
    assert len(set(once)) == len(once)
    assert [rule.cause for rule in RULES[-2:]] == [Cause.MISSION_DONE, Cause.RETURN_DONE]  # no more than an excuse


def test_every_action_parameter_belongs_to_one_rule() -> None:
    answers = [rule.answer for rule in RULES if isinstance(rule.answer, str)]
    declared = [f.name for f in fields(SafetyParams) if f.name.endswith("_action")]
    declared += [f"station.{f.name}" for f in fields(StationParams) if f.name.endswith("_action")]
    assert sorted(answers) == sorted(declared)


def test_modes_in_the_order_of_safety() -> None:
    order = (Mode.DISARMED, Mode.SURFACE, Mode.RETURN, Mode.HOLD)
    for above, below in itertools.pairwise(order):
        assert safer(above, below)
        assert not safer(below, above)
    for mode in (Mode.MANUAL, Mode.MISSION, Mode.LOITER, Mode.GUIDED):
        assert safer(Mode.HOLD, mode)
        assert not safer(mode, Mode.MANUAL)


def test_parameters_come_back_from_their_table() -> None:
    assert load(SafetyParams, dump(PARAMS), "test") == PARAMS


def test_arming_names_what_would_bring_it_up_and_is_set_otherwise() -> None:
    off = replace(
        PARAMS,
        attitude_action=Action.NONE,
        energy_action=Action.NONE,  # it only warns
        leak_action=Action.RETURN,  # that ends at the surface
        station=replace(PARAMS.station, hold_action=Action.WARN),
    )
    vehicle = SupervisedVehicle(off)
    vehicle.tick(ARM)
    assert set(vehicle.events) == {
        "DISARMED -> MANUAL: ordered",
        "set so that it is not brought up: safety.attitude_action = none, safety.station.hold_action = warn",
    }


@pytest.mark.parametrize(
    ("was", "said"),
    [(SourceFault.SILENT, "dvl is heard again, and believed"), (SourceFault.CONTRADICTED, "dvl agrees again")],
)
def test_a_sensor_that_was_only_silent_is_not_said_to_agree_again(was: SourceFault, said: str) -> None:
    vehicle = sailing(Mode.HOLD)
    vehicle.tick(z=3.0, sensors=ALL_GOOD._replace(dvl=SourceHealth(SourceState.LOST, was)))
    vehicle.tick(z=3.0, sensors=ALL_GOOD)
    assert vehicle.events == (said,)


@pytest.mark.parametrize(
    ("heard", "said"),
    [(True, "fix is heard again, and believed"), (False, "fix not heard, and not expected: it is under water")],
)
def test_a_receiver_that_is_not_heard_under_water_is_not_said_to_agree_again(heard: bool, said: str) -> None:
    vehicle = sailing(Mode.HOLD)
    silent = SourceHealth(SourceState.LOST, SourceFault.SILENT)
    vehicle.tick(z=0.5, sensors=ALL_GOOD._replace(fix=silent))
    assert vehicle.events == ("fix lost: silent",)
    vehicle.tick(z=3.0, sensors=ALL_GOOD, frame=heard_fix(vehicle) if heard else None)
    assert vehicle.events == (said,)
