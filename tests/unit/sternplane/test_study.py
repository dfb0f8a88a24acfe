"""The study judges what it should, alike each time, and says what a person got wrong."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom, chi2, norm
from sternplane.campaign import engine
from sternplane.campaign.files import file_name
from sternplane.campaign.seeds import seeds_of
from sternplane.cli import main
from sternplane.study import command
from sternplane.study.adaptation import command as adaptation
from sternplane.study.cases import CASES, consistency, exact, noisy
from sternplane.study.chance import K_SIGMA, MISS, chi_square_band, greatest_of, median_of, rms_band, share_of
from sternplane.study.kept_runs import FOLDER, KeptRuns
from sternplane.study.page import page
from sternplane.study.rows import Case, Results, Row, RunArrays, Study
from sternplane.study.setups import (
    CONFIG,
    Setup,
    bound_std,
    fly_prbs,
    flying,
    run_filter,
    start_up_over,
    starts,
)
from sternplane.study.shipped_filter import shipped

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.params import load
from firmware_py.reconfiguration import AutopilotParams
from tests.in_process import Here

PAPER = exact.CASES[1]
FILE = "autopilot.toml"


@pytest.mark.parametrize(
    ("value", "target", "ok"),
    [
        (1.0, 1.0, True),
        (1.01, 1.0, False),
        (math.nan, 1.0, False),
        (math.nan, (0.0, 1.0), False),
        (0.9, (0.85, 1.15), True),
        (1.2, (0.85, 1.15), False),
        (100.0, (100.0, 100.0), True),
        (99.0, (100.0, 100.0), False),
        (0.0, 0.0, True),
        (1.0, 0.0, False),
        (math.nan, 0.0, False),
        (3.0, None, None),
    ],
)
def test_a_row_meets_its_target_or_not(value: float, target: object, ok: bool | None) -> None:
    row = Row("case", "figure", value, target)
    assert row.ok is ok
    plain = json.loads(json.dumps(row.plain(), allow_nan=False))
    assert plain["ok"] is ok
    no_room = target in (0.0, (100.0, 100.0))
    assert (row.margin is None) == (ok is None or (ok and no_room))
    assert math.isnan(value) or row.margin is None or (row.margin >= 0.0) == ok


@pytest.mark.parametrize("freedom", [1, 2, 4, 24, 79, 210, 6000])
def test_the_band_of_chance_is_chi_square_s(freedom: int) -> None:
    wanted = chi2.ppf([0.5 * MISS, 1.0 - 0.5 * MISS], freedom) / freedom
    assert chi_square_band(freedom) == pytest.approx(tuple(wanted), rel=2e-3)


@pytest.mark.parametrize("n", [50, 400])
def test_the_band_of_n_seeds_is_k_sigma_of_one_over_the_root_of_2n(n: int) -> None:
    low, high = rms_band(n)
    assert (high - low) / 2.0 == pytest.approx(K_SIGMA / math.sqrt(2.0 * n), rel=0.05)
    assert rms_band(n, 1.1) == pytest.approx((low, 1.1 * high))


def test_shares_medians_and_maxima_stay_below_what_chance_reaches() -> None:
    """Checked against scipy's distributions, each at the probability that a right filter has to miss the row."""
    assert norm.sf(greatest_of(24)) * 2.0 * 24 == pytest.approx(0.5 * MISS, rel=1e-3)
    assert binom.sf(1, 4, 2.0 * norm.sf(median_of(4))) == pytest.approx(MISS, rel=1e-3)
    most = round(share_of(100, 0.05) * 100)
    assert binom.sf(most, 100, 0.05) < MISS < binom.sf(most - 1, 100, 0.05)


@pytest.fixture(scope="module")
def found() -> Results:
    """Of the paper's scenario."""
    return PAPER.evaluate([PAPER.run(1, k) for k in range(PAPER.runs)])


def test_the_paper_s_scenario_is_judged_row_by_row(found: Results) -> None:
    assert len(found.rows) == 30
    assert all(row.ok for row in found.rows)


def test_a_coefficient_whose_part_in_the_model_is_off_misses_its_targets(monkeypatch: pytest.MonkeyPatch) -> None:
    right = exact.stillwater_filter

    def wrong() -> CoefficientEkf:
        ekf = right()
        ekf.model.arrays.terms.weight[ekf.names.index("M_q")] *= 1.01
        return ekf

    monkeypatch.setattr(exact, "stillwater_filter", wrong)
    rows = PAPER.evaluate([PAPER.run(1, k) for k in range(PAPER.runs)]).rows
    missed = [row.figure for row in rows if not row.ok]
    assert len([figure for figure in missed if figure.endswith("M_q")]) == PAPER.runs


def test_a_filter_that_is_told_wrong_noise_misses_the_band_of_its_innovations(monkeypatch: pytest.MonkeyPatch) -> None:
    water = {"no eddies": Setup(duration=start_up_over() + 5.0)}

    def missed() -> set[str]:
        rows = consistency.evaluate(water, [consistency.flights(water, seed) for seed in range(2)]).rows
        return {row.figure.partition(",")[0] for row in rows if row.ok is False}

    assert missed() == set()
    told = Setup.std.fget
    for scale in (0.9, 1.1):
        monkeypatch.setattr(Setup, "std", property(lambda setup, scale=scale: scale * told(setup)))
        assert {"NIS of gyro", "NIS of attitude"} <= missed()


def test_the_study_judges_the_filter_as_it_is_shipped() -> None:
    flown = load(AutopilotParams, tomllib.loads((CONFIG / FILE).read_text()), FILE).estimation.coefficients
    assert shipped() == flown
    assert noisy.any_water().params == flying()
    unlike = {f.name for f in dataclasses.fields(flown) if getattr(flying(), f.name) != getattr(flown, f.name)}
    known = {"nuisances", "stds", "surge_noise", "roll_noise", "fin_resolution"}
    assert unlike == {"std", "speed_bias", "rate_bias", "angle_bias", *known}


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
        ekf, trial = noisy.still_water(), fly_prbs(setup, seed)
        run = run_filter(setup, trial, ekf, seed, starts(seed, 0.02))
        assert run.std[-1] == pytest.approx(bound_std(setup, trial, ekf, seed, (20.0,))[0], rel=0.1)


def test_errors_are_as_large_as_the_bound_says() -> None:
    setup, squares = Setup(duration=20.0), []
    for seed in range(12):
        ekf, trial = noisy.still_water(), fly_prbs(setup, seed)
        run = run_filter(setup, trial, ekf, seed, starts(seed, 0.5))
        squares.append((run.error[-1] / bound_std(setup, trial, ekf, seed, (20.0,))[0]) ** 2)
    assert 0.5 < np.mean(squares) < 2.0


def test_every_case_is_known_by_its_name_and_makes_fewer_runs_in_the_short_form() -> None:
    assert len({case.name for case in CASES}) == len(CASES)
    assert all(0 < case.short <= case.runs for case in CASES)


def test_a_page_holds_every_row_and_loads_nothing(found: Results) -> None:
    text = page(command.ESTIMATION._replace(cases=[PAPER]), [found], ["seed 1"])
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
    counted = range(command.JUDGED_FROM, command.JUDGED_FROM + command.MOST)
    assert counted == range(1000, 1400)
    assert seeds_of(None, counted) == counted
    assert seeds_of("0:40", counted) == range(40)


def test_the_whole_study_runs_in_processes_and_exits_by_its_targets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left_out = exact.CASES[0]._replace(name="flown in the full form only", short=0)
    monkeypatch.setattr(command, "ESTIMATION", command.ESTIMATION._replace(cases=(*exact.CASES, left_out)))
    assert main.main(["study", "estimation", "--seeds", "0:1", "--short", "--out", str(tmp_path)]) == 0
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["settings"] == {}
    rows = results["rows"]
    assert {tuple(row) for row in rows} == {("case", "figure", "value", "target", "n", "margin", "ok")}
    assert all("100 Hz" in row["case"] for row in rows)
    assert left_out.name not in (tmp_path / "report.html").read_text()
    assert (tmp_path / "report.html").stat().st_size > 1_000_000


def _counted(seed: int, k: int) -> RunArrays:
    with (Path(os.environ["COUNTED"])).open("a") as file:
        file.write(f"{seed} {k}\n")
    return {"some, of a run": np.array([seed / 3.0, math.nan]), "k": np.array(k)}


def _shown(runs: Sequence[RunArrays]) -> Results:
    return Results([Row("counted: a / b", "sum", float(sum(run["some, of a run"][0] for run in runs)), 1e6, len(runs))])


def test_a_study_that_was_broken_off_or_grows_makes_only_the_runs_that_are_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, made = tmp_path / "out", tmp_path / "made"
    case = Case("counted: a / b", "", _counted, _shown, 9, 9 - 1)
    monkeypatch.setenv("COUNTED", str(made))
    monkeypatch.setattr(command, "ESTIMATION", Study("t", "d", [case]))
    monkeypatch.setattr(engine, "LocalCrew", Here)

    def study(seeds: str) -> tuple[set[str], bytes]:
        made.write_text("")
        assert main.main(["study", "estimation", "--seeds", seeds, "--out", str(out)]) == 0
        return set(made.read_text().splitlines()), (out / "results.json").read_bytes()

    first, _ = study("5:7")
    assert first == {"5 0", "6 1"}
    again, results = study("5:8")
    assert again == {"7 2"}
    kept = sorted((out / FOLDER).iterdir())
    assert len(kept) == 3
    kept[0].write_bytes(kept[0].read_bytes()[:99])  # as a full disk leaves it
    kept[1].unlink()
    assert study("5:8") == ({"5 0", "6 1"}, results)
    assert "another revision" not in (out / "report.html").read_text()
    KeptRuns(out, "an older one").keep(case, 6, 1, _counted(6, 1))
    assert study("5:8") == (set(), results)
    assert "made by another revision: an older one" in (out / "report.html").read_text()


def _a_part(seed: int, k: int) -> RunArrays:
    return _counted(seed, k) | {"some, of a run": np.zeros(2)}


def test_the_full_form_takes_no_run_of_the_short_form_that_left_flights_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COUNTED", str(tmp_path / "made"))
    monkeypatch.setattr(command, "ESTIMATION", Study("t", "d", [Case("counted", "", _counted, _shown, 9, 2, _a_part)]))
    monkeypatch.setattr(engine, "LocalCrew", Here)
    for form, value in ((["--short"], 0.0), ([], 3.0), (["--short"], 0.0)):
        assert main.main(["study", "estimation", "--seeds", "4:6", *form, "--out", str(tmp_path)]) == 0
        (row,) = json.loads((tmp_path / "results.json").read_text())["rows"]
        assert row["value"] == pytest.approx(value)
    assert sorted((tmp_path / "made").read_text().splitlines()) == ["4 0", "4 0", "5 1", "5 1"]  # each form once


def test_no_two_cases_of_a_study_keep_their_runs_under_one_name() -> None:
    for study in (command.ESTIMATION, adaptation.ADAPTATION):
        cases = [case.in_form(short) for case in study.cases for short in (False, True)]
        files = {file_name(case.files or case.name) for case in cases}
        assert len(files) == len(study.cases) + sum(case.judged is not None for case in study.cases)
