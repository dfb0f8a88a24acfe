"""The study judges what it should, alike each time, and says what a person got wrong."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2
from sternplane.cli import main
from sternplane.study import command, pool
from sternplane.study.cases import CASES, exact, noisy
from sternplane.study.figures import band_999
from sternplane.study.page import page
from sternplane.study.rows import Findings, Row
from sternplane.study.setups import Setup, bounded, flown, learn, starts

PAPER = exact.CASES[1]


@pytest.mark.parametrize(
    ("value", "target", "ok"),
    [
        (1.0, 1.0, True),
        (1.01, 1.0, False),
        (math.nan, 1.0, False),
        (math.nan, (0.0, 1.0), False),
        (0.9, (0.85, 1.15), True),
        (1.2, (0.85, 1.15), False),
        (3.0, None, None),
    ],
)
def test_a_row_meets_its_target_or_not(value: float, target: object, ok: bool | None) -> None:
    row = Row("case", "figure", value, target)
    assert row.ok is ok
    assert json.loads(json.dumps(row.plain(), allow_nan=False))["ok"] is ok


@pytest.mark.parametrize("freedom", [80, 210, 6000])
def test_the_band_is_chi_square_s(freedom: int) -> None:
    wanted = chi2.ppf([0.0005, 0.9995], freedom) / freedom
    assert band_999(freedom) == pytest.approx(tuple(wanted), rel=1e-2)


@pytest.fixture(scope="module")
def found() -> Findings:
    """Of the paper's scenario."""
    return PAPER.judge([PAPER.run(1, k) for k in range(PAPER.runs)])


def test_the_paper_s_scenario_is_judged_row_by_row(found: Findings) -> None:
    assert len(found.rows) == 30
    assert all(row.ok for row in found.rows)


def test_a_run_is_the_same_each_time_and_differs_by_its_seed() -> None:
    case = next(case for case in noisy.CASES if case.name == "noisy")
    a, b, other = case.run(3, 0), case.run(3, 1), case.run(4, 0)
    for name in a:
        np.testing.assert_array_equal(a[name], b[name])
    assert not np.array_equal(a["error"], other["error"])


def test_a_filter_that_starts_near_the_truth_claims_what_the_bound_allows() -> None:
    """Two computations with nothing in common but the model; far from the truth they differ by the linearisation."""
    setup = Setup(duration=20.0)
    for seed in range(4):
        ekf, trial = noisy.still_water(), flown(setup, seed)
        run = learn(setup, trial, ekf, seed, starts(seed, 0.02))
        assert run.std[-1] == pytest.approx(bounded(setup, trial, ekf, seed, (20.0,))[0], rel=0.1)


def test_errors_are_as_large_as_the_bound_says() -> None:
    setup, squares = Setup(duration=20.0), []
    for seed in range(12):
        ekf, trial = noisy.still_water(), flown(setup, seed)
        run = learn(setup, trial, ekf, seed, starts(seed, 0.5))
        squares.append((run.error[-1] / bounded(setup, trial, ekf, seed, (20.0,))[0]) ** 2)
    assert 0.5 < np.mean(squares) < 2.0


def test_every_case_is_known_by_its_name_and_makes_fewer_runs_in_the_short_form() -> None:
    assert len({case.name for case in CASES}) == len(CASES)
    assert all(0 < case.short <= case.runs for case in CASES)


def test_a_page_holds_every_row_and_loads_nothing(found: Findings) -> None:
    text = page([PAPER], [found], "seed 1")
    assert "30 of 30 targets met" in text
    assert 'src="http' not in text
    assert text.count('class="plot"') == len(found.plots)


@pytest.mark.parametrize("text", ["5", "7:7", "9:3", "a:b", "-1:4", "1:2:3"])
def test_seeds_that_are_none_are_refused_in_one_line(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["study", "estimation", f"--seeds={text}", "--out", "unused"]) == 2
    assert capsys.readouterr().err == (
        f"sternplane: --seeds {text}: write A:B with A below B, such as 0:40; B itself is not flown\n"
    )
    assert not Path("unused").exists()


def test_seeds_count_from_1000_by_default() -> None:
    assert command.seeds_of(None) == range(1000, 1400)
    assert command.seeds_of("0:40") == range(40)


def test_the_whole_study_runs_in_processes_and_exits_by_its_targets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = exact.CASES
    monkeypatch.setattr(command, "CASES", few)
    monkeypatch.setattr(pool, "CASES", few)
    assert main.main(["study", "estimation", "--seeds", "0:1", "--short", "--out", str(tmp_path)]) == 0
    rows = json.loads((tmp_path / "results.json").read_text())
    assert {tuple(row) for row in rows} == {("case", "figure", "value", "target", "ok")}
    assert all("100 Hz" in row["case"] for row in rows)
    assert (tmp_path / "report.html").stat().st_size > 1_000_000
