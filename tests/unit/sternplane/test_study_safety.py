"""The safety study finds each unsafe end, goes on where it was broken off, and knows every kind of fault."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path
from types import SimpleNamespace

import pytest
from markupsafe import Markup
from sternplane.cli import main
from sternplane.cli.main import parser
from sternplane.sitl.flight import FlightRequest, prepare
from sternplane.study.safety import campaign, command
from sternplane.study.safety import flight as flight_module
from sternplane.study.safety.campaign import LEFT_OUT, TRIALS, Job, jobs
from sternplane.study.safety.columns import words
from sternplane.study.safety.flight import with_bar30, written
from sternplane.study.safety.flight_list import again, short_revision
from sternplane.study.safety.glossary import ACTUATORS, GLOSSARY, SENSORS, STAGES
from sternplane.study.safety.judge import Ending, Judge
from sternplane.study.safety.mission import DEPTH_MAX, ONSETS
from sternplane.study.safety.mission_trials import SINKING
from sternplane.study.safety.page import page
from sternplane.study.safety.store import Store
from sternplane.study.safety.struck import FINS, ON_BUS, struck
from sternplane.study.safety.verdict import judge, rows

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.marine import Eta
from firmware_py.params import ParamError
from firmware_py.records.command import AscentStage
from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.health import ActuatorFault, SourceFault
from firmware_py.records.order import Mode
from firmware_py.run.usage_error import UsageError
from sim_bridge.faults.catalogue import KINDS
from sim_bridge.faults.fault import parse_fault
from sim_bridge.plant.environment import EnvironmentParams

SEA = EnvironmentParams(bottom_depth=40.0)
ONSET = 20.0
SAFE = [(0.0, 5.0, Mode.MISSION, Cause.ORDERED), (100.0, 0.2, Mode.SURFACE, Cause.MISSION_DONE)]


def event(kind, *numbers, cause=Cause.NONE, name=""):
    return Event(kind, Severity.WARNING, cause=cause, numbers=numbers, names=(name,) if name else ())


def cycle(t, z, mode, cause, events=(), fins=(0.0,) * 4, fix=False):
    heard = SimpleNamespace(ok=fix, age=lambda _t: 0.0)
    return SimpleNamespace(
        tick=SimpleNamespace(t=t),
        state=SimpleNamespace(eta=SimpleNamespace(z=z)),
        frame=SimpleNamespace(fix=heard),
        mode=SimpleNamespace(mode=mode, cause=cause),
        applied=SimpleNamespace(fins=fins, n=5.0),
        events=events,
    )


def seen(steps, theta=0.0, watch=0.0):
    """Return the judge after (t, true depth, mode, cause, how the cycle differs)."""
    found = Judge(SEA, ONSET, 5.3, 0.5, watch)
    for t, z, mode, cause, *more in steps:
        how = dict(more[0]) if more else {}
        truth = SimpleNamespace(
            eta=Eta(0.0, 0.0, z, 0.0, theta, 0.0), drop_weight=0.0 if how.pop("drop", 0) else 1335.0
        )
        found.see(cycle(t, z, mode, cause, **how), truth)
    return found


def ending(steps):
    return seen(steps).found.ending(DEPTH_MAX)


RULE = {"events": (event(EventKind.MODE_CHANGED, cause=Cause.DEPTH_LIMIT),)}
WARNED = {"events": (event(EventKind.RULE_WARNS, cause=Cause.BATTERY_LOW),)}
NOT_UP = {"events": (event(EventKind.RULE_WARNS, cause=Cause.SURFACING_LONG),)}
HELD = {"events": (event(EventKind.WEIGHT_NOT_RELEASED, cause=Cause.HARDPOINT_HOLDS, name="drop weight"),)}
HANGS_LATER = [(60.0, 9.0, Mode.MISSION, Cause.ORDERED), (70.0, 9.0, Mode.SURFACE, Cause.LEAK)]


@pytest.mark.parametrize(
    ("last", "wanted"),
    [
        ([(100.0, 0.9, Mode.DISARMED, Cause.SURFACED)], Ending.FLOWN),
        ([(50.0, 9.0, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE), (99.0, 0.9, Mode.SURFACE, Cause.DEPTH_LIMIT)], Ending.UP),
        (
            [(50.0, 9.0, Mode.SURFACE, Cause.LEAK, {"drop": True}), (99.0, 0.9, Mode.SURFACE, Cause.LEAK)],
            Ending.DROPPED,
        ),
        ([(50.0, 9.0, Mode.SURFACE, Cause.LEAK, {"drop": True})], Ending.BELOW),
        ([(50.0, 9.0, Mode.SURFACE, Cause.LEAK), (60.0, 9.0, Mode.SURFACE, Cause.LEAK, NOT_UP)], Ending.BELOW),
        ([(50.0, 9.0, Mode.SURFACE, Cause.LEAK), (60.0, 9.0, Mode.SURFACE, Cause.LEAK, HELD)], Ending.BELOW),
        # a rule that says something else, or said it of an ascent before, does not say why it is below
        ([(50.0, 9.0, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE)], Ending.LOST),
        ([(50.0, 9.0, Mode.MISSION, Cause.ORDERED, WARNED)], Ending.LOST),
        ([(50.0, 9.0, Mode.SURFACE, Cause.LEAK, NOT_UP), *HANGS_LATER], Ending.LOST),
        ([(50.0, 1.1, Mode.SURFACE, Cause.MISSION_DONE)], Ending.LOST),
        ([(50.0, 9.0, Mode.DISARMED, Cause.ORDERED)], Ending.LOST),
        ([(50.0, 9.0, Mode.SURFACE, Cause.LEAK, RULE), (60.0, 9.0, Mode.DISARMED, Cause.SURFACED)], Ending.LOST),
        ([(50.0, 0.9, Mode.DISARMED, Cause.SURFACED, RULE), (60.0, 1.1, Mode.DISARMED, Cause.SURFACED)], Ending.BELOW),
        (
            [
                (50.0, 0.9, Mode.DISARMED, Cause.SURFACED, RULE),
                *((t, 1.1, Mode.DISARMED, Cause.SURFACED) for t in (60.0, 91.0)),
            ],
            Ending.LOST,
        ),
        ([(50.0, 33.1, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE), (99.0, 0.0, Mode.SURFACE, Cause.LEAK)], Ending.DEEP),
        ([(50.0, 32.9, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE), (99.0, 0.0, Mode.SURFACE, Cause.LEAK)], Ending.UP),
        ([(50.0, 5.0, Mode.MISSION, Cause.ORDERED, {"fins": (math.nan,)}), SAFE[1]], Ending.NOT_FINITE),
        ([(50.0, math.nan, Mode.MISSION, Cause.ORDERED)], Ending.LOST),
    ],
)
def test_each_end_is_told_from_the_others(last, wanted):
    assert ending([SAFE[0], *last]) is wanted
    assert wanted.unsafe == (wanted.value in ("lost", "deep", "aground", "not finite"))


@pytest.mark.parametrize(
    ("mission_until", "given_up"),
    [(100.0, 450.0), (200.0, 540.0), (440.0, 780.0), (500.0, 940.0), (1200.0, math.inf)],
    ids=["surfacing long", "surfacing later", "surfacing late", "slow", "too slow"],
)
def test_a_vehicle_that_still_flies_its_mission_is_given_time(mission_until, given_up):
    """One that surfaces has 450 s from the start, or 337.5 s from then, or 450 s from the end of a longer mission."""
    judge = Judge(SEA, ONSET, 5.3, 0.5, patience=450.0)
    times = [10.0 * i for i in range(120)]
    for t in times:
        mode = Mode.MISSION if t < mission_until else Mode.SURFACE
        truth = SimpleNamespace(eta=Eta(0.0, 0.0, 9.0, 0.0, 0.0, 0.0), drop_weight=1335.0)
        judge.see(cycle(t, 9.0, mode, Cause.ORDERED), truth)
        if judge.done:
            break
    assert (t if judge.done else math.inf) == given_up
    assert judge.found.ending(DEPTH_MAX) is Ending.LOST


@pytest.mark.parametrize(("up", "end", "how"), [(800.0, 800.0, Ending.UP), (1200.0, 1108.0, Ending.LOST)])
def test_a_vehicle_that_is_coming_up_again_when_it_is_given_up_may_do_so(up, end, how):
    """That is at 777.5 s, for it began to come up at 440 s; it has sunk since, and begins once more at 770 s."""
    judge = Judge(SEA, ONSET, 5.3, 0.5, patience=450.0)
    for t in map(float, range(0, 1200, 2)):
        attempt = max((t0 for t0 in (100.0, 440.0, 770.0) if t >= t0), default=math.inf)
        risen = t >= (up if attempt == 770.0 else attempt + 30.0)
        mode, cause = (Mode.SURFACE, Cause.LEAK) if t >= attempt else (Mode.MISSION, Cause.ORDERED)
        if risen and attempt != 770.0:
            mode, cause = Mode.DISARMED, Cause.SURFACED
        depth = 0.5 if risen and t < (9e9 if attempt == 770.0 else attempt + 32.0) else 1.5 + 0.005 * t
        truth = SimpleNamespace(eta=Eta(0.0, 0.0, depth, 0.0, 0.0, 0.0), drop_weight=1335.0)
        judge.see(cycle(t, depth, mode, cause), truth)
        if judge.done:
            break
    assert (t, judge.found.ending(DEPTH_MAX)) == (end, how)


def test_a_flight_that_touched_the_bottom_is_aground_whatever_else_it_did():
    found = seen(SAFE).found
    assert found.ending(DEPTH_MAX) is Ending.FLOWN
    found.aground = True
    assert found.ending(DEPTH_MAX) is Ending.AGROUND


def test_the_distance_to_the_bottom_is_that_of_the_bow_when_it_points_down():
    level, down = seen([(0.0, 30.0, Mode.MISSION, Cause.ORDERED)]), None
    down = seen([(0.0, 30.0, Mode.MISSION, Cause.ORDERED)], theta=-0.5)
    assert level.found.bottom == pytest.approx(10.0 - 0.25)
    assert down.found.bottom == pytest.approx(10.0 - 2.65 * math.sin(0.5) - 0.25 * math.cos(0.5))


def test_a_flight_ends_when_the_vehicle_is_up_and_disarmed_or_lies_disarmed_for_a_minute():
    armed = (0.0, 5.0, Mode.MISSION, Cause.ORDERED)
    assert not seen([(t, 5.0, Mode.DISARMED, Cause.NONE) for t in (0.0, 100.0)]).done
    assert not seen([armed, (30.0, 0.5, Mode.SURFACE, Cause.LEAK), (99.0, 0.5, Mode.SURFACE, Cause.LEAK)]).done
    assert seen([armed, (30.0, 0.5, Mode.DISARMED, Cause.SURFACED), (31.5, 0.5, Mode.DISARMED, Cause.SURFACED)]).done
    lies = [armed, *((t, 9.0, Mode.DISARMED, Cause.ATTITUDE_DEAD) for t in (30.0, 60.0, 89.0))]
    assert not seen(lies).done
    assert seen([*lies, (90.0, 9.0, Mode.DISARMED, Cause.ATTITUDE_DEAD)]).done
    rises = [armed, *((t, 9.0 - 0.1 * t, Mode.DISARMED, Cause.ATTITUDE_DEAD) for t in (10.0, 40.0, 70.0))]
    assert not seen(rises).done


def test_a_vehicle_that_may_sink_again_is_watched_after_it_disarmed_itself():
    up = [SAFE[0], *((t, 0.3, Mode.DISARMED, Cause.SURFACED) for t in (100.0, 101.5, 159.0))]
    assert seen(up).done
    assert not seen(up, watch=60.0).done
    assert seen([*up, (160.0, 0.3, Mode.DISARMED, Cause.SURFACED)], watch=60.0).done
    sinks = seen([*up, (159.5, 1.2, Mode.DISARMED, Cause.SURFACED)], watch=60.0)
    assert not sinks.done
    later = [*up, (170.0, 0.8, Mode.DISARMED, Cause.SURFACED), (175.0, 1.1, Mode.DISARMED, Cause.SURFACED)]
    assert not seen(later, watch=90.0).done  # it sinks on: what it does about it is to be seen
    assert sinks.found.ending(DEPTH_MAX) is Ending.BELOW  # it may find out yet


def flown(title, steps, onset=0, seed=1000):
    found = seen(steps).found
    return {
        "key": Job(title, onset, seed).key,
        "trial": title,
        "onset": onset,
        "seed": seed,
        "eddies": 0.0,
        "learning": True,
        "revision": "r",
        "ending": found.ending(DEPTH_MAX).value,
        "log": "",
        "keep": False,
        "replay": "",
        "outcome": "completed",
        "cpu_s": 10.0,
        "found": found.plain(),
    }


def said(t, kind, fault, name):
    return (t, 5.0, Mode.MISSION, Cause.ORDERED, {"events": (event(kind, float(fault), name=name),)})


def both_doubted(t, *names):
    doubts = tuple(event(EventKind.SENSOR_SUSPECT, float(SourceFault.UNDECIDED), name=name) for name in names)
    return (t, 5.0, Mode.MISSION, Cause.ORDERED, {"events": doubts})


LOST, JAMMED = EventKind.SENSOR_LOST, EventKind.ACTUATOR_FAULT


@pytest.mark.parametrize(
    ("title", "step", "named", "in_time"),
    [
        ("off:pressure", said(21.1, LOST, SourceFault.SILENT, "pressure"), 1.1, True),
        ("off:pressure", said(21.2, LOST, SourceFault.SILENT, "pressure"), 1.2, False),
        ("off:pressure", said(21.0, LOST, SourceFault.SILENT, "dvl"), math.inf, False),
        ("off:pressure", said(21.0, LOST, SourceFault.DRIFT, "pressure"), math.inf, False),
        ("nan:dvl", said(21.0, LOST, SourceFault.UNHEALTHY, "dvl"), 1.0, True),
        ("nan:dvl", said(21.0, LOST, SourceFault.SILENT, "dvl"), math.inf, False),
        ("bias:pressure=3", said(21.0, LOST, SourceFault.STEP, "pressure"), 1.0, True),
        ("bias:pressure=3", said(21.0, LOST, SourceFault.TWO_SENDERS, "pressure"), math.inf, False),
        ("off:pressure", said(19.0, LOST, SourceFault.SILENT, "pressure"), math.inf, False),
        ("jam:stern_port=23", said(20.8, JAMMED, ActuatorFault.JAMMED, "stern_port"), 0.8, True),
        ("jam:stern_port=23", said(20.8, JAMMED, ActuatorFault.SILENT, "stern_port"), math.inf, False),
        ("set:leak=100", (22.0, 5.0, Mode.SURFACE, Cause.LEAK, RULE), math.inf, False),
    ],
)
def test_a_fault_is_named_by_the_right_source_in_time(title, step, named, in_time):
    verdict = judge(flown(title, [SAFE[0], step, SAFE[1]]))
    assert verdict.named == pytest.approx(named)
    assert verdict.in_time is in_time


def test_an_alarm_before_the_fault_is_a_false_one():
    steps = [SAFE[0], said(10.0, LOST, SourceFault.DRIFT, "ahrs"), SAFE[1]]
    alarms = [row for row in rows([flown("off:fix", steps)]) if row.case == "false alarms"]
    assert [row.ok for row in alarms] == [False]


def test_what_physics_forbids_is_shown_and_does_not_count():
    deep = [SAFE[0], (50.0, 39.0, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE)]
    title = "jam: both stern planes, 23 deg, no feedback"
    assert [judge(flown(title, deep, onset)).unsafe for onset in (0, 1, 2)] == [True, True, False]
    found = rows([flown(title, deep, 2)])
    assert all(row.ok is not False for row in found if row.case == "safe")
    assert [row.value for row in found if row.figure == f"beyond the bound, unsafe: {title}"] == [1.0]


def test_a_quiet_flight_that_ends_unsafe_misses_a_target_though_it_said_nothing():
    quiet = flown("off:fix", SAFE) | {"trial": ""}
    for ending_of_it, met in ((Ending.FLOWN, True), (Ending.AGROUND, False)):
        found = rows([quiet | {"ending": ending_of_it.value}])
        assert all(row.ok is not False for row in found) is met


SUSPECT = EventKind.SENSOR_SUSPECT


@pytest.mark.parametrize(
    ("faults", "names"),
    [
        (("off:altimeter@9",), {"altitude"}),
        (("set:dvl.altitude=1@9", "off:esc@9"), {"dvl", "propeller"}),
        (("off:battery@9",), {"battery", "leak"}),
        (("nan:battery@9",), {"battery"}),
        (("off:leak@9",), {"leak"}),
        (("silent:servo_hub@9",), set(FINS)),
        (("jam:rudder_upper=3@9+5",), {"rudder_upper"}),
        (("stuck:weight@9",), {"drop weight"}),
        (("off:bus@9",), set(ON_BUS)),
        (("lossy:bus=30@9", "babble:bus=7500@9"), set()),
        (("ballast:weight=1@9", "set:current.east=1@9", "lost:station@9", "full:disk@9"), set()),
    ],
)
def test_what_a_fault_strikes_is_known_by_the_names_of_the_events(faults, names):
    assert struck(faults) == names


@pytest.mark.parametrize(
    ("title", "steps", "accused"),
    [
        ("off:ahrs", [said(20.5, LOST, SourceFault.SILENT, "ahrs")], []),
        ("off:ahrs", [said(85.0, SUSPECT, SourceFault.DRIFT, "dvl")], ["dvl"]),
        ("off:dvl", [said(22.0, JAMMED, ActuatorFault.LOST, "rudder_upper")], ["rudder_upper"]),
        ("jam:stern_port=23", [said(20.8, JAMMED, ActuatorFault.JAMMED, "rudder_upper")], ["rudder_upper"]),
        # frames are lost: who sends several at once may be silent, and nobody else speaks
        ("lossy:bus=30", [said(30.0, LOST, SourceFault.SILENT, "battery")], []),
        ("lossy:bus=30", [said(30.0, SUSPECT, SourceFault.TWO_SENDERS, "ahrs")], ["ahrs"]),
        ("lossy:ahrs=90", [said(30.0, SUSPECT, SourceFault.TWO_SENDERS, "ahrs")], ["ahrs"]),
        ("duplicate:ahrs.yaw=90", [said(30.0, SUSPECT, SourceFault.TWO_SENDERS, "ahrs")], []),
        ("set:current.east=2", [said(30.0, SUSPECT, SourceFault.CURRENT, "dvl")], []),
        ("set:current.east=2", [said(30.0, SUSPECT, SourceFault.FROZEN, "dvl")], ["dvl"]),
        # of two that contradict each other both are named, but not one alone, and not against one that is known
        ("drift:ahrs.pitch=0.5", [both_doubted(30.0, "dvl", "ahrs")], []),
        ("drift:ahrs.pitch=0.5", [said(30.0, SUSPECT, SourceFault.UNDECIDED, "dvl")], ["dvl"]),
        ("drift:ahrs.pitch=0.5", [both_doubted(30.0, "dvl", "pressure")], ["dvl", "pressure"]),
        (
            "late:altimeter=3",
            [both_doubted(30.0, "dvl", "altitude"), said(30.1, SUSPECT, SourceFault.CONTRADICTED, "altitude")],
            [],
        ),
        (
            "drift:ahrs.pitch=0.5",
            [
                said(30.0, SUSPECT, SourceFault.DRIFT, "ahrs"),
                said(30.2, SUSPECT, SourceFault.UNDECIDED, "dvl"),
            ],
            ["dvl"],
        ),
    ],
)
def test_what_nothing_struck_and_nothing_allows_to_name_is_counted(title, steps, accused):
    flight = flown(title, [SAFE[0], *steps, SAFE[1]])
    assert [name for name, _ in judge(flight).accused] == accused
    row = next(row for row in rows([flight]) if row.figure == f"something sound is named, %: {title}")
    assert row.ok is not bool(accused)


LEFT = (50.0, 9.0, Mode.SURFACE, Cause.ATTITUDE_LOST)


@pytest.mark.parametrize(
    ("title", "steps", "ended"),
    [
        ("lossy:bus=10", [LEFT], "ATTITUDE_LOST"),
        ("off:dvl", [(50.0, 9.0, Mode.RETURN, Cause.BATTERY_SILENT)], "BATTERY_SILENT"),
        ("off:ahrs", [LEFT], ""),
        ("lossy:bus=10", [], ""),
        ("lossy:bus=10", [SAFE[1], (150.0, 0.2, Mode.DISARMED, Cause.SURFACED), (160.0, 2.0, *LEFT[2:])], ""),
    ],
)
def test_a_mission_that_a_rule_ends_without_cause_is_counted(title, steps, ended):
    flight = flown(title, [SAFE[0], *steps])
    assert judge(flight).ended == ended
    found = [row.ok for row in rows([flight]) if row.figure == f"a rule ends the mission, %: {title}"]
    assert found == ([] if title == "off:ahrs" else [not ended])


def test_a_few_of_many_flights_may_do_something_without_cause_and_are_shown():
    few = [flown("off:dvl", [SAFE[0], LEFT, SAFE[1]] if seed == 1000 else SAFE, 0, seed) for seed in range(1000, 1020)]
    figure = "a rule ends the mission, %: off:dvl"
    assert [row.ok for row in rows(few) if row.figure == figure] == [True]
    assert [row.ok for row in rows(few[:19]) if row.figure == figure] == [False]
    for those, mood in ((few, "warn"), (few[:19], "bad")):
        html = page(those, rows(those), ["one"], [])
        assert f'<a class="chip {mood}" href="#off_dvl.ended" title="attitude lost (1)">⇡</a>' in html
        assert f'<td class="outcome first {mood}"><a href="#off_dvl.ended">⇡ 1</a></td>' in html
        assert ("ended without cause in 1 of 19 flights: attitude lost (1)" in html) == (mood == "bad")


def test_the_page_says_after_how_many_of_the_faults_it_was():
    one, other = flown("off:dvl", SAFE), flown("off:ahrs", SAFE)
    assert "What became of the vehicle after the fault off:dvl, judged" in page([one], rows([one]), ["one"], [])
    both = page([one, other], rows([one, other]), ["one"], [])
    assert f"What became of the vehicle after 2 of the {len(TRIALS)} faults, judged" in both
    every = [flown(title, SAFE) for title in TRIALS]
    assert "What became of the vehicle after every fault, judged" in page(every, rows(every), ["one"], [])


def test_the_page_says_what_else_may_be_named_and_why_a_rule_may_end_the_mission():
    flights = [flown("set:current.east=2", SAFE), flown("off:ahrs", SAFE)]
    html = page(flights, rows(flights), ["one"], [])
    assert "may be named step, current or drift too, dvl: no water changes so at once" in html
    assert "a rule may end it: without a tilt to believe it comes up" in html


def test_what_a_trial_wants_to_be_named_is_struck_and_what_it_allows_is_not():
    for trial in TRIALS.values():
        ours = struck(trial.at(trial.onsets[0]))
        assert trial.named is None or set(trial.named.names) <= ours, trial.title
        for one in trial.allowed:
            assert not ours & set(one.names), trial.title
            assert {*one.kinds} <= {*SourceFault.__members__, *ActuatorFault.__members__}, trial.title


def test_a_spike_may_neither_change_the_mode_nor_move_the_depth():
    title = "spike:pressure=37"
    steps = [SAFE[0], (50.0, 5.0, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE), SAFE[1]]
    flight = flown(title, steps)
    flight["found"]["depth_error"] = 0.31
    assert [row.ok for row in rows([flight]) if row.case == "one spike"] == [False, False]
    assert [row.ok for row in rows([flown(title, SAFE)]) if row.case == "one spike"] == [True, True]


def test_every_kind_of_fault_is_flown_or_left_out_for_a_reason():
    flying = {
        f"{fault.kind.name}:{fault.kind.group}" for trial in TRIALS.values() for fault in map(parse_fault, trial.at(0))
    }
    known = {f"{kind.name}:{kind.group}" for kind in KINDS}
    assert flying <= known
    assert not flying & set(LEFT_OUT)
    assert known - flying == set(LEFT_OUT)
    assert all(len(why) > 20 for why in LEFT_OUT.values())


def test_a_trial_says_how_it_is_named_or_why_it_is_not():
    assert [trial.title for trial in TRIALS.values() if trial.named is None and not trial.note] == []
    assert len({trial.name for trial in TRIALS.values()}) == len(TRIALS)


def test_the_full_form_has_every_trial_at_every_onset_with_every_seed_and_a_hundred_quiet_flights():
    full = jobs(range(1000, 1008), short=False)
    assert len({job.key for job in full}) == len(full)
    faults = [job for job in full if job.trial]
    assert len(faults) == 8 * sum(len(trial.onsets) for trial in TRIALS.values())
    fewer = {t.title for t in TRIALS.values() if t.faults and len(t.onsets) < 3 and not t.from_start and not t.profile}
    assert fewer - {t.title for t in SINKING.trials} == {"stuck:weight, off:esc", "silent:hardpoint, off:esc"}
    quiet = [job for job in full if not job.trial]
    assert len(quiet) == 100
    assert {job.eddies for job in quiet} == {0.0, 0.1}
    assert all(job.duration == 600.0 and job.learning for job in quiet)
    assert {(job.learning, job.eddies) for job in faults} == {(True, 0.0), (True, 0.1), (False, 0.0), (False, 0.1)}
    assert 2 * sum(job.learning for job in faults) == len(faults)
    assert sum(job.replay for job in full) >= 30


def test_the_short_form_has_each_onset_quiet_flights_and_a_replay():
    short = jobs(range(1000, 1001), short=True)
    assert {job.onset for job in short} == {-1, 0, 1, 2}
    assert sum(not job.trial for job in short) == 2
    assert any(job.replay for job in short)


def test_help_and_readme_tell_how_many_flights_there_are(capsys):
    full, short = (len(jobs(range(1000, 1008), short=form)) for form in (False, True))
    with pytest.raises(SystemExit):
        parser().parse_args(["study", "safety", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert f"{full:,} flights" in said
    assert f"{short} flights" in said
    readme = (Path(campaign.__file__).parent / "README.md").read_text()
    assert f"| full | {full:,}: {full - 100:,} of faults" in readme
    assert f"| short | {short}: {short - 2} of faults" in readme


def test_one_trial_is_flown_alone():
    chosen = jobs(range(2), short=False, titles=["off:dvl", "off:dvl"])
    assert [(job.trial, job.onset, job.seed) for job in chosen] == [
        ("off:dvl", onset, seed) for seed in (0, 1) for onset in (0, 1, 2)
    ]
    assert [job.trial for job in jobs(range(2), short=True, titles=["lost:station"])] == ["lost:station"]


def test_quiet_flights_are_flown_alone_one_with_each_seed():
    chosen = jobs(range(3, 5), short=False, titles=["quiet"])
    assert [(job.trial, job.seed, job.duration) for job in chosen] == [("", 3, 600.0), ("", 4, 600.0)]
    both = jobs(range(3, 4), short=False, titles=["off:esc", "quiet"])
    assert [job.trial for job in both] == ["off:esc"] * 3 + [""]


@pytest.mark.parametrize(
    ("title", "meant"),
    [("of:dvl", "'off:dvl'"), ("off:gps", "'off:fix'"), ("off:imu", "'off:ahrs'"), ("silent", "'silent:esc'")],
)
def test_a_trial_that_is_not_known_names_what_is_meant(title: str, meant: str) -> None:
    with pytest.raises(UsageError, match=rf"--trial '{title}': is unknown; did you mean {meant}"):
        jobs(range(1), short=False, titles=[title])


def test_a_scenario_of_a_job_is_one(tmp_path):
    for title in ("off:ahrs, off:dvl", "bottom rises to 8 m", ""):
        (tmp_path / "one.toml").write_text(written(Job(title, 1, 1001, 60.0)))
        table = read_toml(tmp_path / "one.toml")
        assert table["environment"]["turbulence_m_s"] == 0.1
        assert len(table["faults"]) == title.count(":")
        assert bool(table["environment"].get("bottom")) == title.startswith("bottom")
        assert all(f"@{ONSETS[1]:g}" in fault for fault in table["faults"])


def test_a_slow_mission_is_struck_where_a_fast_one_would_be_and_gets_its_time(tmp_path):
    slow, fast = Job("NPS AUV II at 1 m/s: off:dvl", 2, 1000), Job("off:dvl", 2, 1000)
    flights = []
    for job in (slow, fast):
        (tmp_path / "one.toml").write_text(written(job))
        flights.append(read_toml(tmp_path / "one.toml"))
    for of, how_much in (("duration_s", 1.8), ("start", 1.0 / 1.8)):
        values = [flight[of]["n_rpm"] if of == "start" else flight[of] for flight in flights]
        assert values[0] == pytest.approx(how_much * values[1])
    assert [flight["waypoints"][0]["speed_m_s"] for flight in flights] == [1.0, 1.8]
    struck_at = [parse_fault(flight["faults"][0]).t for flight in flights]
    assert struck_at[0] == pytest.approx(1.8 * struck_at[1])


def test_water_may_be_too_deep_to_hear_its_bottom(tmp_path):
    (tmp_path / "one.toml").write_text(written(Job("no bottom in reach: off:dvl", 0, 1000)))
    assert read_toml(tmp_path / "one.toml")["environment"]["bottom_depth_m"] == 400.0


def test_a_bar30_measures_in_place_of_the_node_with_less_noise_than_it_has_steps(tmp_path):
    scenario = tmp_path / "one.toml"
    scenario.write_text(written(Job("freeze:pressure in steps wider than its noise", 0, 1000)))
    vehicle = configs() / "npsauv2"
    flight = prepare(FlightRequest(scenario=str(scenario), config=vehicle, io=with_bar30(vehicle, tmp_path)), {})
    assert flight.io.nodes.pressure == 0
    assert [one.driver for one in flight.io.instruments] == ["waterlink", "bar30"]
    assert flight.devices.pressure.noise == 1.0


@pytest.fixture
def few(monkeypatch):
    """A study of two flights that flies none: `ends` is how the second ends, `flew` what was flown."""
    study = SimpleNamespace(ends=SAFE, flew=[])

    def fly_all(wanted, store, revision, console, settings):
        study.settings = settings
        for job in store.missing(wanted):
            study.flew.append(job.key)
            store.add(flown(job.trial, SAFE if job.onset == 0 else study.ends, job.onset, job.seed))

    monkeypatch.setattr(command, "fly_all", fly_all)
    monkeypatch.setattr(
        command, "jobs", lambda seeds, short, _titles: [Job("off:fix", o, s) for s in seeds for o in (0, 1)]
    )
    return study


def study(folder, seeds="1000:1001", *more):
    return main.main(["study", "safety", "--seeds", seeds, "--out", str(folder), *more])


def test_a_study_exits_by_its_cells(tmp_path, few, capsys):
    assert study(tmp_path / "safe") == 0
    few.ends = [SAFE[0], (50.0, 9.0, Mode.MISSION, Cause.ORDERED)]
    assert study(tmp_path / "unsafe") == 1
    out = capsys.readouterr().out
    assert "missed: safe: flights with an unsafe end: 1, target ≤ 0 (n = 2)" in out
    found = json.loads((tmp_path / "unsafe" / "results.json").read_text())["rows"]
    assert {tuple(row) for row in found} == {("case", "figure", "value", "target", "n", "margin", "ok")}
    assert any(row["figure"] == "unsafe: off:fix" and row["ok"] is False for row in found)
    html = (tmp_path / "unsafe" / "report.html").read_text()
    assert "1 of 2 flights unsafe" in html
    assert 'src="http' not in html


def test_a_second_start_flies_only_what_is_missing(tmp_path, few):
    assert study(tmp_path) == 0
    first = list(few.flew)
    assert study(tmp_path) == 0
    assert few.flew == first
    assert study(tmp_path, "1000:1002") == 0
    assert few.flew[len(first) :] == ["off:fix / 0 / 1001", "off:fix / 1 / 1001"]


def test_flights_take_what_is_set_and_a_folder_no_other(tmp_path, few, capsys):
    given = "--set", "vehicle.coefficients.M_q=-0.02"
    assert study(tmp_path, "1000:1001", *given) == 0
    assert few.settings == given[1:]
    assert json.loads((tmp_path / "results.json").read_text())["settings"] == {"vehicle.coefficients.M_q": -0.02}
    assert "vehicle.coefficients.M_q=-0.02" in (tmp_path / "report.html").read_text()
    capsys.readouterr()
    assert study(tmp_path) == 2
    refused = f"was begun with --set {given[1]}, here with nothing set; choose another --out\n"
    assert capsys.readouterr().err == f"sternplane: {tmp_path}: {refused}"


def test_a_flight_of_the_campaign_is_prepared_with_what_is_set(tmp_path, monkeypatch):
    asked = []

    def prepare(request, kept):
        asked.append(request.settings)
        raise ParamError("no flight in this test")

    monkeypatch.setattr(flight_module, "prepare", prepare)
    given = ("vehicle.M_q=-0.02", "sensors.pressure.noise_pa=7")
    with pytest.raises(ParamError):
        flight_module.run(Job("off:fix", 0, 1000), str(tmp_path), "", given)
    with pytest.raises(ParamError):
        flight_module.run(Job("", -1, 1000, 150.0), str(tmp_path), "", given)
    assert asked == [given, given[:1]]  # quiet flights say their noise themselves


def test_a_line_that_a_killed_study_had_begun_is_flown_again(tmp_path):
    job, other = Job("off:fix", 0, 1000), Job("off:fix", 1, 1000)
    store = Store(tmp_path)
    store.add(flown("off:fix", SAFE))
    store.close()
    with store.path.open("a") as file:
        file.write('{"key": "off:fix / 1 / 10')
    again = Store(tmp_path)
    assert again.missing([job, other]) == [other]
    again.add(flown("off:fix", SAFE, 1))
    again.close()
    assert [json.loads(line)["onset"] for line in store.path.read_text().splitlines()] == [0, 1]


def test_one_log_is_kept_for_each_cell_and_every_one_that_must_be(tmp_path):
    def add(seed, steps, keep=False):
        flight = flown("off:fix", steps, 0, seed) | {"log": f"logs/{seed}.mcap", "keep": keep}
        (tmp_path / flight["log"]).touch()
        store.add(flight)

    store = Store(tmp_path)
    for seed, steps, keep in ((1, SAFE, False), (2, SAFE, False), (3, SAFE, True)):
        add(seed, steps, keep)
    store.close()
    store = Store(tmp_path)
    deep = [SAFE[0], (50.0, 9.0, Mode.MISSION, Cause.ORDERED)]
    for seed, steps in ((4, deep), (5, deep), (6, SAFE)):
        add(seed, steps)
    store.close()
    assert [path.name for path in sorted((tmp_path / "logs").iterdir())] == ["1.mcap", "3.mcap", "4.mcap"]
    assert [flight["log"] for flight in store.rows()] == [
        f"logs/{seed}.mcap" if seed in (1, 3, 4) else "" for seed in range(1, 7)
    ]


def test_flights_of_another_revision_are_named(tmp_path, few):
    study(tmp_path)
    lines = (tmp_path / "flights.jsonl").read_text()
    (tmp_path / "flights.jsonl").write_text(lines.replace('"r"', '"8cad8a3975bbba396c9bd805f3110716de200116"', 1))
    study(tmp_path)
    told = (tmp_path / "report.html").read_text()
    assert "2 of 2 flights were made by another revision: 8cad8a39, r." in told
    assert "judged by the judge of today" in told


def test_a_revision_is_named_by_its_first_digits_and_says_whether_it_was_changed():
    assert short_revision("8cad8a3975bbba396c9bd805f3110716de200116-dirty") == "8cad8a39-dirty"
    flight = flown("off:fix", SAFE) | {"revision": "8cad8a3975bbba396c9bd805f3110716de200116"}
    assert "revision 8cad8a39: Completed" in opened(page([flight], rows([flight]), ["one"], []), "off_fix.flown.0")


def test_what_is_not_as_it_should_be_stands_on_top_with_its_log_and_leads_to_its_flights():
    fine, deep = (
        flown("off:leak", SAFE),
        flown("off:fix", [SAFE[0], (50.0, 39.0, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE)], 1),
    )
    deep["log"] = "logs/deep.mcap"
    html = page([fine, deep], rows([fine, deep]), ["one"], [])
    assert (
        '<li><a href="#off_fix.deep.1"><code>off:fix</code></a>: 1 unsafe at 9 m (52 s): too deep · '
        '<a href="logs/deep.mcap">log</a></li>'
    ) in html
    assert '<a href="#off_leak.unnamed"><code>off:leak</code></a>: named in time in 0 of 1 flights' in html
    assert html.count('<tr id="off_fix">') == html.count('<tr id="off_leak">') == 1
    assert "All is as it should be" not in html


def test_an_alarm_before_the_fault_leads_to_its_flights():
    early = flown("off:fix", [SAFE[0], said(10.0, LOST, SourceFault.DRIFT, "ahrs"), SAFE[1]])
    html = page([early], rows([early]), ["one"], [])
    assert '<a href="#off_fix.early"><code>off:fix</code></a>: an alarm before the fault in 1 of 1 flights' in html
    assert opened(html, "off_fix.early").startswith("off:fix, an alarm before the fault: 1 of 1 flights")


def test_a_range_of_one_number_is_one_number():
    found = [flown("off:fix", SAFE, seed=seed) for seed in (1000, 1001)]
    html = page(found, rows(found), ["one"], [])
    assert " … " not in html[html.index('<tr id="off_fix">') : html.index("</table>")]
    assert "All is as it should be" in html


def opened(html, anchor):
    """Return the text of the flights that a link of the page opens."""
    return " ".join(Markup(html.partition(f'id="{anchor}">')[2].partition("</tr>")[0]).striptags().split())


def test_a_cell_opens_its_flights_and_shows_what_is_excused():
    title = "jam: both stern planes, 23 deg, no feedback"
    deep = flown(title, [SAFE[0], (50.0, 39.0, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE)], 2)
    deep["log"] = "logs/jam.2.1000.mcap"
    html = page([deep], rows([deep]), ["one"], [])
    anchor = f"{TRIALS[title].name}.deep.2"
    assert f'<a href="#{anchor}">(1)</a>' in html
    assert f'<a class="chip note" href="#{anchor}" title="25 m: too deep (1)">(▼)</a>' in html
    assert '<a href="logs/jam.2.1000.mcap">log</a>' in html
    assert f"Unsafe; not counted: {TRIALS[title].bound.why}." in opened(html, anchor)
    assert f'greatest depth, beyond a bound: not counted<b><a href="#{anchor}">39.0 m</a></b>' in html
    assert "5 m: not flown" in html
    assert "0 of 1 flights unsafe" in html


def test_a_flight_that_is_not_as_it_should_be_says_what_is_wrong_and_what_happened():
    late, lost, fine = (
        flown("off:pressure", [SAFE[0], said(23.0, LOST, SourceFault.SILENT, "pressure"), SAFE[1]]),
        flown("off:pressure", [SAFE[0], (50.0, 9.0, Mode.MISSION, Cause.ORDERED)], 1, 1001),
        flown("off:pressure", [SAFE[0], said(21.0, LOST, SourceFault.SILENT, "pressure"), SAFE[1]], 0, 1002),
    )
    late["outcome"] = "surfaced safely"
    html = page([late, lost, fine], rows([late, lost, fine]), ["one"], [])
    unnamed = opened(html, "off_pressure.unnamed")
    assert unnamed.startswith("off:pressure, not named in time: 2 of 3 flights")
    assert (
        "named 3 s after the fault, limit 1.1 s. Surfaced safely; in truth 5.0 m deep at most, at the surface"
        in unnamed
    )
    assert "called faulty: pressure silent at 23 s." in unnamed
    below = opened(html, "off_pressure.lost.1")
    assert "seed 1001, off:pressure@52, still water, learning, revision r: unsafe, below, not told; not named." in below
    assert "9.0 m deep at the end; called faulty: nothing." in below
    assert "seed 1002" not in unnamed
    assert "seed 1002, off:pressure@20, still water, learning, revision r: Completed; " in opened(
        html, "off_pressure.flown.0"
    )


def test_the_greatest_depth_leads_to_its_flight_and_says_whether_it_counts():
    flight = flown("off:fix", [SAFE[0], (50.0, 39.0, Mode.SURFACE, Cause.DEPTH_LIMIT, RULE)], 1)
    html = page([flight], rows([flight]), ["one"], [])
    assert 'greatest depth<b><a href="#off_fix.deep.1">39.0 m</a></b>' in html


def test_an_opened_flight_says_when_its_drop_weight_went_and_what_came_before():
    flight = flown("off:fix", SAFE)
    flight["found"] |= {
        "t_drop": 371.3,
        "modes": [(1.0, "MISSION", "ORDERED"), (120.9, "SURFACE", "MISSION_DONE")],
        "rules": [(60.0, "DVL_BAD"), (130.0, "DVL_BAD")],
        "stages": [(268.0, "WAITING"), (298.0, "WAITING"), (371.2, "STOPPED"), (401.0, "STOPPED")],
    }
    text = opened(page([flight], rows([flight]), ["one"], []), "off_fix.flown.0")
    began = "its drop weight went at 371 s, 250 s after it began to come up (mission done)"
    assert f"{began}, after stage waiting at 298 s, stage stopped at 371 s; called faulty" in text
    flight["found"] |= {"modes": [(1.0, "MISSION", "ORDERED")]}
    text = opened(page([flight], rows([flight]), ["one"], []), "off_fix.flown.0")
    assert "its drop weight went at 371 s; called faulty" in text


@pytest.mark.parametrize(
    ("fix", "up", "told"),
    [
        (False, 60.0, "It was at the surface when the time was over, but did not know it: no fix; in truth"),
        (True, 60.0, "It was at the surface when the time was over; in truth"),
        (False, None, "It had not surfaced when the time was over; in truth"),
    ],
)
def test_where_a_recorded_flight_was_when_it_was_given_up_is_told_by_the_truth(fix, up, told):
    flight = flown("off:fix", SAFE) | {"outcome": "it had not surfaced when the time was over"}
    flight["found"] |= {"end_fix": fix, "t_up": up}
    assert told in opened(page([flight], rows([flight]), ["one"], []), "off_fix.flown.0")


@pytest.mark.parametrize(
    ("title", "seconds", "told"),
    [
        ("off:fix", 10.0, "3 flights, one for each onset, about a minute:"),
        ("off:fix", 60.0, "3 flights, one for each onset, about 3 minutes:"),
        ("blocked pressure port", 10.0, "1 flight, about a minute:"),
    ],
)
def test_how_many_flights_the_commands_of_a_flight_fly_stands_above_them(title, seconds, told):
    flight = flown(title, SAFE) | {"cpu_s": seconds}
    assert f"{told} sternplane study" in opened(
        page([flight], rows([flight]), ["one"], []), f"{TRIALS[title].name}.flown.0"
    )


def test_trials_that_need_no_name_are_told_apart_from_those_not_named_in_time():
    found = [flown("off:fix", SAFE), flown("off:leak", SAFE)]
    assert "fault named in time; 1 more need no name<b>0 of 1</b>" in page(found, rows(found), ["one"], [])
    assert "fault named in time<b>0 of 1</b>" in page(found[1:], rows(found[1:]), ["one"], [])


def test_every_word_for_what_is_named_and_done_has_its_meaning():
    for kind, meanings in ((AscentStage, STAGES), (SourceFault, SENSORS), (ActuatorFault, ACTUATORS)):
        assert meanings.keys() == set(kind) - {kind.NONE}
    explained = {word for meanings in GLOSSARY.values() for word in meanings}
    for line in RECORDED.read_text().splitlines():
        found = json.loads(line)["found"]
        spoken = {words(kind) for _, _, kind in found["said"]} | {words(cause) for _, cause in found["rules"]}
        assert spoken | {f"stage {words(stage)}" for _, stage in found["stages"]} <= explained
    html = page([flown("off:fix", SAFE)], [], ["one"], [])
    assert f"<dt>stage waiting</dt>: <dd>{STAGES[AscentStage.WAITING]}</dd>" in html


def test_a_flight_whose_depth_is_no_number_at_the_end_has_its_place_on_the_page():
    flight = flown("off:fix", [SAFE[0], (50.0, math.nan, Mode.MISSION, Cause.ORDERED)])
    html = page([flight], rows([flight]), ["one"], [])
    assert "in truth 5.0 m deep at most, nan m deep at the end" in opened(html, "off_fix.lost.0")


def test_something_sound_and_a_needless_end_are_told_of_the_flight():
    wrong = [SAFE[0], said(30.0, JAMMED, ActuatorFault.WEAK, "rudder_upper"), LEFT, (*SAFE[1][:2], *LEFT[2:])]
    flight = flown("off:dvl", wrong)
    html = page([flight], rows([flight]), ["one"], [])
    for anchor in ("off_dvl.accused", "off_dvl.ended"):
        assert "≠ sound, but called faulty: rudder_upper weak" in opened(html, anchor)
        assert "⇡ a rule ended the mission without cause: attitude lost." in opened(html, anchor)


RECORDED = Path(__file__).parents[2] / "recorded" / "safety" / "flights.jsonl"
SET = "vehicle.M_q=-0.02", "autopilot.estimation.coefficients.turbulence=[0, 0.07]"


@pytest.mark.parametrize("settings", [(), SET])
def test_the_commands_of_a_flight_fly_it_and_read_its_log(settings):
    for trial in TRIALS.values():
        flight = flown(trial.title, SAFE, trial.onsets[-1], 1003)
        study, log = (
            parser().parse_args(shlex.split(line)[1:]) for line in again(judge(flight), settings).splitlines()
        )
        seeds = command.seeds_of(study.seeds, range(0))
        wanted = {job.key: job for job in jobs(seeds, study.short, study.trial)}
        assert wanted[flight["key"]].keep
        assert len(wanted) == len(trial.onsets)
        assert tuple(study.settings) == settings
        assert Path(log.log) == study.out / "logs" / wanted[flight["key"]].file


def test_the_page_of_a_campaign_with_settings_has_them_in_its_commands(tmp_path, few):
    assert study(tmp_path, "1000:1001", "--set", SET[1]) == 0
    assert f"--set '{SET[1]}' --out runs/off_fix.1000" in Markup((tmp_path / "report.html").read_text()).unescape()


@pytest.mark.parametrize(("t", "alarm"), [(4.0, True), (6.0, False)])
def test_what_fails_on_purpose_before_the_fault_is_no_alarm(t, alarm):
    silent = {"events": (event(EventKind.ACTUATOR_FAULT, float(ActuatorFault.SILENT), name="stern_port"),)}
    steps = [SAFE[0], (t, 5.0, Mode.MISSION, Cause.ORDERED, silent), SAFE[1]]
    assert judge(flown("jam: both stern planes, 23 deg, no feedback", steps, onset=1)).early is alarm


@pytest.mark.parametrize(("title", "alarm"), [("drift:pressure=-0.15, no bottom", False), ("off:pressure", True)])
def test_a_warning_that_is_right_before_the_fault_is_no_alarm(title, alarm):
    verdict = judge(flown(title, SAFE, onset=2))
    found = {**verdict.flight["found"], "rules": [[60.5, "DEPTH_UNCHECKED"]]}
    assert judge({**verdict.flight, "found": found}).early is alarm


def test_the_page_shows_what_a_quiet_flight_said_and_how_it_is_flown_again():
    calm = flown("off:fix", SAFE) | {"trial": "", "onset": -1, "eddies": 0.0, "seed": 1002}
    assert "with a false alarm" in page([calm], rows([calm]), (), ())
    said = calm["found"] | {"said": [(12.5, "dvl", "DRIFT")], "rules": [(20.0, "LEAK")]}
    alarmed = calm | {"seed": 1004, "found": said, "log": "logs/quiet.-1.1004.mcap"}
    text = page([calm, alarmed], rows([calm, alarmed]), (), (), ["io.rate_hz=100"])
    assert "dvl drift at 12.5 s, rule: leak at 20 s" in text
    again = "sternplane study safety --trial quiet --seeds 1004:1005 --set io.rate_hz=100 --out runs/quiet.1004"
    assert again in text
    assert "quiet" not in page([flown("off:fix", SAFE)], rows([flown("off:fix", SAFE)]), (), ())


def test_an_interrupted_campaign_leaves_the_page_of_what_was_flown(tmp_path, monkeypatch, capsys):
    def some(wanted, store, *_):
        store.add(flown("off:pressure", [SAFE[0], said(22.0, LOST, SourceFault.SILENT, "pressure"), SAFE[1]]))
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "fly_all", some)
    out = str(tmp_path / "run")
    options = parser().parse_args(["study", "safety", "--trial", "off:pressure", "--seeds", "1000:1001", "--out", out])
    with pytest.raises(KeyboardInterrupt):
        command.command(options)
    assert "1 of 3 flights" in (tmp_path / "run" / "report.html").read_text()
    assert (tmp_path / "run" / "results.json").exists()
    assert "1 of 3 flights: the same --out goes on with the rest" in capsys.readouterr().out
