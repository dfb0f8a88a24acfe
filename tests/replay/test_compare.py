"""`sternplane compare`, against toy runs whose figures are known."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sternplane.cli import main
from sternplane.compare.compared_run import ComparedRun, open_runs, until
from sternplane.compare.comparison import Comparison
from sternplane.compare.overlays import overlays
from sternplane.logs.reading import read
from sternplane.logs.summary import summarise

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from tests.replay.test_report_learned import BUILT, NAMES, VEHICLE, hear

CONFIG = configs() / "npsauv2"
Said = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def flown_once(tmp_path_factory: pytest.TempPathFactory, toy: SimpleNamespace) -> Path:
    """Three runs: a sliding law, PID that flies shorter with a wrong file, and one without truth."""
    tmp_path = tmp_path_factory.mktemp("runs")
    made = [
        ("sliding", 3.0, {}, {}),
        ("pid", 2.5, {"over": {"control": {"law": "pid"}}, "factors": {"coefficients": {"M_q": 1.5}}}, {"seed": 2}),
        ("sea", 3.0, {"over": {"control": {"u_min_m_s": 0.6}}}, {"truth": False, "scenario": "vehicle"}),
    ]
    for name, seconds, how, more in made:
        (tmp_path / name).mkdir()
        configuration = config_files.read_configuration(CONFIG, **how)
        toy.fly(tmp_path / name / "log.mcap", seconds, configuration=configuration, **more)
    return tmp_path


@pytest.fixture
def runs(flown_once: Path, tmp_path: Path) -> Path:
    """The same, in a folder to write into."""
    return shutil.copytree(flown_once, tmp_path, dirs_exist_ok=True)


def compared(*paths: Path) -> Comparison:
    return Comparison(open_runs([str(path) for path in paths]))


def test_only_what_differs_is_told_with_its_value_in_each_run(runs: Path) -> None:
    found = {one.key: one.values for one in compared(runs / "sliding", runs / "pid", runs / "sea").differences}
    size = config_files.vehicle(config_files.read_configuration(CONFIG)).force_coefficients["M_q"]
    assert found == {
        "scenario": ["toy", "toy", "vehicle"],
        "autopilot.control.law": ["sliding", "pid", "sliding"],
        "autopilot.control.u_min_m_s": ["0.5", "0.5", "0.6"],
        "vehicle.coefficients.M_q": [f"{size:g}", f"{1.5 * size:g}", f"{size:g}"],
    }


def test_a_default_that_is_written_out_is_no_difference(runs: Path, toy: SimpleNamespace) -> None:
    whole = config_files.read_configuration(CONFIG)
    whole["autopilot"] = {**whole["autopilot"], "control": {**whole["autopilot"].get("control", {}), "law": "sliding"}}
    (runs / "same").mkdir()
    toy.fly(runs / "same" / "log.mcap", configuration=whole)
    comparison = compared(runs / "sliding", runs / "same")
    assert comparison.differences == []
    assert comparison.warnings == []
    assert comparison.common == []


def test_what_was_laid_upon_files_that_no_log_has_is_a_difference(runs: Path, toy: SimpleNamespace) -> None:
    configuration = config_files.read_configuration(CONFIG)
    laid = {"truth.current_m_s": 0.3, "sensors.dvl.noise": 0.05, "scenario.duration_s": 3, "autopilot.rate_hz": 100}
    (runs / "laid").mkdir()
    settings = {"settings": {**laid, "scenario.zigzag.delta_r_deg": 10}}
    toy.fly(runs / "laid" / "log.mcap", 3.0, configuration=configuration, **settings)
    assert {one.key: one.values for one in compared(runs / "sliding", runs / "laid").differences} == {
        "set truth.current_m_s": ["–", "0.3"],
        "set sensors.dvl.noise": ["–", "0.05"],
        "set scenario.duration_s": ["–", "3"],
        "set scenario.zigzag.delta_r_deg": ["–", "10"],
    }


@pytest.mark.parametrize("more", [{"scenario": "mine.toml"}, {"git": "another"}])
def test_files_that_no_log_has_are_told_where_they_may_differ(
    runs: Path, toy: SimpleNamespace, more: dict[str, str]
) -> None:
    (runs / "own").mkdir()
    toy.fly(runs / "own" / "log.mcap", 3.0, configuration=config_files.read_configuration(CONFIG), **more)
    said = "What scenario, truth.toml and sensors.toml hold is not in the logs"
    assert any(one.startswith(said) for one in compared(runs / "sliding", runs / "own").warnings)
    assert compared(runs / "sliding", runs / "pid").warnings == []


def test_digests_tell_whether_files_that_no_log_has_differ(runs: Path, toy: SimpleNamespace) -> None:
    def flown(name: str, sea: str = "1a", scenario: str = "mine.toml") -> Path:
        (runs / name).mkdir()
        told = {"scenario": scenario, "digests": {"scenario": sea, "truth": "2b", "sensors": "3c"}}
        toy.fly(runs / name / "log.mcap", 3.0, configuration=config_files.read_configuration(CONFIG), **told)
        return runs / name

    calm, rough, other = flown("calm"), flown("rough", "4d"), flown("other", "4d", "toy.toml")
    found = compared(calm, rough)
    assert {one.key: one.values for one in found.differences} == {
        "scenario mine.toml: digest of what the file says": ["1a", "4d"]
    }
    (said,) = found.warnings
    assert said.startswith("Files of the simulation are not the same")
    same = compared(calm, flown("again"))
    assert (same.differences, same.warnings) == ([], [])
    assert not [one.key for one in compared(calm, other).differences if "digest" in one.key]
    assert not [one.key for one in compared(calm, runs / "sliding").differences if "digest" in one.key]


def test_laws_and_gains_are_named(runs: Path) -> None:
    rows = {label: values for label, *values in compared(runs / "sliding", runs / "pid").identity}
    assert rows["law"] == ["sliding", "pid"]
    assert rows["gains"] == ["of the configuration", "of the configuration"]
    assert rows["configuration"] == [str(CONFIG / "autopilot.toml")] * 2
    assert rows["vehicle"] == ["NPS AUV II"] * 2


def test_runs_of_different_length_have_figures_over_the_time_that_all_have(runs: Path) -> None:
    long, short = runs / "sliding", runs / "short"
    short.mkdir()
    log = (runs / "pid" / "log.mcap").read_bytes()
    (short / "log.mcap").write_bytes(log[: len(log) * 2 // 5])  # a killed writer
    comparison = compared(long, short)
    assert comparison.shortest < 1.6
    first, second = comparison.common
    whole = read(long / "log.mcap")
    rows = whole.columns["t"] < comparison.shortest
    assert first["cycles"] == rows.sum()
    assert first["depth_max_m"] == pytest.approx(whole.truth["eta.z"][rows].max())
    assert second["cycles"] == comparison.runs[1].summary["cycles"]
    assert comparison.warnings[0].startswith("The runs are not as long as each other: sliding 3.0 s, short ")
    assert comparison.warnings[1].startswith("short: the log is cut off; recovered up to ")


def test_a_part_of_a_run_is_what_a_shorter_run_would_have_been(runs: Path, toy: SimpleNamespace) -> None:
    configuration = config_files.read_configuration(CONFIG)
    shorter = summarise(read(toy.fly(runs / "log.mcap", 2.2, configuration=configuration)))
    part = summarise(until(read(runs / "sliding" / "log.mcap"), 2.2))
    assert part == shorter


def test_a_run_without_truth_is_told_to_be_what_the_vehicle_believed(runs: Path) -> None:
    comparison = compared(runs / "sliding", runs / "sea")
    assert comparison.warnings[0].startswith("No truth in sea: lines and figures there are what the vehicle believed")
    depth = next(plot.figure for plot in overlays(comparison.runs) if plot.title == "Depth")
    lines = {one.name: np.array(one.y) for one in depth.data if one.showlegend is not False}
    believed, true = read(runs / "sea" / "log.mcap").columns["state.eta.z"], read(runs / "sliding" / "log.mcap").truth
    np.testing.assert_allclose(lines["sea"], believed[::10], rtol=1e-6)
    np.testing.assert_allclose(lines["sliding"], true["eta.z"][::10], rtol=1e-6, atol=1e-6)


def test_each_run_has_one_colour_in_every_plot(runs: Path) -> None:
    comparison = compared(runs / "sliding", runs / "pid")
    colours: dict[str, set[str]] = {}
    for plot in overlays(comparison.runs):
        for one in plot.figure.data:
            if one.name in ("sliding", "pid"):
                colours.setdefault(one.name, set()).add(one.line.color)
    assert len(colours["sliding"]) == len(colours["pid"]) == 1
    assert colours["sliding"] != colours["pid"]
    track = next(plot.figure for plot in overlays(comparison.runs) if plot.title == "Plan view")
    assert [one.name for one in track.data if one.showlegend is not False] == ["sliding", "pid", "legs"]


def test_coefficients_stand_beside_the_truth_that_the_runs_share(tmp_path: Path, toy: SimpleNamespace) -> None:
    configuration = {"vehicle": VEHICLE, "autopilot": {"estimation": {"coefficients": {"names": NAMES}}}}
    logs = [hear(read(toy.fly(tmp_path / f"{i}.mcap", configuration=configuration))) for i in range(2)]
    logs[1].columns["state.learned.value"] = 1.1 * logs[1].columns["state.learned.value"]
    logs[0].header["truth"] = logs[1].header["truth"] = BUILT
    learned = [ComparedRun(name, log, summarise(log)) for name, log in zip("ab", logs, strict=True)]  # type: ignore[arg-type]
    found = {plot.title: plot for plot in overlays(learned) if plot.section}
    assert [*found] == NAMES
    lines = {one.name: np.array(one.y, dtype=float) for one in found["M_q"].figure.data}
    np.testing.assert_allclose(lines["b"][20:], 1.1 * lines["a"][20:], rtol=1e-6)
    assert lines["truth"] == pytest.approx([-0.08, -0.08])
    assert np.isfinite(lines["a, valid"]).sum() == logs[0].columns["state.learned.valid"][::10, 0].sum()
    logs[1].header["truth"] = {**BUILT, "coefficients": {**BUILT["coefficients"], "M_q": -0.09}}
    again = next(plot.figure for plot in overlays(learned) if plot.title == "M_q")
    assert {one.name for one in again.data} >= {"a, truth", "b, truth"}


def test_the_command_prints_a_table_and_leaves_a_page(
    runs: Path, capsys: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(runs)
    monkeypatch.setenv("COLUMNS", "200")
    assert main.main(["compare", "first=sliding", "pid/log.mcap"]) == 0
    said = re.sub(r" {2,}", "  ", capsys.readouterr().out)
    for row in ("first  pid", "autopilot.control.law  sliding  pid", "vehicle time  3.0 s  2.5 s", "compare.html"):
        assert row in said
    page = (runs / "compare.html").read_text()
    heads = re.findall(r"<h[23][^>]*>(.*?)</h[23]>", page)
    assert heads[:4] == ["Runs", "What differs", "Key figures", "Over each other"]


def test_a_key_that_differs_keeps_its_end_in_a_terminal_and_all_of_it_in_a_pipe(
    runs: Path, toy: SimpleNamespace, capsys: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(runs)
    monkeypatch.setenv("COLUMNS", "80")
    own = {"control": {"heading": {"integral_time_s": 61.0}, "depth": {"climb_bias_time_s": 7.0}}}
    toy.fly(runs / "sea" / "log.mcap", 3.0, configuration=config_files.read_configuration(CONFIG, over=own))
    keys = [one.key for one in compared(runs / "sliding", runs / "pid", runs / "sea").differences]
    assert max(map(len, keys)) > 34
    assert main.main(["compare", "sliding", "pid", "sea"]) == 0
    piped = capsys.readouterr().out
    assert [key for key in keys if f"  {key} " not in piped] == []
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert main.main(["compare", "sliding", "pid", "sea"]) == 0
    shown = capsys.readouterr().out
    assert [key for key in keys if f"{key[-33:]} " not in shown] == []


def test_names_and_paths_are_no_markup_and_send_no_escape_sequence(
    runs: Path, capsys: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(runs)
    monkeypatch.setenv("COLUMNS", "200")
    words = ["[/x]=sliding", "\x1b[31m:smile:=pid", "--out", "[/x]\x1b[31m/page.html"]
    assert main.main(["compare", *words]) == 0
    said = capsys.readouterr().out
    for shown in ("[/x]", r"\x1b[31m:smile:", r"[/x]\x1b[31m/page.html"):
        assert shown in said
    assert "\x1b" not in said


def test_without_the_libraries_that_draw_there_is_the_table_alone(
    runs: Path, capsys: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(runs)
    monkeypatch.setattr("sternplane.cli.extras.missing", lambda: ["plotly"])
    assert main.main(["compare", "sliding", "pid"]) == 0
    assert "no page without plotly: pip install 'sternplane[report]'" in capsys.readouterr().out
    assert not (runs / "compare.html").exists()
    asked = "import sys, sternplane.compare.command; sys.exit('plotly' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", asked], check=False).returncode == 0


def test_json_has_all_of_it_and_leaves_no_page(runs: Path, capsys: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(runs)
    assert main.main(["compare", "sliding", "pid", "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert [one["name"] for one in found["runs"]] == ["sliding", "pid"]
    assert found["runs"][1]["law"] == "pid"
    assert found["differences"]["autopilot.control.law"] == ["sliding", "pid"]
    figure = "depth_tracking_error_rms_m"
    assert [one["summary"][figure] for one in found["runs"]] == [
        summarise(read(runs / name / "log.mcap"))[figure] for name in ("sliding", "pid")
    ]
    assert not (runs / "compare.html").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["sliding"], "1 run: give 2 to 8 runs to compare"),
        (["a=sliding", "a=pid"], "two runs are called a: give each a name of its own, such as first=LOG"),
        (["sliding", "nowhere"], "nowhere: the log cannot be read (No such file or directory)"),
        (["sliding", "pid", "--out", "sliding/log.mcap/x.html"], "--out sliding/log.mcap/x.html: cannot be written"),
        (["sliding", "pid", "--out", "sliding/log.mcap"], "--out sliding/log.mcap: is a page; write FILE.html"),
    ],
)
def test_what_cannot_be_compared_is_refused_in_one_line(
    runs: Path, words: list[str], said: str, capsys: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(runs)
    assert main.main(["compare", *words]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"sternplane: {said}")
    assert error.count("\n") == 1


def names(*paths: str) -> Iterator[str]:
    for run in open_runs(paths):
        yield run.name


def test_runs_of_one_folder_name_are_told_apart(runs: Path) -> None:
    for campaign in ("monday", "tuesday"):
        (runs / campaign / "1").mkdir(parents=True)
        (runs / campaign / "1" / "log.mcap").write_bytes((runs / "pid" / "log.mcap").read_bytes())
    assert [*names(str(runs / "monday/1"), str(runs / "tuesday/1"))] == ["monday/1", "tuesday/1"]
