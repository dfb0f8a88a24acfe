"""Rivals, damage, steps and straight lines of the adaptation study: what is flown, and that targets can be missed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from sternplane.study.adaptation import other_wrong, rivals, steps, straight
from sternplane.study.adaptation.courses import halved, slow_turns, track
from sternplane.study.adaptation.flight import Errors
from sternplane.study.adaptation.rivals import ADAPTIVE, FIXED, ORACLE, PID, SHIPPED_PID
from sternplane.study.cases.honesty import signs
from sternplane.study.rows import RunArrays
from sternplane.study.setups import CONFIG, FINS
from sternplane.study.wrong_vehicle import overlay

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.estimation.coefficient_params import TEN
from sim_bridge.scenarios import Scenario, load_scenario


def loaded(folder: Path, text: str) -> Scenario:
    path = folder / "scenario.toml"
    path.write_text(text, encoding="utf-8")
    return load_scenario(str(path), folder)


def test_all_fins_lose_half_of_their_force_and_turns_are_slow(tmp_path: Path) -> None:
    course = slow_turns(halved(track()))
    scenario = loaded(tmp_path, course.scenario.format(adoption="true"))
    assert {fault.target for fault in scenario.injected} == set(FINS)
    assert {(fault.kind.name, fault.value, fault.t) for fault in scenario.injected} == {("weak", 0.5, 60.0)}
    assert set(FINS) == {fin["name"] for fin in read_toml(CONFIG / "truth.toml")["fins"]}
    assert scenario.autopilot["guidance"] == {"turn_rate_max_deg_s": 2.0}
    assert scenario.autopilot["control"] == {"adoption": {"enabled": True}}
    assert course.settled == 90.0


def test_a_rivals_gains_are_laid_over_the_configuration(tmp_path: Path) -> None:
    scenario = loaded(tmp_path, track().scenario.format(adoption="false") + rivals.gains(PID.gains))
    control = scenario.autopilot["control"]
    assert control["law"] == "pid"
    assert control["adoption"] == {"enabled": False}
    assert set(control) == {"law", "adoption", "depth_pid", "heading_pid"}


def test_every_rival_has_gains_of_the_law_that_it_is_named_for() -> None:
    for rival in rivals.ALL:
        assert ('law = "pid"' in rivals.gains(rival.gains)) == ("PID" in rival.name)


def run(depth: dict[str, float], failed: float = 0.0) -> RunArrays:
    """Return a run in which these rivals have these depth errors, and all others 1."""
    return {
        rival.name: np.array([failed * (rival is ADAPTIVE), depth.get(rival.name, 1.0), 1.0, 6.0])
        for rival in rivals.ALL
    }


@pytest.mark.parametrize(
    ("name", "depth", "missed"),
    [
        ("rivals, coefficients 50 % wrong", {PID.name: 2.0, SHIPPED_PID.name: 2.0}, 0),
        ("rivals, coefficients 50 % wrong", {PID.name: 1.4, SHIPPED_PID.name: 2.0}, 1),
        ("rivals, coefficients 50 % wrong", {PID.name: 1.0, SHIPPED_PID.name: 2.0}, 2),
        ("rivals, fins halved", {PID.name: 2.1}, 0),
        ("rivals, fins halved", {PID.name: 1.9}, 1),
        ("fins halved", {FIXED.name: 5.0}, 0),
        ("fins halved", {FIXED.name: 3.0}, 1),
        ("fins halved", {FIXED.name: 5.0, ORACLE.name: 0.8}, 2),
        ("fins halved", {FIXED.name: math.nan}, 1),
    ],
)
def test_an_adaptive_law_that_is_not_so_much_better_misses_its_target(
    name: str, depth: dict[str, float], missed: int
) -> None:
    case = next(case for case in rivals.CASES if case.name == name)
    flights = 3 * [run(depth)]
    assert sum(row.ok is False for row in case.evaluate(flights).rows) == missed
    assert sum(row.ok is False for row in case.evaluate([*flights, run(depth, failed=1.0)]).rows) == missed + 1
    assert not case.evaluate([]).rows


def test_one_flight_with_halved_fins_is_held_to_the_oracle_and_to_no_median() -> None:
    case = next(case for case in rivals.CASES if case.name == "fins halved")
    for depth, missed in (({FIXED.name: 3.0}, 0), ({FIXED.name: 5.0, ORACLE.name: 0.8}, 1)):
        assert sum(row.ok is False for row in case.evaluate([run(depth)]).rows) == missed


def test_rivals_are_compared_median_by_median_and_worst_by_worst() -> None:
    """A flight in which the rival is the better one is told, and is no miss where the rival's others are worse."""
    case = next(case for case in rivals.CASES if case.name == "rivals, coefficients 50 % wrong")
    depths = ((0.5, 1.0, 1.0), (0.5, 1.0, 1.0), (1.2, 0.8, 2.0))
    flights = [run({ADAPTIVE.name: ours, PID.name: pid, SHIPPED_PID.name: shipped}) for ours, pid, shipped in depths]
    rows = {row.figure: row for row in case.evaluate(flights).rows}
    name = "adaptive: depth RMS over PID of equal travel"
    assert rows[f"{name}, flight by flight, worst"].value == pytest.approx(1.5)
    assert rows[f"{name}, median"].value == pytest.approx(0.5)
    assert rows[f"{name}, worst"].value == pytest.approx(1.2)
    assert not rows[f"{name}, worst"].ok
    assert rows["adaptive: depth RMS over PID as shipped, worst"].ok


@pytest.mark.parametrize("step", ["depth", "path"])
def test_a_manoeuvre_teaches_before_the_papers_step_where_laws_are_to_have_learned(step: str, tmp_path: Path) -> None:
    learned = loaded(tmp_path, steps.scenario(step, "learned"))
    assert type(learned.mission.items[0]).__name__ == "Manoeuvre"
    assert learned.autopilot["control"] == {"gains": "paper"}
    assert learned.sensors["pressure"] == {"noise_pa": 0.0, "bias_pa": 0.0}
    assert "gyro_noise_deg_s" not in learned.sensors["ahrs"]
    first = loaded(tmp_path, steps.scenario(step, "true"))
    assert first.autopilot["control"] == {"gains": "paper", "adoption": {"enabled": False}}
    assert first.duration == 130.0


def test_a_step_that_takes_long_or_goes_over_misses_its_target_where_laws_know_enough() -> None:
    def flown(knows: int, settling: float, overshoot: float) -> RunArrays:
        figures = np.array([20.0, settling, 1.0, overshoot])
        return {"knows": np.array(knows), "depth": figures, "path": np.array([20.0, 20.0, 1.0, 1.0])}

    def missed(*runs: RunArrays) -> int:
        return sum(row.ok is False for row in steps.CASES[0].evaluate(runs).rows)

    assert missed(flown(0, 20.0, 1.0), flown(1, 20.0, 1.0)) == 0
    assert missed(flown(0, 26.0, 1.0)) == 1
    assert missed(flown(1, math.inf, 5.0)) == 2
    assert missed(flown(2, 26.0, 5.0)) == 0  # before anything is learned


def test_what_moves_on_a_straight_line_misses_its_target(tmp_path: Path) -> None:
    def flown(coefficient: float, gain: float) -> RunArrays:
        errors = {"failed": np.array(0.0), "errors": np.array([0.01, 0.02])}
        return {**errors, "coefficients": np.full(8, coefficient), "gains": np.full(6, gain)}

    def missed(*runs: RunArrays) -> int:
        return sum(row.ok is False for row in straight.CASES[0].evaluate(runs).rows)

    assert missed(flown(0.01, 0.01)) == 0
    assert missed(flown(0.01, 0.01), flown(0.03, 0.01)) == 1
    assert missed(flown(0.01, 0.03)) == 1
    scenario = loaded(tmp_path, straight.straight(300.0).scenario.format(adoption="true"))
    assert scenario.duration == 420.0
    assert scenario.orders[-1].t == 120.0


def test_what_is_not_learned_is_wrong_and_the_ten_are_right_on_the_first_hull(tmp_path: Path) -> None:
    for hull, name, factors, *_ in other_wrong.WAYS:
        right = read_toml(configs() / hull.folder / "vehicle.toml")
        first, again, other = (factors(right, signs(seed)) for seed in (1000, 1000, 1003))
        wrong = first.get("coefficients", {}).keys()
        assert first == again, name
        assert hull.folder == "remus100" or first != other, name
        assert wrong & {*TEN} == ({*TEN} if "the ten" in name else set()), name
        assert bool(first) != ("nothing" in name), name
        scenario = loaded(tmp_path, track().scenario.format(adoption="true") + overlay(first))
        assert scenario.vehicle_factors == first, name


def test_a_straight_flight_that_ends_while_it_still_learns_meets_no_target(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = np.arange(3.0)
    errors = Errors(seconds, seconds, seconds, seconds, math.inf, completed=False)
    monkeypatch.setattr(straight, "flown_as", lambda *_, **__: errors)
    case = straight.CASES[0]
    rows = [row for row in case.evaluate([case.run(1000, 0)]).rows if row.target is not None]
    assert len(rows) == 3
    assert not any(row.ok for row in rows)
