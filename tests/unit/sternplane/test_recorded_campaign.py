"""The flights of the safety campaign that are recorded, held to the trials and judged by the judge as they are now."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import pytest
from sternplane.study import safety as study
from sternplane.study.safety.campaign import SEEDS, TRIALS, jobs
from sternplane.study.safety.flight_list import cell_anchor
from sternplane.study.safety.judge import Ending
from sternplane.study.safety.page import page
from sternplane.study.safety.verdict import SHARE, WRONG, Verdict, judge, rows

FLIGHTS = Path(__file__).parents[2] / "recorded" / "safety" / "flights.jsonl"
README = Path(study.__file__).parent / "README.md"
_NAMED = "something sound is named, %: "
MISSED = {
    "named, %: X tail: lost:upper_port": 91.7,
    "a rule ends the mission, %: drift:dvl.u=0.03": 8.3,
    f"{_NAMED}drift:dvl.u=0.03": 8.3,
    f"{_NAMED}blocked pressure port": 12.5,
    f"{_NAMED}freeze:altimeter over a ridge": 12.5,
    f"{_NAMED}off:servo_hub": 8.3,
    f"{_NAMED}off:esc": 8.3,
    f"{_NAMED}stuck:weight, off:esc": 12.5,
    f"{_NAMED}silent:hardpoint, off:esc": 12.5,
    f"{_NAMED}set:current.north=-1": 8.3,
    f"{_NAMED}ballast:weight=1.5": 12.5,
    f"{_NAMED}set:current.north=1.2, stuck:weight, set:leak=100": 16.7,
    f"{_NAMED}X tail: off:dvl": 8.3,
    f"{_NAMED}X tail: lost:upper_port": 8.3,
}
"""What the recorded flights miss, %: of trials of 8, 16 or 24 flights, where 95 and 5 % are asked for."""
JOBS = {job.key: job for job in jobs(range(1000, 1000 + SEEDS), short=False)}


@pytest.fixture(scope="module")
def flights() -> list[dict]:
    return [json.loads(line) for line in FLIGHTS.read_text(encoding="utf-8").splitlines()]


@pytest.fixture(scope="module")
def verdicts(flights) -> list[Verdict]:
    return [judge(flight) for flight in flights if flight["trial"]]


def test_each_recorded_flight_is_one_of_the_campaign_and_recorded_once(flights):
    assert len({flight["key"] for flight in flights}) == len(flights) > 100
    for flight in flights:
        job = JOBS[flight["key"]]
        made = flight["trial"], flight["onset"], flight["seed"], flight["eddies"], flight["learning"]
        assert made == (job.trial, job.onset, job.seed, job.eddies, job.learning)


def test_no_recorded_flight_is_unsafe_or_commands_what_is_no_number(flights, verdicts):
    assert not [verdict.flight["key"] for verdict in verdicts if verdict.unsafe]
    assert not [flight["key"] for flight in flights if flight["found"]["not_finite"]]
    assert not [verdict.flight["key"] for verdict in verdicts if verdict.early]


def test_recorded_replays_are_equal(flights):
    assert {flight["replay"] for flight in flights} <= {"", "equal"}


def test_faults_are_named_and_little_is_done_without_cause(verdicts):
    """Of all recorded flights; of each trial alone a complete campaign asks the same."""
    wanted = [verdict.in_time for verdict in verdicts if verdict.trial.named]
    assert 100.0 * sum(wanted) >= SHARE * len(wanted)
    assert 100.0 * sum(verdict.wrong for verdict in verdicts) <= WRONG * len(verdicts)


def test_the_campaign_is_complete_and_misses_what_its_readme_tells_and_no_more(flights):
    """A target that is met again leaves `MISSED`, and the table of the study's README."""
    assert {flight["key"] for flight in flights} == set(JOBS)
    missed = {row.figure: row.value for row in rows(flights) if row.ok is False}
    assert {figure: round(value, 1) for figure, value in missed.items()} == MISSED
    told = README.read_text(encoding="utf-8").split("The missed ones", 1)[1].split("**The flight**", 1)[0]
    trials = {figure.split(", %: ", 1)[1] for figure in missed}
    assert [trial for trial in trials if f"`{trial}`" not in told] == []


def test_the_page_of_the_recorded_campaign_has_each_flight_behind_a_number(flights):
    html = page(flights, rows(flights), ["recorded"], [])
    there = Counter(re.findall(r'id="([^"]+)"', html))
    led_to = set(re.findall(r'href="#([^"]+)"', html))
    assert set(there.values()) == {1}
    assert led_to <= set(there)
    for flight in flights:
        if trial := TRIALS.get(flight["trial"]):
            assert cell_anchor(trial, Ending(flight["ending"]), flight["onset"]) in led_to
    assert html.count(" --seeds ") >= sum(bool(flight["trial"]) for flight in flights)


def test_the_matrix_has_a_width_for_each_column_and_together_that_of_the_page(flights):
    html = page(flights, rows(flights), ["recorded"], [])
    shares = [float(share) for share in re.findall(r'<col style="width: ([\d.]+)%">', html)]
    cells = re.search(r'<tr id="off_ahrs">.*?</tr>', html, re.DOTALL)[0].count("<td")
    assert len(shares) == cells
    assert sum(shares) == pytest.approx(100.0)
