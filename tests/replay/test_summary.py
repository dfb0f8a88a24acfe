"""The figures of a run, against what the toy's formulas say."""

from __future__ import annotations

import io
import itertools
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console
from sternplane.logs import findings
from sternplane.logs.health_record import Timeline
from sternplane.logs.losses import outliers, times, told
from sternplane.logs.reading import read
from sternplane.logs.summary import Summary, summarise
from sternplane.logs.summary_text import LABEL_WIDTH, key_figures, outcome, summary_table
from sternplane.logs.tracking import path_error, true_columns

from firmware_py.records.event import Cause, EventKind, event
from firmware_py.records.health import ActuatorFault, SourceFault
from firmware_py.records.order import Mode

HELD = np.arange(200, 300) * 0.01
"""The toy flies its mission from 2 s on; it is armed from 1 s on."""


def figures(summary: Summary) -> dict[str, str]:
    """Return what people are told, by its label."""
    return dict(itertools.chain(*key_figures(summary).values()))


def test_figures_of_a_run_with_truth(flown: Path) -> None:
    s = summarise(read(flown))
    assert (s["completed"], s["reason"], s["against"]) == (True, "surfaced", "truth")
    assert (s["vehicle_time_s"], s["wall_time_s"], s["speed_up"]) == pytest.approx((3.0, 0.5, 6.0))
    assert (s["cycles"], s["complete"], s["lost"]) == (300, True, "")
    assert s["depth_tracking_error_rms_m"] == pytest.approx(
        4.0 * math.sqrt(np.mean(np.exp(-HELD / 6.0) ** 2)), rel=1e-9
    )
    assert s["heading_tracking_error_rms_deg"] == pytest.approx(0.0, abs=1e-9)
    # From where it is at 2 s straight to (60, 0); it sails to starboard of that.
    x, y = 1.8 * HELD, 2.0 * np.sin(0.02 * HELD) + 0.01 * HELD
    course = math.atan2(-y[0], 60.0 - x[0])
    off = (y - y[0]) * math.cos(course) - (x - x[0]) * math.sin(course)
    assert s["path_error_rms_m"] == pytest.approx(math.sqrt(np.mean(off**2)), rel=1e-9)
    assert s["path_error_max_m"] == pytest.approx(off[-1], rel=1e-9)
    assert s["depth_max_m"] == pytest.approx(4.0 - 4.0 * math.exp(-2.99 / 6.0))
    # The estimate runs ahead by the integral of gain sin(psi), and stays behind to the east by 1 cm/s.
    ahead = 0.25 * (1.0 - math.cos(0.02 * 2.99)) / 0.02
    assert s["navigation_error_end_m"] == pytest.approx(math.hypot(ahead, 0.0299), abs=2e-3)
    assert s["navigation_error_max_m"] >= s["navigation_error_end_m"]
    # The estimate comes down with 5 s, the truth with 6 s.
    t = 0.01 * np.arange(300)
    misjudged = 4.0 * (np.exp(-t / 6.0) - np.exp(-t / 5.0))
    assert s["depth_estimate_error_max_m"] == pytest.approx(misjudged.max(), rel=1e-9)
    assert s["depth_estimate_error_rms_m"] == pytest.approx(math.sqrt(np.mean(misjudged**2)), rel=1e-9)


def test_a_depth_that_is_held_well_and_estimated_badly_is_told_as_such(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    log.columns["reference.z_d"] = log.truth["eta.z"] + 0.38
    log.columns["state.eta.z"] = log.truth["eta.z"] - 30.0
    rows = figures(summarise(log))
    assert rows["depth off its reference"] == "0.380 m RMS"
    assert rows["depth estimate off"] == "30.000 m RMS, 30.00 m at most"


def test_without_truth_what_is_off_its_reference_is_the_estimate(tmp_path: Path, toy: SimpleNamespace) -> None:
    groups = key_figures(summarise(read(toy.fly(tmp_path / "log.mcap", truth=False))))
    rows = dict(groups["accuracy by the estimate"])
    assert {"depth off its reference", "heading off its reference"} <= rows.keys()
    assert not [label for label in rows if "estimate off" in label]


def test_fin_travel_is_the_total_variation_over_the_time_armed(flown: Path) -> None:
    def way(i: int) -> float:
        """Degrees: the jump to the first angle at 1 s, then from turning point to turning point."""
        turning = [t for n in range(-9, 9) if 1.0 < (t := (math.pi * (n + 0.5) - i) / 0.3) < 2.99]
        angles = [0.0, *(8.0 * math.sin(0.3 * t + i) for t in (1.0, *turning, 2.99))]
        return sum(abs(b - a) for a, b in itertools.pairwise(angles))

    expected = sum(way(i) for i in range(4)) / 4 / 2.0
    assert summarise(read(flown))["fin_travel_deg_s"] == pytest.approx(expected, rel=1e-4)


def test_a_sea_log_has_no_truth_and_says_so(tmp_path: Path, toy: SimpleNamespace) -> None:
    s = summarise(read(toy.fly(tmp_path / "log.mcap", truth=False)))
    assert s["against"] == "estimate"
    assert s["navigation_error_end_m"] is None
    assert s["navigation_error_max_m"] is None
    assert s["depth_tracking_error_rms_m"] == pytest.approx(
        4.0 * math.sqrt(np.mean(np.exp(-HELD / 5.0) ** 2)), rel=1e-9
    )


def test_a_truth_that_is_logged_less_often_is_held(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    topic = log.topics["/truth"]
    del topic.times[1::2], topic.messages[1::2]
    s = summarise(log)
    assert s["against"] == "truth"
    z = 4.0 - 4.0 * np.exp(-np.floor(HELD / 0.02 + 1e-9) * 0.02 / 6.0)
    assert s["depth_tracking_error_rms_m"] == pytest.approx(math.sqrt(np.mean((4.0 - z) ** 2)), rel=1e-9)


def test_late_cycles_are_those_more_than_a_step_late(tmp_path: Path, toy: SimpleNamespace) -> None:
    path = toy.fly(tmp_path / "log.mcap", late_ns=lambda k: 10_000_001 if k % 100 == 7 else 10_000_000)
    assert summarise(read(path))["late_cycles"] == 3


def test_waypoints_passed(tmp_path: Path, toy: SimpleNamespace, flown: Path) -> None:
    assert [summarise(read(flown))[f"waypoints_{name}"] for name in ("passed", "total")] == [0, 3]
    s = summarise(read(toy.fly(tmp_path / "log.mcap", 50.0)))
    assert (s["waypoints_passed"], s["waypoints_total"]) == (1, 3)
    s = summarise(read(toy.fly(tmp_path / "log.mcap", 111.0)))
    assert (s["waypoints_passed"], s["waypoints_total"]) == (3, 3)


def test_the_path_error_does_not_jump_where_the_leg_changes(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap", 50.0))  # straight past the first corner, which guidance leaves at 40 s
    off, t = path_error(log, log.columns, true_columns(log)), log.columns["t"]
    assert np.isnan(off[t < 1.995]).all()
    assert np.abs(np.diff(off[t > 1.995])).max() < 0.02  # what a vehicle of 1.8 m/s can do in a step
    assert off[-1] == pytest.approx(1.8 * 49.99 - 60.0, abs=1e-9)
    assert summarise(log)["path_error_max_m"] == pytest.approx(off[-1])


def test_a_path_is_planned_anew_from_where_the_mission_is_taken_up_again(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap", 50.0))
    c, t = log.columns, log.columns["t"]
    c["mode.mode"] = np.where((t > 41.995) & (t < 44.995), Mode.HOLD, c["mode.mode"])
    off = path_error(log, log.columns, true_columns(log))
    assert off[4199] == pytest.approx(1.8 * 41.99 - 60.0, abs=1e-9)
    assert np.isnan(off[4200:4500]).all()
    assert off[4500] == pytest.approx(0.0, abs=1e-9)
    # The second waypoint is next: north-east of it is left behind, and the vehicle still sails north.
    x, y = 1.8 * t[4500:] - 60.0, 2.0 * np.sin(0.02 * t[4500:]) + 0.01 * t[4500:] - 60.0
    course = math.atan2(-y[0], -x[0])
    across = (y - y[0]) * math.cos(course) - (x - x[0]) * math.sin(course)
    along = (y - y[0]) * math.sin(course) + (x - x[0]) * math.cos(course)
    assert off[4500:] == pytest.approx(np.where(along > 0.0, np.abs(across), np.hypot(x - x[0], y - y[0])), abs=1e-9)


def test_without_a_mission_there_is_no_path_error(tmp_path: Path, toy: SimpleNamespace) -> None:
    s = summarise(read(toy.fly(tmp_path / "log.mcap", mission={"waypoints": []})))
    assert (s["path_error_rms_m"], s["path_error_max_m"]) == (None, None)
    s = summarise(read(toy.fly(tmp_path / "log.mcap", 1.5)))
    assert (s["path_error_rms_m"], s["path_error_max_m"]) == (None, None)


def test_losses_are_shown_where_there_are_some(flown: Path) -> None:
    log = read(flown)
    assert summarise(log)["losses"] == {}
    log.end["losses"] = {"transfers_malformed": 3, "dvl_broken": 0}
    summary = summarise(log)
    assert summary["losses"] == {"transfers_malformed": 3, "dvl_broken": 0}
    assert key_figures(summary)["computer and links"][-1] == ("other nodes of the bus", "3 frames or messages dropped")
    assert "DVL" not in figures(summary)


def test_losses_are_told_by_source_with_their_share_the_worst_first() -> None:
    counts = {
        "transfers_lost_start": 170,
        "transfers_bad_crc": 9,
        "ahrs_lost_start": 160,
        "ahrs_bad_crc": 9,
        "ahrs_missed": 50,
        "battery_missed": 30,
        "pressure_strays": 40,
        "pressure_missed": 1,
        "hardpoint_missed": 5,
        "dvl_bad_checksum": 2,
        "lines_of_the_dvl_lost": 3,
        "bus_not_sent": 12,
        "gcs_2_malformed": 7,
        "dvl_broken": 0,
    }
    received = {"ahrs": 950, "battery": 70, "pressure": 999, "dvl": 995, "hardpoint": 245}
    assert [(loss.source, loss.text) for loss in told(counts, received)] == [
        ("battery and leak sensor", "30 of 100 messages lost (30 %)"),
        ("AHRS", "50 of 1000 messages lost (5 %)"),
        ("drop weight's hardpoint", "5 of 250 messages lost (2 %)"),
        ("DVL", "5 of 1000 lines lost (0.5 %)"),
        ("pressure sensor", "1 of 1000 messages lost (0.1 %)"),
        ("pressure sensor, strays", "40 messages out of sequence, not believed"),
        ("CAN bus", "12 frames that could not be sent"),
        ("other nodes of the bus", "10 frames or messages dropped"),
        ("station 2", "7 malformed messages"),
    ]


def test_outliers_are_told_by_sensor() -> None:
    counts = {"outliers_pressure": 1, "outliers_altitude": 3, "ahrs_missed": 0}
    found = outliers(counts)
    assert told(counts, {"ahrs": 950}) == [], "what came and was not believed is no loss"
    assert [(loss.source, loss.text) for loss in found] == [
        ("altimeter, outliers", "3 left out one by one"),
        ("pressure sensor, outliers", "1 left out one by one"),
    ]


def test_outliers_stand_beside_what_was_found_in_flight(flown: Path) -> None:
    groups = key_figures(summarise(read(flown)) | {"losses": {"outliers_ahrs": 5, "ahrs_missed": 2}})
    assert ("AHRS, outliers", "5 left out one by one") in groups["found in flight"]
    assert [label for label, _ in groups["computer and links"] if "AHRS" in label] == ["AHRS"]


def test_a_second_sender_is_told_beside_what_was_lost_by_it(flown: Path) -> None:
    counts = {"ahrs_missed": 2630, "ahrs_strays": 1819}
    received = {"ahrs": 9463}
    assert [loss.text for loss in told(counts, received)] == ["2630 of 12093 messages lost (21.7 %)"]
    lost = "2630 of 12093 messages lost (21.7 %): two senders, 1819 messages not believed"
    assert [(loss.source, loss.text) for loss in told(counts, received, ["ahrs"])] == [("AHRS", lost)]
    only = told({"ahrs_strays": 2401}, received, ["ahrs"])
    assert [(loss.source, loss.text) for loss in only] == [
        ("AHRS, strays", "2401 messages of two senders, not believed")
    ]
    log = read(flown)
    log.end["losses"] = counts
    assert "two senders" not in figures(summarise(log))["AHRS"]
    doubled = event(EventKind.NODE_FAULT, numbers=(float(SourceFault.TWO_SENDERS),), names=("ahrs",))
    log.events.append((2.5, (doubled,)))
    assert summarise(log)["two_senders"] == ["ahrs"]
    assert figures(summarise(log))["AHRS"].endswith(": two senders, 1819 messages not believed")


def test_no_two_lines_of_one_source_have_one_label() -> None:
    nodes = ("ahrs", "pressure", "altimeter", "fix", "battery", "esc", "servo_hub", "hardpoint")
    counts = {f"{node}_{cause}": n for node in nodes for cause, n in (("missed", 1), ("strays", 2), ("restarts", 3))}
    labels = [loss.source for loss in told(counts, {})]
    assert len(labels) == 3 * len(nodes)
    assert len({*labels}) == len(labels)
    assert max(map(len, labels)) <= LABEL_WIDTH


def test_of_a_node_with_several_roles_messages_are_told_by_role_and_the_rest_once_for_the_node() -> None:
    counts = {"esc_missed": 20, "node21_bad_crc": 3, "node21_lost_start": 4, "node21_restarts": 2}
    every = {"transfers_bad_crc": 3, "transfers_lost_start": 9}  # five of another node
    assert {loss.source: loss.text for loss in told(counts | every, {"esc": 180})} == {
        "propeller controller": "20 of 200 messages lost (10 %)",
        "node 21": "7 frames or messages dropped",
        "node 21, restarts": "2 times",
        "other nodes of the bus": "5 frames or messages dropped",
    }


def test_when_something_was_lost_is_told_without_the_rounding_of_binary_fractions() -> None:
    logged = SimpleNamespace(losses=[(0.1 + 0.2, {"a": 1}), (60.00000000000001, {"a": 2})])
    assert times(logged) == {"a": [0.3, 60.0]}


def test_no_more_than_ten_lines_tell_of_losses(flown: Path) -> None:
    summary = summarise(read(flown))
    before = len(figures(summary))
    summary["losses"] = {f"gcs_{i}_malformed": i for i in range(1, 16)}
    links = key_figures(summary)["computer and links"]
    assert links[-1] == ("other losses", "and 5 more: see the report")
    assert len([*itertools.chain(*key_figures(summary).values())]) == before + 11


def test_a_zigzag_has_its_figures(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap", 50.0))
    c, t = log.columns, log.columns["t"]
    s = summarise(log)
    names = ("overshoot_first_deg", "overshoot_second_deg", "zigzag_period_s", "turning_diameter_m")
    assert [s[name] for name in names] == [None] * 4
    c["mode.mode"] = np.full(len(t), Mode.MANUAL)
    c["demand.delta_r"] = np.radians(20.0) * np.select([t < 5, t < 15, t < 25, t < 35], [0, 1, -1, 1], -1)
    log.truth["eta.psi"] = np.radians(3.0 - np.interp(t, [5, 15, 17, 27, 28, 50], [0, 20, 26, -20, -24, 0]))
    s = summarise(log)
    assert s["zigzag_period_s"] == pytest.approx(20.0)
    assert s["overshoot_first_deg"] == pytest.approx(6.0)
    assert s["overshoot_second_deg"] == pytest.approx(4.0 + 46.0 / 10.0 * 2.0)
    assert figures(s)["first overshoot"] == "6.0°"


def test_a_log_that_was_cut_off_is_not_completed(flown: Path, tmp_path: Path) -> None:
    data = flown.read_bytes()
    (tmp_path / "log.mcap").write_bytes(data[: len(data) // 2])
    s = summarise(read(tmp_path / "log.mcap"))
    assert not s["completed"]
    assert outcome(s).startswith("not completed: the log is cut off; recovered up to ")
    assert s["speed_up"] is None


def test_a_log_with_damage_in_it_says_what_is_missing_beside_how_the_flight_ended(flown: Path, tmp_path: Path) -> None:
    data = bytearray(flown.read_bytes())
    data[len(data) // 2] ^= 0xFF
    (tmp_path / "log.mcap").write_bytes(data)
    s = summarise(read(tmp_path / "log.mcap"))
    assert (s["completed"], s["complete"], s["cycles"]) == (True, False, 250)
    assert figures(s)["the log is"].startswith("damaged between bytes ")


def test_what_rules_and_the_monitor_of_the_bus_found_is_told_once(flown: Path) -> None:
    leak = event(EventKind.MODE_CHANGED, Cause.LEAK, before=Mode.MISSION, after=Mode.HOLD)
    low = event(EventKind.RULE_WARNS, Cause.BATTERY_WARNING, (0.28, 0.3))
    twice = event(EventKind.NODE_FAULT, numbers=(float(SourceFault.TWO_SENDERS),), names=("pressure",))
    done = event(EventKind.MODE_CHANGED, Cause.MISSION_DONE, before=Mode.MISSION, after=Mode.SURFACE)
    worn = event(EventKind.RULE_WARNS, Cause.ACTUATOR_WORN, (float(ActuatorFault.SLOW),), ("rudder_upper",))
    events = [(1.0, (leak, low)), (2.0, (low, done)), (2.5, (twice, worn))]
    found = findings.findings(events, {"rudder_upper"})
    told = [(one["by"], one["first_s"], one["times"], one["known"]) for one in found]
    assert told == [("rule", 1.0, 1, False), ("rule", 1.0, 2, False), ("bus", 2.5, 1, False), ("rule", 2.5, 1, True)]
    rows = key_figures(summarise(read(flown)) | {"found": found})["found in flight"]
    assert rows[:2] == [
        (
            "by the rules",
            "MISSION -> HOLD: water in the hull (leak_action), at 1.0 s; "
            "battery at 28%, less than 30% (battery_warn_action), at 1.0 s, 2 times; "
            "rudder_upper: too slow (a rule warns: actuator_worn_action), at 2.5 s",
        ),
        ("on the bus", "node pressure: two senders under one node id, at 2.5 s"),
    ]


@pytest.mark.parametrize(
    ("cause", "before", "fault", "name", "key"),
    [
        (Cause.PROPELLER_FAULT, Mode.MISSION, ActuatorFault.JAMMED, "propeller", "propeller_action"),
        (Cause.PROPELLER_FAULT, Mode.MISSION, ActuatorFault.RUNAWAY, "propeller", "runaway_action"),
        (Cause.STATION_LOST, Mode.HOLD, 30.0, "", "station.hold_action"),
        (Cause.STATION_LOST, Mode.MANUAL, 30.0, "", "station.manual_action"),
        (Cause.DVL_BAD, Mode.MISSION, SourceFault.SILENT, "", "dvl_action"),
    ],
)
@pytest.mark.parametrize("kind", [EventKind.MODE_CHANGED, EventKind.RULE_WARNS, EventKind.RULE_HOLDS])
def test_the_key_that_decided_stands_beside_every_rule(
    cause: Cause, before: Mode, fault: float, name: str, key: str, kind: EventKind
) -> None:
    """Of a rule that warns it is that of the mode in which it did, and it is told of a known fault too."""
    names = (name,) if name else ()
    begins = event(EventKind.MODE_CHANGED, Cause.ORDERED, before=Mode.DISARMED, after=before)
    modes = (before, Mode.SURFACE) if kind is EventKind.MODE_CHANGED else (None, None)
    told = event(kind, cause, (float(fault),), names, before=modes[0], after=modes[1])
    (found,) = findings.findings([(1.0, (begins,)), (9.0, (told,))], {"propeller", "dvl"})
    assert found["key"] == key
    ((_, text),) = findings.key_figures([found])
    assert f"{key})" in text


def test_all_that_fall_silent_together_are_told_by_one_rule() -> None:
    """At 5 s two fins, at 5.3 s the propeller; another fin was silent until 3 s alone, and one never was."""
    told = event(EventKind.RULE_WARNS, Cause.ACTUATOR_SILENT, (float(ActuatorFault.SILENT),), ("stern_port",))
    spans = {"stern_port": (5.0, 9.0), "rudder_upper": (5.0, 9.0), "propeller": (5.3, 9.0), "bow": (1.0, 3.0)}
    actuators = {name: Timeline() for name in (*spans, "spare")}
    t = np.arange(0.0, 10.0, 0.1)
    for name, line in actuators.items():
        begin, end = spans.get(name, (0.0, 0.0))
        line.add(t, np.where((t >= begin - 1e-9) & (t < end), int(ActuatorFault.SILENT), 0), 0.1)
    (found,) = findings.findings([(5.1, (told,))], set(spans), actuators)
    assert found["text"] == "stern_port, rudder_upper, propeller: reports nothing valid (a rule warns)"
    assert found["known"]


def test_one_cycle_and_no_order_are_enough(tmp_path: Path, toy: SimpleNamespace) -> None:
    s = summarise(read(toy.fly(tmp_path / "log.mcap", 0.01)))
    assert s["cycles"] == 1
    assert s["depth_tracking_error_rms_m"] is None
    assert s["fin_travel_deg_s"] is None


def test_the_table_shows_what_is_known(flown: Path) -> None:
    summary = summarise(read(flown))
    out = io.StringIO()
    Console(file=out, width=80).print(summary_table(summary))
    for words in ("completed", "vehicle time", "3.0 s", "0 of 3", "°/s"):
        assert words in out.getvalue()
    for judge, words in (("truth", "completed"), ("estimate", "completed, by the vehicle's own estimate")):
        assert outcome({**summary, "judged_by": judge}) == words
    rule = {**summary, "completed": False, "surfaced": True, "reason": "surfaced safely because of a rule: a leak"}
    assert outcome(rule) == "not completed, but surfaced safely because of a rule: a leak"
    reason = "it had not surfaced [/] when the time was over"
    Console(file=out, width=80).print(summary_table({**summary, "completed": False, "reason": reason}))
    assert f"  not completed: {reason}  " in out.getvalue()
    assert figures(summary).keys() - figures({**summary, "speed_up": None}).keys() == {"speed-up"}


def test_every_measuring_source_is_counted_so_that_losses_have_a_share(flown: Path) -> None:
    received, columns = summarise(read(flown))["received"], read(flown).columns
    assert received["hardpoint"] == columns["frame.hardpoint.fresh"].sum()
    assert received.keys() >= {"ahrs", "dvl", "hardpoint"}


def everything(flown: Path) -> Summary:
    """Return a summary in which all is told that ever can be."""
    summary = summarise(read(flown))
    numbers = {key: 123.456 for key, value in summary.items() if value is None and key.endswith(("_m", "_deg", "_s"))}
    law = {"first_s": 1234.5, "adopted_s": 2345.6, "rms_moving_before": 12.345, "rms_moving_after": 10.123}
    one = {"error_before_pct": 400.0, "error_after_pct": -33.4}
    learned = {"M_ds": {"valid": True, "error_pct": -12.3, "error_sigmas": 2.3}}
    fault = {"last": "weak", "stuck_deg": -22.5, "first_s": 83.1, "last_s": 1.0, "faulty_s": 1.0}
    summary |= numbers | {
        "turning_rate_deg_s": 1.0,
        "lateness": {"median_us": 1.0, "p99_us": 2.0, "max_us": 3.0},
        "learned": {"coefficients": learned},
        "adoption": {"laws": {"depth": law, "heading": law}, "coefficients": {"M_ds": one}},
        "limits": {"dive_left_pct": {"end": 28.4}, "turn_left_pct": {"end": 100.0}},
        "losses": {f"{source}_missed": 1 for source in ("battery", "hardpoint", "esc")} | {"dvl_breaks": 3},
        "faults": ["weak:rudder_upper=0@80"] * 4,
        "faults_not_begun": ["jam:stern_starboard=10@800"],
        "after_log": {"why": "the disk is full", "mode": "SURFACE", "depth_m": 2.0},
    }
    summary["health"] = {
        "sensors": {"altitude.2": {"faults_s": {"frozen": 1.0}, "first_s": 1.0, "suspect_s": 2.0, "lost_s": 3.0}},
        "actuators": {"stern_starboard": fault},
        "weight_commanded_s": 12.0,
        "weight_released_s": None,
        "weight_stuck_s": 15.0,
    }
    return summary


def test_no_label_breaks_in_a_terminal_of_80_columns(flown: Path) -> None:
    summary, out = everything(flown), io.StringIO()
    Console(file=out, width=80).print(summary_table(summary))
    lines = [line.strip() for line in out.getvalue().splitlines()]
    labels = [label for rows in key_figures(summary).values() for label, _ in rows]
    assert len(labels) > 35
    for label in labels:
        assert len(label) <= LABEL_WIDTH
        assert any(line.startswith(f"{label} ") for line in lines), label


def test_what_is_asked_first_comes_first(flown: Path) -> None:
    groups = key_figures(everything(flown))
    assert [title.partition(",")[0] for title in groups] == [
        *("end of the flight", "found in flight", "learned", "accuracy", "computer and links")
    ]
    assert [label for label, _ in groups["end of the flight"]][:3] == ["ended", "ended, from the origin", "waypoints"]


def test_where_the_flight_ended_is_told(flown: Path) -> None:
    log = read(flown)
    log.truth["eta.x"], log.truth["eta.y"] = np.full(300, -12.4), np.full(300, 33.6)
    s = summarise(log)
    assert s["ended"] == {"mode": "MISSION", "north_m": -12.4, "east_m": 33.6, "depth_m": log.truth["eta.z"][-1]}
    assert figures(s)["ended, from the origin"] == "12 m south, 34 m east"
    s["ended"] |= {"north_m": -0.4, "east_m": 0.2}
    s["heading_estimate_error_mean_deg"] = -0.004
    assert figures(s)["ended, from the origin"] == "0 m"
    assert figures(s)["heading estimate off, mean"] == "0.00°"


@pytest.mark.parametrize(
    ("mode", "depth", "told"),
    [
        ("SURFACE", -0.04, "in mode SURFACE, at the surface (0.0 m)"),
        ("DISARMED", 0.21, "in mode DISARMED, at the surface (0.2 m)"),
        ("MISSION", 10.0, "in mode MISSION, 10.0 m deep"),
    ],
)
def test_a_vehicle_ends_in_a_mode_at_the_surface_or_so_deep(flown: Path, mode: str, depth: float, told: str) -> None:
    summary = summarise(read(flown))
    summary["ended"] |= {"mode": mode, "depth_m": depth}
    assert figures(summary)["ended"] == told


def test_errors_before_and_after_learning_say_which_is_which(flown: Path) -> None:
    rows = dict(key_figures(everything(flown))["learned, while logged"])
    assert rows["depth error in dives (RMS)"] == "12.345 m before all was learned, 10.123 m after"
    assert rows["heading error in turns (RMS)"] == "12.35° before all was learned, 10.12° after"


@pytest.mark.parametrize(
    ("off", "told"), [(-168.7, "-169 %"), (99.6, "+100 %"), (-12.3, "-12 %"), (9.96, "+10 %"), (-4.53, "-4.5 %")]
)
def test_an_error_of_any_size_is_told_without_an_exponent(flown: Path, off: float, told: str) -> None:
    summary = everything(flown)
    summary["learned"]["coefficients"]["M_ds"]["error_pct"] = off
    assert figures(summary)["worst valid coefficient"] == f"M_ds {told} (2.3 σ)"


def test_an_altimeter_that_was_not_believed_is_called_so(flown: Path) -> None:
    assert "altimeter.2 not believed" in figures(everything(flown))


def test_how_sure_it_was_of_its_place_is_told(flown: Path) -> None:
    log = read(flown)
    log.columns["state.position_std"] = np.full(300, 1.5)
    s = summarise(log)
    assert figures(s)["position 3 σ at the end"] == "4.50 m"


def test_an_error_of_the_position_before_the_first_fix_is_told_apart(tmp_path: Path, toy: SimpleNamespace) -> None:
    """It begins 500 m off, as what it kept of an earlier flight says; the fix at 0.5 s is not taken, that at 1 s is."""
    log, k = read(toy.fly(tmp_path / "log.mcap")), np.arange(300)
    log.columns["state.eta.x"] = log.truth["eta.x"] + np.where(k < 100, 500.0, 2.0)
    log.columns["state.eta.y"] = log.truth["eta.y"] + 0.0
    log.columns["state.position_std"] = np.where(k < 100, 100.0, 3.0) + 0.001 * k
    s = summarise(log)
    assert (s["first_fix_s"], s["navigation_error_before_fix_m"]) == (None, None)
    assert figures(s)["position estimate off"] == "2.00 m at the end, 500.00 m at most"
    assert "position off before a first fix" not in figures(s)
    log.columns["frame.fix.fresh"] = np.isin(k, (50, 100, 200))
    s = summarise(log)
    assert (s["first_fix_s"], s["navigation_error_before_fix_m"]) == (1.0, pytest.approx(500.0))
    assert figures(s)["position estimate off"] == "2.00 m at the end, 2.00 m at most"
    assert figures(s)["position off before a first fix"] == "500.00 m at most, until 1.0 s"
    log.columns["state.eta.x"] = log.truth["eta.x"] + np.where(k < 100, 1.0, 2.0)
    assert "position off before a first fix" not in figures(summarise(log)), "it was further off later on"


def test_a_heading_that_the_estimate_has_wrong_is_told_apart_from_one_that_is_steered_wrong(flown: Path) -> None:
    log = read(flown)
    log.columns["state.eta.psi"] = log.truth["eta.psi"] + math.radians(0.3)
    log.columns["reference.psi_d"] = log.truth["eta.psi"] + math.radians(0.2)
    s = summarise(log)
    assert s["heading_estimate_error_mean_deg"] == pytest.approx(0.3)
    assert s["heading_tracking_error_rms_deg"] == pytest.approx(0.2)


def test_scenario_and_seed_stand_in_it_beside_what_was_set(tmp_path: Path, toy: SimpleNamespace) -> None:
    settings = {"truth.current_m_s": 0.3}
    summary = summarise(read(toy.fly(tmp_path / "log.mcap", settings=settings)))
    assert (summary["scenario"], summary["seed"], summary["settings"]) == ("toy", 1, settings)
