"""What `--set` sets of a study: it holds in every run, is told, and no folder mixes settings."""

from __future__ import annotations

import functools
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from sternplane.campaign import engine
from sternplane.cli import main
from sternplane.sitl.flight import FlightRequest
from sternplane.sitl.taken_settings import beside
from sternplane.study import command
from sternplane.study.adaptation import flight, rivals, second_dive
from sternplane.study.adaptation.courses import track
from sternplane.study.kept_runs import FOLDER
from sternplane.study.laid_settings import laid
from sternplane.study.rows import Case, Results, Row, RunArrays, Study
from sternplane.study.shipped_filter import shipped

from firmware_py.params import ParamError
from tests.in_process import Here


def _filtered(seed: int, k: int) -> RunArrays:
    return {"turbulence": np.array(shipped().turbulence)}


def _found(runs: Sequence[RunArrays]) -> Results:
    both = [*(run["turbulence"][-1] for run in runs), shipped().turbulence[-1]]
    return Results([Row("set", "of the runs", both[0], None, 1), Row("set", "of the judge", both[-1], None, 1)])


@pytest.fixture
def asks(monkeypatch: pytest.MonkeyPatch) -> None:
    """A study that shows which settings its runs, in processes of their own, and its judge have."""
    monkeypatch.setattr(command, "ESTIMATION", Study("t", "d", [Case("set", "", _filtered, _found, 2, 2)]))


BANK = "autopilot.estimation.coefficients.turbulence_m_s"


def test_what_is_set_holds_for_runs_and_judge_and_stands_in_results_and_page(asks: None, tmp_path: Path) -> None:
    words = ["study", "estimation", "--seeds", "0:2", "--out", str(tmp_path)]
    assert main.main([*words, "--set", "autopilot.estimation.coefficients.turbulence=[0.0, 0.07]"]) == 0
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["settings"] == {BANK: [0.0, 0.07]}
    assert [row["value"] for row in results["rows"]] == [0.07, 0.07]
    assert f"{BANK}=[0.0, 0.07]" in (tmp_path / "report.html").read_text()


def test_a_folder_goes_on_with_its_own_settings_alone(
    asks: None, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine, "LocalCrew", Here)
    words = ["study", "estimation", "--seeds", "0:2", "--out", str(tmp_path)]
    (tmp_path / FOLDER).mkdir()
    (tmp_path / FOLDER / "set.0.0.npz").touch()  # of a version that noted no settings: it took none
    given = ["--set", f"{BANK}=[0.0]"]
    assert main.main([*words, *given]) == 2
    refused = f"{tmp_path}: was begun with nothing set, here with --set {BANK}=[0.0]; choose another --out\n"
    assert capsys.readouterr().err == f"sternplane: {refused}"
    assert main.main(words) == 0
    assert main.main([*words, *given]) == 2
    assert json.loads((tmp_path / "results.json").read_text())["settings"] == {}


def test_no_report_leaves_the_results_alone(
    asks: None, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine, "LocalCrew", Here)
    assert main.main(["study", "estimation", "--seeds", "0:2", "--no-report", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "results.json").exists()
    assert not (tmp_path / "report.html").exists()
    assert "report.html" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("study", "given", "said"),
    [
        ("estimation", "vehicle.M_q=-0.05", "vehicle.coefficients.M_q: the estimation study sets vehicle"),
        ("estimation", f"{BANK.rpartition('.')[0]}.std=20", "std_pct: the flights set this themselves"),
        ("adaptation", "truth.current=0.3", "truth.current_m_s: the adaptation study sets vehicle, truth and sea"),
        ("adaptation", "autopilot.control.law=pid", "autopilot.control.law: the flights set this themselves"),
        ("adaptation", "autopilot.control.depth.bandwidth=-1", "bandwidth"),
        ("tuning", "autopilot.control.depth.bandwidth=1", "bandwidth_1_s: the flights set this themselves"),
        ("tuning", "truth.turbulence=0.1", "scenario.environment.turbulence_m_s: the tuning study sets course and sea"),
        ("safety", "truth.current=0.3", "truth.current_m_s: the flights set this themselves"),
        ("safety", "scenario.duration=10", "scenario.duration_s: the safety study sets mission"),
        ("safety", "truth.fins.rudder_uper.effectiveness=0.5", "there is no entry 'rudder_uper'"),
    ],
)
def test_what_a_study_sets_itself_is_refused_in_one_line(
    study: str, given: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["study", study, "--set", given, "--out", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_scenario_keeps_what_it_asks_for_and_takes_what_it_does_not() -> None:
    scenario = "[autopilot.control.depth_pid]\nk_rate = 3.0\n[sensors.dvl]\nbias_m_s = 0.0\n"
    given = ("autopilot.control.depth_pid.k_rate=1", "autopilot.control.depth_pid.k_angle=2", "sensors.dvl.bias=0.1")
    assert beside(scenario, given) == ("autopilot.control.depth_pid.k_angle=2",)


def test_flights_of_the_adaptation_study_are_prepared_with_what_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def prepare(request: FlightRequest, kept: object) -> None:
        asked.append(request.settings)
        raise ParamError("no flight in this test")

    monkeypatch.setattr(flight, "prepare", prepare)
    monkeypatch.setattr(second_dive, "prepare", prepare)
    given = ("autopilot.control.depth.bandwidth=1.5", "autopilot.control.depth_pid.k_rate=2")
    runs = [functools.partial(rivals.CASES[-1].run, 1000, 0), functools.partial(second_dive.SECOND_DIVE.run, 1000, 0)]
    runs.append(functools.partial(flight.flown_as, track(), 1, {}, False, rivals.gains("pid_free")))
    for run in runs:
        with laid(given), pytest.raises(ParamError):
            run()
    assert asked == [given, given, given[:1]]  # a rival's own gains are its own
    with pytest.raises(ParamError):
        runs[0]()
    assert asked[-1] == ()
