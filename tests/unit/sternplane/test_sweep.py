"""What a sweep varies, which flights it has, and what it says of them."""

from __future__ import annotations

import json
import math
import random
import re
import time
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO

import numpy as np
import pytest
from sternplane.campaign.files import write
from sternplane.cli.main import main
from sternplane.sitl.flight import FlightRequest, prepare
from sternplane.sweep.accused import accused, text_of
from sternplane.sweep.axes import Axis, axis_of, parse_axis
from sternplane.sweep.explain import spearman
from sternplane.sweep.laws import equal, unsteered
from sternplane.sweep.page import page
from sternplane.sweep.plan import LAW, Flights, Plan, laws_of, read_plan, refuse_other
from sternplane.sweep.plots import distributions
from sternplane.sweep.sampling import grid, latin_hypercube
from sternplane.sweep.table import parquet
from sternplane.sweep.worst import USEFUL, judged_by, outcome_text, refuse_unknown, worst

from firmware_py.adapters.installation import configs
from firmware_py.adapters.own_parts import hand_in
from firmware_py.own_parts import KINDS
from firmware_py.params import ParamError, param
from firmware_py.run.usage_error import UsageError


@dataclass(frozen=True)
class Gain:
    k: float = param(4.0, low=0.0, high=20.0, doc="Gain.")
    a: float = param(10.0, unit="deg", low=0.0, high=20.0, doc="Angle.")


@pytest.fixture(scope="module")
def demo():
    return prepare(FlightRequest("demo"), {})


def test_what_is_relative_is_so_to_what_flies(demo) -> None:
    axis = parse_axis("vehicle.M_q=±20%", demo)
    assert axis.key == "vehicle.coefficients.M_q"
    believed = 0.6 * -0.068  # the scenario's factor times the file
    assert (axis.low, axis.high) == pytest.approx((1.2 * believed, 0.8 * believed))
    assert parse_axis("vehicle.M_q=+-20%", demo) == axis
    assert parse_axis("truth.M_q=±0.01", demo)[:3] == pytest.approx(("truth.coefficients.M_q", -0.078, -0.058))
    assert parse_axis("truth.current=±50%", demo)[:3] == pytest.approx(("truth.current_m_s", 0.05, 0.15))
    assert parse_axis("truth.current=0..0.3", demo)[1:3] == (0.0, 0.3)
    assert parse_axis("sensors.dvl.rate=2..8", demo).whole
    assert parse_axis("autopilot.control.law=sliding,pid", demo).choices == ("sliding", "pid")
    assert parse_axis("truth.current_ned=[0,0.1,0],[0.1,0,0]", demo).choices == ((0, 0.1, 0), (0.1, 0, 0))
    assert parse_axis('vehicle.name="2020-01-01","b"', demo).choices == ("2020-01-01", "b")
    names = parse_axis('autopilot.estimation.coefficients.names=["M_q"],["M_q","M_ds"]', demo)
    assert names.choices == (("M_q",), ("M_q", "M_ds"))


def test_what_parts_of_ones_own_declare_is_known_of_every_kind_and_what_is_set_goes_before(demo) -> None:
    named = {kind.key: hand_in(type(f"Own_{part}", (kind.base,), {"Params": Gain})) for part, kind in KINDS.items()}
    chosen = tuple([f"autopilot.{key}={name}" for key, name in named.items()])
    flight = prepare(FlightRequest("demo", settings=(*chosen, "autopilot.guidance.own.k=2")), {})
    for table, now in (("control", 4.0), ("estimation", 4.0), ("guidance", 2.0)):
        axis = parse_axis(f"autopilot.{table}.own.k=±50%", flight)
        assert (axis.low, axis.high) == (0.5 * now, 1.5 * now)
    assert math.isclose(parse_axis("autopilot.guidance.own.a_deg=±50%", flight).high, 15.0)
    with pytest.raises(ParamError, match="has no value as it stands"):
        parse_axis("autopilot.guidance.own.other=±50%", flight)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("vehicle.M_q", "write KEY=VALUES"),
        ("vehicle.Mq=±20%", r"did you mean vehicle.coefficients.M_q\?"),
        ("vehicle.K_prop=±20%", "is 0 as it stands, so that nothing varies"),
        ("autopilot.control.law=±20%", "is no number but 'sliding'"),
        ("truth.current=0.3..0", "LOW below HIGH"),
        ("truth.current=log:0..0.3", "above 0 behind log:"),
        ("truth.current=0.3", "one value does not vary"),
        ("truth.current=0.3,0.3", "one value does not vary"),
        ("truth.current=nan..1", "write LOW..HIGH with two numbers"),
        ("truth.current=0..0.1..0.2", "write LOW..HIGH with two numbers"),
        ("truth.current={a=1},{a=2}", "values must be numbers, texts, or lists of these"),
        ("truth.current_ned=[[1]],[[2]]", "values must be numbers, texts, or lists of these"),
        (
            "vehicle.name=2020-01-01,2021-01-01",
            "2020-01-01 is a date or time, which no key takes; a text of it needs quotes",
        ),
        ("vehicle.name=[07:30:00],[1]", "07:30:00 is a date or time"),
        ("sensors.dvl.rate=±1%", "the values are whole numbers, here all 5; write a wider range"),
        ("sensors.dvl.rate=1.2..1.4", "the values are whole numbers, here all 1; write a wider range"),
        ("scenario.zigzag.heading=±10%", "has no value as it stands; write LOW..HIGH, or a,b,c"),
        ("vehicle.nosuch=1..2", "^--vary vehicle.nosuch: is unknown"),
        ("truth.current=0..1e999", "LOW below HIGH"),
        ("truth.current=0.2..0.2", "LOW below HIGH"),
        ("vehicle.M_q=±0%", "nothing varies"),
        ("vehicle.M_q=±1e999%", "beyond every number"),
        ("vehicle.M_q=±nan%", "one value does not vary"),
    ],
)
def test_what_cannot_be_varied_is_told(text: str, said: str, demo) -> None:
    with pytest.raises(ParamError, match=said):
        parse_axis(text, demo)


def test_each_part_of_each_range_has_one_sample_and_the_seed_decides_which() -> None:
    n, axes = 40, [Axis("a", -2.0, 2.0), Axis("b", 0.01, 1.0, log=True), Axis("c", choices=("x", "y", "z", "w"))]
    samples = list(latin_hypercube(n, axes, seed=5))
    a, b, c = zip(*samples, strict=True)
    assert sorted(math.floor(n * (value + 2.0) / 4.0) for value in a) == list(range(n))
    assert sorted(math.floor(n * (math.log(value) - math.log(0.01)) / math.log(100.0)) for value in b) == list(range(n))
    assert {value: c.count(value) for value in c} == dict.fromkeys("xyzw", 10)
    assert samples == list(latin_hypercube(n, axes, seed=5)) != list(latin_hypercube(n, axes, seed=6))
    assert abs(spearman(np.array(a), np.array(b))) < 0.6


def test_whole_numbers_are_drawn_evenly_and_stay_in_their_parts() -> None:
    axes = [Axis("n", 1.0, 3.0, whole=True), Axis("m", 1.6, 4.4, whole=True), Axis("z", -1.0, 1.0, whole=True)]
    drawn = zip(*latin_hypercube(300, axes, 5), strict=True)
    for values, expected in zip(drawn, ((1, 2, 3), (2, 3, 4), (-1, 0, 1)), strict=True):
        assert {value: values.count(value) for value in values} == dict.fromkeys(expected, 100)
    for axis in (*axes, Axis("log", 1.0, 100.0, log=True, whole=True), Axis("0", 0.3, 5.0, log=True, whole=True)):
        shown = [axis.at(i / 1000) for i in range(1001)]
        assert shown == sorted(shown)
        assert (shown[0], shown[-1]) == (round(axis.low), round(axis.high))
    count = [axes[0].at((i + 0.5) / 30) for i in range(30)].count
    assert [count(k) for k in (1, 2, 3)] == [10, 10, 10]
    decades = [Axis("log", 1.0, 100.0, log=True, whole=True).at((i + 0.5) / 3000) for i in range(3000)]
    assert decades.count(1) / decades.count(10) == pytest.approx(math.log(3.0) / math.log(10.5 / 9.5), rel=0.05)


def test_a_grid_has_every_combination_from_end_to_end() -> None:
    axes = [Axis("a", 0.0, 1.0), Axis("n", 1.0, 4.0, whole=True), Axis("c", choices=("x", "y"))]
    found = list(grid(3, axes))
    assert (found[0], found[-1], len(found)) == ((0.0, 1, "x"), (1.0, 4, "y"), 18)
    assert len(set(found)) == 18


def test_a_grid_that_is_too_large_is_refused_before_it_is_made() -> None:
    began = time.monotonic()
    with pytest.raises(UsageError, match=r"^20,000,000 flights: at most 10,000,000"):
        Flights(plan(n=0, grid=5_000_000), "pid")
    assert time.monotonic() - began < 0.5
    whole = Axis("n", 1.6, 4.4, whole=True)
    assert whole.most(10**12) == len(whole.grid(100)) == 3
    assert whole.most(2) == len(whole.grid(2)) == 2


def plan(**other) -> Plan:
    axes = (Axis("vehicle.coefficients.M_q", -0.08, -0.05), Axis("truth.current_m_s", choices=(0.0, 0.3)))
    usual = {"n": 5, "grid": 0, "seed": 7, "seeds": None, "laws": ("sliding", "pid"), "settings": (), "faults": ()}
    return Plan(**{"scenario": "demo", "axes": axes, **usual, **other})


def test_laws_fly_the_same_samples_with_the_same_noise() -> None:
    flights = Flights(plan(), "sliding")
    jobs = [flights.job(k) for k in range(len(flights))]
    assert [(job.sample, job.seed, job.law) for job in jobs[:4]] == [
        *((0, 7, "sliding"), (0, 7, "pid")),
        *((1, 8, "sliding"), (1, 8, "pid")),
    ]
    assert all(jobs[k].values == jobs[k + 1].values for k in range(0, 10, 2))
    assert jobs[1].settings[0] == f"{LAW}=pid"
    seeded = Flights(plan(seeds=(3, 5), laws=()), "pid")
    assert [(job.sample, job.seed, job.law) for job in map(seeded.job, range(3))] == [
        *((0, 3, "pid"), (0, 4, "pid"), (1, 3, "pid")),
    ]


def test_a_flight_has_to_the_last_bit_the_values_of_its_row() -> None:
    job = Flights(plan(), "sliding").job(4)
    flown = prepare(FlightRequest("demo", seed=job.seed, settings=job.settings), {})
    assert flown.vehicle.coefficients.M_q == job.values["vehicle.coefficients.M_q"]
    assert flown.header()["settings"]["truth.current_m_s"] == job.values["truth.current_m_s"]
    texts = (Axis("autopilot.estimation.coefficients.names", choices=(("M_q",),)), Axis("vehicle.name", choices=("1",)))
    job = Flights(plan(axes=texts), "sliding").job(4)
    flown = prepare(FlightRequest("demo", seed=job.seed, settings=job.settings), {})
    assert (flown.params.estimation.coefficients.names, flown.vehicle.name) == (("M_q",), "1")


def test_a_plan_comes_back_from_its_file_and_another_is_refused(tmp_path) -> None:
    path, mine = tmp_path / "sweep.json", plan(seeds=(0, 2), settings=("vehicle.M_w=0.1",))
    write(path, json.dumps({"plan": mine.plain(), "law": "pid", "samples": mine.scenario}))
    assert read_plan(path)[0] == mine
    assert axis_of(mine.axes[1].plain()) == mine.axes[1]
    lists = Axis("autopilot.estimation.coefficients.names", choices=(("M_q",), ("M_q", "M_ds")))
    assert axis_of(json.loads(json.dumps(lists.plain()))) == lists
    refuse_other(mine, mine, tmp_path)
    with pytest.raises(UsageError, match=r"another --n, 5, here 6; choose another --out"):
        refuse_other(mine, mine._replace(n=6), tmp_path)
    with pytest.raises(UsageError, match=r"another --law, none, here sliding, pid; choose another --out"):
        refuse_other(mine._replace(laws=()), mine, tmp_path)
    path.write_text("{}")
    with pytest.raises(UsageError, match="is no plan of a sweep"):
        read_plan(path)
    with pytest.raises(UsageError, match="at most 10,000,000"):
        Flights(plan(n=6_000_000), "pid")
    with pytest.raises(ParamError, match="each once"):
        laws_of("pid,pid")


def row(flight: int, completed: bool = True, error: str = "", **other) -> dict:
    return {"key": str(flight), "flight": flight, "sample": flight, "completed": completed, "error": error, **other}


@pytest.mark.parametrize(
    ("of_the_plan", "beside"),
    [
        ({"n": "5"}, {}),
        ({"n": -5}, {}),
        ({"n": 0}, {}),
        ({"n": math.inf}, {}),
        ({"seed": 1.5}, {}),
        ({"seeds": [0]}, {}),
        ({"seeds": ["a", "b"]}, {}),
        ({"seeds": [2, 0]}, {}),
        ({"axes": [], "laws": ["pid"]}, {}),
        ({"axes": [{"key": "x"}]}, {}),
        ({"axes": [{"key": 3, "low": 0.0, "high": 1.0}]}, {}),
        ({"axes": [{"key": "x", "low": "a", "high": []}]}, {}),
        ({"axes": [{"key": "x", "low": 0.0, "high": 1.0, "log": True}]}, {}),
        ({"settings": [3]}, {}),
        ({}, {"law": None}),
        ({}, {"samples": None}),
    ],
)
def test_a_plan_that_somebody_has_spoilt_is_refused(of_the_plan: dict, beside: dict, tmp_path) -> None:
    path = tmp_path / "sweep.json"
    path.write_text(json.dumps({"law": "pid", "samples": "x", **beside, "plan": {**plan().plain(), **of_the_plan}}))
    with pytest.raises(UsageError, match=r"sweep\.json: is no plan of a sweep; choose another --out"):
        read_plan(path)


def test_the_table_is_the_same_in_whatever_order_flights_came() -> None:
    pytest.importorskip("pyarrow")
    import io

    import pyarrow.parquet as pq

    rows = [row(k, bool(k % 2), seed=k, law="pid", x=0.1 * k, m=None if k < 3 else 2.0) for k in range(20)]
    rows[5]["late"], rows[7]["late"] = 1, 2.5
    mixed = rows[:]
    random.Random(1).shuffle(mixed)
    content = parquet(rows, {"n": 20})
    assert parquet(mixed, {"n": 20}) == content
    table = pq.read_table(io.BytesIO(content))
    assert table.column("flight").to_pylist() == list(range(20))
    assert table.column("x").to_pylist() == [0.1 * k for k in range(20)]
    assert table.column("late").to_pylist()[4:9] == [None, 1.0, None, 2.5, None]
    assert "key" not in table.column_names


def test_errors_are_the_worst_then_failures_then_the_greatest_figure() -> None:
    rows = [
        row(0, path_error_rms_m=9.0),
        row(1, False, path_error_rms_m=1.0, surfaced=False, reason="aground"),
        row(2, False, path_error_rms_m=5.0, surfaced=True, reason="leak"),
        row(3, False, error="ParamError: x"),
        row(4, path_error_rms_m=11.0),
        row(5, False, path_error_rms_m=2.0, surfaced=False, reason="aground"),
    ]
    judge = judged_by(rows, None)
    assert judge == "path_error_rms_m"
    assert [one["flight"] for one in worst(rows, judge, 6)] == [3, 5, 1, 2, 4, 0]
    assert [one["flight"] for one in worst(rows, judge, 1)] == [3, 5]
    assert outcome_text(rows[2]) == "came up: leak"
    with pytest.raises(UsageError, match="--judge depth: no flight has such a number; such as path_error_rms_m; "):
        judged_by(rows, "depth")


@pytest.mark.parametrize("wanted", [None, "path_error_rms_m", "navigation_error_max_m", "adoption.laws.depth.rms"])
def test_a_column_that_another_flight_may_have_is_waited_for(wanted: str | None) -> None:
    refuse_unknown([row(0, path_error_rms_m=9.0, navigation_error_max_m=None, adoption=None)], wanted)
    refuse_unknown([row(0, error="ParamError: x")], "any")


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        ("path_eror_rms", r"did you mean path_error_rms_m\?"),
        ("reason", "no flight has such a number"),
        ("limits.dive.typo", "no flight has such a number"),
        ("path_error_rms_m.worst", r"did you mean path_error_rms_m\?"),
    ],
)
def test_a_column_that_no_flight_can_have_is_refused_with_what_is_meant(wanted: str, said: str) -> None:
    with pytest.raises(UsageError, match=f"^--judge {wanted}: .*{said}"):
        refuse_unknown([row(0, path_error_rms_m=9.0, reason="aground")], wanted)


def test_what_flights_said_to_be_at_fault_is_told_by_flight() -> None:
    rows = [
        row(0, **{"health.actuators.rudder_upper.faulty_s": 3.0, "found": "depth over the limit"}),
        row(1, **{"health.sensors.pressure.1.suspect_s": 0.0, "health.sensors.pressure.1.lost_s": 0.4}),
        row(2, **{"health.actuators.rudder_upper.faulty_s": 1.0, "health.actuators.propeller.faulty_s": None}),
        row(3, False, "ParamError: x"),
    ]
    assert [text_of(one) for one in accused(rows)] == [
        "said to be damaged: rudder_upper in 2 flights (0, 2)",
        "not believed: pressure.1 in 1 flight (1)",
        "found by the rules: depth over the limit in 1 flight (0)",
    ]
    assert accused([row(0)]) == []


def test_the_page_says_in_how_many_flights_an_actuator_was_said_to_be_damaged(tmp_path) -> None:
    flights = Flights(plan(laws=()), "pid")
    rows = [row(k, law="pid", seed=k, **flights.job(k).values) for k in range(5)]
    assert "Said to be at fault" not in page(flights, rows, "", tmp_path, 1)
    rows[3]["health.actuators.rudder_upper.faulty_s"] = rows[4]["health.actuators.propeller.faulty_s"] = 2.0
    text = page(flights, rows, "", tmp_path, 1)
    assert "Said to be at fault" in text
    assert "rudder_upper" in text
    assert re.search(r"with an actuator said to be damaged<[^0-9]*>2<", text)


def test_links_and_command_of_a_worst_flight_stand_before_what_may_be_wide(tmp_path) -> None:
    """With three keys they lay beyond the edge of the page."""
    flights = Flights(plan(laws=()), "pid")
    rows = [row(k, law="pid", seed=k, **flights.job(k).values) for k in range(5)]
    (tmp_path / "worst" / "000000").mkdir(parents=True)
    (tmp_path / "worst" / "000000" / "log.mcap").touch()
    text = page(flights, rows, "", tmp_path, 1)
    line = text[text.index("--again FLIGHT") :]
    places = [line.index(word) for word in ('href="worst/000000/log.mcap"', ">--again 0<", ">completed<", "-0.0")]
    assert places == sorted(places)
    assert "vehicle.<wbr>coefficients.<wbr>M_<wbr>q" in line


@pytest.mark.parametrize(
    ("n", "said"), [(7, "there are 7 samples; of fewer than 8 nothing is said"), (8, "it is the same in all samples")]
)
def test_too_few_samples_are_told_with_the_least_number(n: int, said: str, tmp_path) -> None:
    flights = Flights(plan(n=n, laws=()), "pid")
    rows = [row(k, law="pid", seed=k, **flights.job(k).values) for k in range(n)]
    text = page(flights, rows, "", tmp_path, 1)
    assert f"failure: {said}" in text
    assert ("too few samples: at least 8" in text) is (n < 8)
    assert ("may be chance" in text) is (n >= 8)


def test_the_help_names_the_columns_that_people_judge_by() -> None:
    with redirect_stdout(StringIO()) as said, pytest.raises(SystemExit):
        main(["sweep", "--help"])
    assert [name for name in USEFUL if name not in said.getvalue()] == []


@pytest.mark.parametrize(("scenario", "steers"), [("zigzag", False), ("demo", True), ("station", True)])
def test_a_scenario_in_which_no_law_steers_is_told_before_it_is_flown(scenario: str, steers: bool) -> None:
    files = {"scenario.toml": (configs() / "scenarios" / f"{scenario}.toml").read_bytes()}
    said = unsteered(files, "scenario.toml", scenario)
    assert said == "" if steers else said.startswith("zigzag: no order leaves MANUAL, where no law steers")


def test_laws_that_came_out_equal_are_told_and_figures_of_hand_steering_stand_beside_them(tmp_path) -> None:
    each = [{"sample": k // 2, "seed": k // 2, "law": ("sliding", "pid")[k % 2], LAW: k % 2} for k in range(4)]
    rows = [row(k, **{**own, "overshoot_first_deg": 8.25 + own["sample"]}) for k, own in enumerate(each)]
    assert equal(rows).startswith("All laws came out equal")
    keys = {axis.key: 0.0 for axis in plan().axes}
    text = page(Flights(plan(n=2), "sliding"), [{**one, **keys} for one in rows], "", tmp_path, 1)
    assert "All laws came out equal" in text
    assert "median overshoot_first_deg" in text
    assert "median path_error_rms_m" not in text
    assert equal([*rows[:3], {**rows[3], "overshoot_first_deg": 8.0}]) == ""
    assert equal([one for one in rows if one["law"] == "pid"]) == ""


def test_laws_stand_beside_each_other_in_a_histogram() -> None:
    """Laid over each other, half transparent, two laws made a third colour."""
    rows = [
        {"law": law, "completed": True, "path_error_rms_m": 0.1 * i + off}
        for law, off in (("sliding", 0.0), ("pid", 0.3))
        for i in range(8)
    ]
    [plot] = distributions(rows, "path_error_rms_m")
    assert plot.figure.layout.barmode == "group"
    assert [(bars.name, bars.opacity) for bars in plot.figure.data] == [("sliding", None), ("pid", None)]
    assert plot.figure.data[0].xbins == plot.figure.data[1].xbins
