"""`sternplane paper`: what it finds, judged by the paper's own table; what it writes, by reading it."""

from __future__ import annotations

import dataclasses
import html
import json
import math
import re
import struct
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest
from sternplane.cli import main
from sternplane.paper import command, control, design, differences, drawings, estimation, figures, page
from sternplane.paper.printed import ERRATA, NUMBERS
from sternplane.report.drawing import Plot
from sternplane.sitl.flight import CONFIG

from firmware_py import app, config_files
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.control.control import LawKind
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.params import ParamError, load
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.plant.truth import Truth

TRUTH = load(Truth, read_toml(CONFIG / "truth.toml"), "truth.toml")
VEHICLE = load(Vehicle, read_toml(CONFIG / "vehicle.toml"), "vehicle.toml")
EKF = {"M_q": 0.12, "M_ds": 0.26, "N_r": 0.33, "N_dr": 0.58, "N_v": 0.13, "Z_ds": 0.05, "Z_q": 0.09}
EKF |= {"Y_dr": 14.53, "Y_r": 9.61, "Y_v": 23.29}
SMO = {"M_q": 1.10, "M_ds": 1.46, "N_r": 24.67, "N_dr": 17.78, "N_v": 30.35, "Z_ds": 3.07, "Z_q": 2.48}
SMO |= {"Y_dr": 49.34, "Y_r": 102.57, "Y_v": 44.22}

Flown = tuple[str, Path, tuple[str, ...]]
"""Scenario, configuration and settings of a flight."""


@pytest.fixture(scope="module")
def found() -> estimation.Estimation:
    return estimation.estimate(TRUTH, VEHICLE, lambda words: None)


@pytest.fixture(scope="module")
def rows(found: estimation.Estimation) -> list[design.Comparison]:
    return design.compare(VEHICLE, command.estimates(found, VEHICLE))


def step(tau: float = 5.0, over: float = 0.0) -> control.StepFlight:
    """A flight that nobody flew: a first-order answer to the step, with a little rudder."""
    t = np.arange(0.0, 130.0, 0.1)
    wanted = ((t >= 20.0) & (t < 70.0)).astype(float)
    way = np.where(t < 20.0, 0.0, np.where(t < 70.0, 1.0 + over - (1.0 + over) * np.exp(-(t - 20.0) / tau), 0.0))
    way = np.where(t >= 70.0, np.exp(-(t - 70.0) / tau), way)
    names = ("pitch", "rate", "sigma", "heading", "sway")
    columns = {"t": t, "wanted": wanted, "way": way, "fin": np.sin(t), **dict.fromkeys(names, 0.1 * way)}
    return control.StepFlight(columns, control.step_figures(t, wanted, way, np.sin(t)))


FLOWN = {
    "fig9": {who: step() for who in figures.BY},
    "fig10": {who: step(4.0, 0.02) for who in (*figures.BY, control.IDEAL)},
}


# --- what it finds ---------------------------------------------------------------------------------------------------


def test_every_row_of_the_ekf_is_at_or_under_table_1_from_every_start(found: estimation.Estimation) -> None:
    for errors in (found.learned["ekf"].errors, *found.starts["ekf"].values()):
        assert {name: abs(error) for name, error in errors.items() if not abs(error) <= EKF[name]} == {}
    assert differences.outcome(found) == ("every EKF row of Table 1 is at or under the paper's", True)


def test_the_observer_weighted_by_the_regressor_is_under_table_1_once_excited(found: estimation.Estimation) -> None:
    for errors in (found.learned["smo_prbs"].errors, *found.starts["smo_prbs"].values()):
        assert {name: abs(error) for name, error in errors.items() if not abs(error) <= SMO[name]} == {}


def test_the_constant_gain_rests_on_the_hyperplane_and_off_the_truth(found: estimation.Estimation) -> None:
    assert min(map(abs, found.learned["smo"].errors.values())) > 10.0
    for name, at in found.planes["smo"].items():
        assert at.share < 0.005
        assert abs(at.sum) < 0.01 * abs(found.planes["begin"][name].sum)


def test_the_motion_is_steady_at_the_end_of_its_length_and_elevator_alone_is_not_safe(
    found: estimation.Estimation,
) -> None:
    later = estimation.scenario(TRUTH, estimation.ANGLE, estimation.ANGLE, 2.0 * estimation.LENGTH)
    end, steady = found.flight.x[-1], later.x[-1]
    np.testing.assert_array_equal(later.x[: len(found.flight.x)], found.flight.x)
    assert end[:6] == pytest.approx(steady[:6], rel=0.03)
    assert abs(end[7]) < math.radians(40.0)
    assert found.nose[0] > math.radians(89.0)
    assert found.nose[1] > estimation.LENGTH


def test_errors_that_balance_are_found_to_lie_on_the_plane(found: estimation.Estimation) -> None:
    sizes = {name: abs(error) for name, error in found.learned["smo"].errors.items()}
    assert max(estimation.nearest(VEHICLE, found.flight, sizes).values()) < 0.005
    away = {**sizes, "Z_q": 3.0 * sizes["Z_q"]}
    assert estimation.nearest(VEHICLE, found.flight, away)["Z"] == pytest.approx(2.0 / 3.0, rel=0.01)


def test_all_printed_numbers_follow_but_two_of_the_yaw_row(rows: list[design.Comparison]) -> None:
    assert [row.number.key for row in rows if not row.follows] == ["a_rr", "b_r"]
    assert [row.number for row in rows] == list(NUMBERS)
    by_key = {row.number.key: row for row in rows}
    assert by_key["a_qq"].found["truth"] == pytest.approx(-1.0003, abs=1e-4)  # printed -1.002: the paper's EKF's
    assert by_key["k_theta"].found["truth"] == pytest.approx(-0.0062, abs=5e-5)
    assert by_key["s_q"].found["smo"] == by_key["s_q"].found["truth"]  # whatever the coefficients
    for row in rows:
        assert row.found["ekf"] == pytest.approx(row.found["truth"], rel=2e-3)


def test_the_length_in_the_rudder_s_term_is_squared_as_the_errata_say() -> None:
    c, L = VEHICLE.coefficients, VEHICLE.hull.length
    table_1 = {"Y_v": 0.7671 * c.Y_v, "Y_r": 1.0961 * c.Y_r, "Y_dr": 1.1453 * c.Y_dr}
    squared = design.models(design.with_values(VEHICLE, table_1))[1].b[0]
    cubed = design.models(design.with_values(VEHICLE, {**table_1, "Y_dr": L * table_1["Y_dr"]}))[1].b[0]
    assert (f"{squared:.3f}", f"{cubed:.2f}") == ("0.145", "0.80")
    assert any("0.145" in right and "0.80" in right for _, _, right in ERRATA)


def test_a_model_that_no_law_can_be_designed_for_leaves_gaps_and_no_error() -> None:
    adrift = design.with_values(VEHICLE, {"M_ds": -1e-300})
    numbers = design.numbers(*design.models(adrift))
    assert numbers["k_q"] is None
    assert numbers["k_v"] is not None


def test_settling_overshoot_and_travel_of_a_known_answer() -> None:
    figures_ = step(tau=5.0).figures
    assert figures_["settling_s"] == pytest.approx(5.0 * math.log(20.0), abs=0.2)
    assert figures_["settling_back_s"] == pytest.approx(5.0 * math.log(20.0), abs=0.2)
    assert figures_["overshoot_pct"] == 0.0
    assert figures_["rms_m"] == pytest.approx(math.sqrt(2.0 * 2.5 / 110.0), rel=0.03)
    assert figures_["fin_travel_deg_s"] == pytest.approx(2.0 / math.pi, rel=0.02)
    assert step(over=0.03).figures["overshoot_pct"] == pytest.approx(3.0, abs=0.1)
    assert step(tau=40.0).figures["settling_s"] is None


# --- what it writes --------------------------------------------------------------------------------------------------


def test_every_vehicle_it_writes_can_be_built_and_differs_in_what_it_should(tmp_path: Path) -> None:
    half = {name: 0.5 * getattr(VEHICLE.coefficients, name) for name in TEN}
    made = control.vehicles(tmp_path, {"smo": half, "truth": {}})
    assert set(made) == {"smo", "truth", "pid", "ideal"}
    for name, place in made.items():
        configuration = {**config_files.read_configuration(place, {}), "mission": {"waypoints": []}, "kept": {}}
        app.build(configuration)
        vehicle, truth = config_files.vehicle(configuration), load(Truth, read_toml(place / "truth.toml"), "truth.toml")
        wanted = design.with_values(VEHICLE, half) if name == "smo" else VEHICLE
        assert vehicle == wanted
        law = config_files.autopilot_params(configuration).control.law
        assert law is (LawKind.PID if name == "pid" else LawKind.SLIDING)
        assert dataclasses.replace(truth, servo=TRUTH.servo) == TRUTH
        assert (truth.servo.tau < 0.1 * TRUTH.servo.tau + 1e-9) == (name == "ideal")


def test_a_configuration_in_which_the_law_is_not_found_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    for path in CONFIG.glob("*.toml"):
        (other / path.name).write_text(path.read_text().replace('law = "sliding"', 'law = "pid"'))
    with pytest.raises(ParamError, match=r"autopilot\.toml: should have this once: 'law"):
        control.vehicles(tmp_path / "out", {}, other)


def test_the_page_has_every_figure_and_table_and_needs_no_network(
    found: estimation.Estimation, rows: list[design.Comparison]
) -> None:
    drawn = figures.all_figures(found, VEHICLE, FLOWN)
    text = page.page(found, rows, FLOWN, drawn)
    for words in ("Table 1", "Fig. 3", "Fig. 4", "Fig. 5", "Fig. 6", "Fig. 7", "Fig. 9", "Fig. 10", "hyperplane"):
        assert words in text
    assert len(re.findall(r'class="plot" id="plot\d+"', text)) == sum(len(figure.panels) for figure in drawn)
    assert "$" not in re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    assert not re.search(r'(src|href)="(?!#|data:)', text.partition("<script>")[0])


def test_every_axis_has_a_label_and_every_line_a_name_and_a_number(found: estimation.Estimation) -> None:
    for figure in figures.all_figures(found, VEHICLE, FLOWN):
        for panel in figure.panels:
            assert all(panel.labels)
            assert len(panel.labels) == (2 if panel.lines[0].z is None else 3)
            for line in panel.lines:
                assert line.name
                assert len(line.x) == len(line.y)
                assert np.isfinite(line.y).all()


def test_figures_are_drawn_into_png_files(found: estimation.Estimation, tmp_path: Path) -> None:
    drawn = figures.all_figures(found, VEHICLE, FLOWN)
    data = drawings.draw(drawn[0], tmp_path).read_bytes()
    assert data.startswith(b"\x89PNG\r\n")
    width, height = struct.unpack(">II", data[16:24])
    assert width > 1500
    assert height > 400
    assert data == drawings.draw(drawn[0], tmp_path).read_bytes()


# --- the command -----------------------------------------------------------------------------------------------------


@pytest.fixture
def grounded(found: estimation.Estimation, monkeypatch: pytest.MonkeyPatch) -> list[Flown]:
    """All of it but the flights and drawings, which other tests fly and draw; what would have been flown."""
    asked: list[Flown] = []

    def flight(
        scenario: str, config: Path, folder: Path, watch: object, settings: tuple[str, ...]
    ) -> control.StepFlight:
        asked.append((scenario, config, settings))
        return step()

    monkeypatch.setattr(control, "fly_step", flight)
    monkeypatch.setattr(estimation, "estimate", lambda truth, vehicle, done: found)
    monkeypatch.setattr(page, "plot", lambda panel: Plot(panel.title, "", go.Figure(), over_time=False))
    monkeypatch.setattr(drawings, "draw", lambda figure, folder: folder / f"{figure.name}.png")
    return asked


def test_the_command_flies_both_figures_and_leaves_results(
    grounded: list[Flown], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["paper", "--out", str(tmp_path)]) == 0
    flown = [(scenario, config.name) for scenario, config, _ in grounded]
    laws = ["truth", "ekf", "smo", "pid"]
    assert flown == [
        *(("paper-depth", law) for law in laws),
        *(("paper-heading", law) for law in (*laws, "ideal")),
    ]
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["table1"]["paper"] == {"ekf": EKF, "smo": SMO}
    assert set(results["table1"]["ekf"]) == set(results["table1"]["smo"]) == set(TEN)
    assert all(value >= 0.0 for value in results["table1"]["smo"].values())
    assert results["fig9"]["pid"]["settling_s"] == pytest.approx(15.0, abs=0.2)
    assert "report.html" in capsys.readouterr().out
    assert results["settings"] == {}


def test_flights_take_what_is_set_and_no_report_leaves_results_alone(
    grounded: list[Flown], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = "autopilot.guidance.turn_rate_max=2.5"
    assert main.main(["paper", "--set", given, "--out", str(tmp_path / "page")]) == 0
    assert {settings for _, _, settings in grounded} == {(given,)}
    results = json.loads((tmp_path / "page" / "results.json").read_text())
    assert list(results["settings"].values()) == [2.5]
    assert f"{next(iter(results['settings']))}=2.5" in html.unescape((tmp_path / "page" / "report.html").read_text())
    capsys.readouterr()
    assert main.main(["paper", "--no-report", "--out", str(tmp_path / "bare")]) == 0
    assert [path.name for path in (tmp_path / "bare").iterdir() if path.is_file()] == ["results.json"]
    assert not re.search(r"report\.html|\.png", capsys.readouterr().out)


@pytest.mark.parametrize("given", ["vehicle.M_q=-0.05", "truth.current=0.2", "autopilot.control.law=pid"])
def test_what_the_paper_says_cannot_be_set(given: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["paper", "--set", given, "--out", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "the paper says vehicle and sea" in err or "the flights set this themselves" in err
    assert not (tmp_path / "out").exists()


def test_a_row_above_the_paper_s_is_exit_status_1_and_said(
    grounded: list[Flown],
    found: estimation.Estimation,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ekf = found.learned["ekf"]
    worse = found._replace(learned={**found.learned, "ekf": ekf._replace(errors={**ekf.errors, "Z_ds": -0.06})})
    monkeypatch.setattr(estimation, "estimate", lambda truth, vehicle, done: worse)
    assert main.main(["paper", "--out", str(tmp_path)]) == 1
    text = html.unescape((tmp_path / "report.html").read_text())
    assert "EKF above the paper's Table 1 in Z_ds" in text


def test_a_flight_that_fails_is_exit_status_1_in_one_line(
    grounded: list[Flown],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def flight(*_: object) -> control.StepFlight:
        raise control.FlightError("paper-depth with smo: the plant has left the numbers")

    monkeypatch.setattr(control, "fly_step", flight)
    assert main.main(["paper", "--out", str(tmp_path)]) == 1
    assert capsys.readouterr().err.splitlines()[-1] == (
        "sternplane: paper-depth with smo: the plant has left the numbers"
    )


def test_a_folder_that_cannot_be_made_is_exit_status_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert main.main(["paper", "--out", str(tmp_path / "file")]) == 2
    assert "choose another folder with --out" in capsys.readouterr().err
