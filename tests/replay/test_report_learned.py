"""What the report and the summary say of coefficients, against a log whose columns were written by hand."""

from __future__ import annotations

import copy
import json
import re
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sternplane.logs.learned import LearnedFigures, coefficients
from sternplane.logs.reading import Log, read
from sternplane.logs.summary import summarise
from sternplane.logs.summary_text import key_figures
from sternplane.report import flight_page
from sternplane.report.coefficient_plots import SECTION
from sternplane.report.figures import Figures

from firmware_py.adapters.installation import configs
from firmware_py.estimation.coefficient_validity import CAREFUL
from firmware_py.estimation.model.observer_model import GROUPS
from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.mission import ManoeuvreKind

VEHICLE = tomllib.loads((configs() / "npsauv2" / "vehicle.toml").read_text())
NAMES = ["M_q", "Y_dr", "N_dot"]
BELIEVED = [-0.068, 0.027, 1.0]
TRUTH = {**VEHICLE["coefficients"], "M_q": -0.08, "Y_dr": 0.025}
TRUTH |= {name: 1.25 * TRUTH[name] for name in GROUPS["N_dot"]}
RUDDERS = [{"name": f"rudder_{one}", "share": [0.0, 0.5, 0.0], "effectiveness": 1.0} for one in ("upper", "lower")]
BUILT = {"coefficients": TRUTH, "density": 1000.0, "length": 5.3, "fins": RUDDERS}
CYCLES, BEGUN = 300, 100


def hear(log: Log) -> Log:
    """A second after the start the filter begins; half a second before the end it is halted."""
    c, t = log.columns, np.arange(CYCLES)
    since = np.clip((t - BEGUN) / 200.0, 0.0, 1.0)
    value = np.array(BELIEVED) * (1.0 + 0.2 * since[:, None] * np.array([1.0, -0.5, 1.5]))
    std = np.abs(BELIEVED) * np.where(since[:, None] > 0.5, 0.05, 0.5)
    valid = np.outer(since > 0.5, [True, False, True])
    running = (t >= BEGUN) & (t < 250)
    c["state.learned.value"], c["state.learned.std"] = value, std
    c["state.learned.valid"], c["state.learned.excited"] = valid, np.outer(running, [True, True, True])
    c["state.learned.current"] = np.tile([0.1, -0.05], (CYCLES, 1))
    c["state.learned.current_std"] = np.full((CYCLES, 2), 0.01)
    c["state.learned.turbulence"] = np.full(CYCLES, 0.02)
    c["state.learned.nis"] = np.where(running[:, None], [1.1, 0.9, np.nan], np.nan)
    c["state.learned.horizon"] = np.where(running, 0.01 * t - 0.2, np.nan)
    for name in ("rejected", "dropped", "resets"):
        c[f"state.learned.{name}"] = np.full(CYCLES, len(name))
    return log


@pytest.fixture
def log(tmp_path: Path, toy: SimpleNamespace) -> Log:
    configuration = {"vehicle": VEHICLE, "autopilot": {"estimation": {"coefficients": {"names": NAMES}}}}
    log = hear(read(toy.fly(tmp_path / "log.mcap", configuration=configuration)))
    log.header["truth"] = copy.deepcopy(BUILT)
    return log


def figures(log: Log) -> LearnedFigures:
    figures = LearnedFigures(log)
    for piece in log.pieces():
        figures.add(piece)
    return figures


def drawn(log: Log) -> dict[str, Any]:
    return {plot.title: plot for plot in Figures(log) if plot.section}


def traces(log: Log, title: str) -> dict[str, np.ndarray]:
    return {trace.name: np.array(trace.y, dtype=float) for trace in drawn(log)[title].figure.data}


def test_they_stand_in_a_section_of_their_own(log: Log) -> None:
    page = flight_page.flight_page(log, summarise(log))
    heads = re.findall(r"<h[23][^>]*>(.*?)</h[23]>", page)
    at = heads.index(SECTION)
    assert heads[at + 1 :] == [
        *NAMES,
        *("Excitation and validity", "Errors in sigmas", "Innovations", "Current", "Turbulence"),
        *("Set-up", "Made by"),
    ]
    assert heads.count(SECTION) == 1
    assert "Depth" in heads[:at]


def test_an_estimate_is_drawn_in_its_band_beside_belief_and_truth(log: Log) -> None:
    found, every = traces(log, "M_q"), slice(None, None, 10)
    value, std = (log.columns[f"state.learned.{name}"][every, 0] for name in ("value", "std"))
    assert np.isnan(found["estimate"][:10]).all()
    assert found["estimate"][10:] == pytest.approx(value[10:], rel=1e-6)
    assert found["±3 σ"][:20] == pytest.approx((value + 3.0 * std)[10:], rel=1e-6)
    assert found["±3 σ"][:19:-1] == pytest.approx((value - 3.0 * std)[10:], rel=1e-6)
    assert found["truth"] == pytest.approx([-0.08, -0.08])
    assert found["vehicle file"] == pytest.approx([-0.068, -0.068])
    valid = np.isfinite(found["estimate, valid"])
    assert (valid == log.columns["state.learned.valid"][every, 0]).all()
    low, high = drawn(log)["M_q"].figure.layout.yaxis.range
    assert low < -0.0917  # the last band
    assert high < -0.05  # not the first one
    assert drawn(log)["M_q"].note.startswith("At the end -0.08153 ± 0.01 (3 σ), valid; +1.92 % (0.5 σ) off the truth")


def test_axes_name_their_unit(log: Log) -> None:
    found = drawn(log)
    assert [found[name].figure.layout.yaxis.title.text for name in NAMES] == [
        f"{name}, nondimensional" for name in NAMES
    ]
    assert found["Current"].figure.layout.yaxis.title.text == "current, m/s"
    assert {plot.figure.layout.xaxis.title.text for plot in found.values()} == {"vehicle time, s"}


def test_a_coefficient_that_never_was_valid_is_drawn_all_the_same(log: Log) -> None:
    assert "estimate, valid" not in traces(log, "Y_dr")
    assert drawn(log)["Y_dr"].figure.layout.yaxis.range[0] < 0.0243
    assert "not valid" in drawn(log)["Y_dr"].note


def test_what_is_excited_and_valid_is_a_timeline(log: Log) -> None:
    (timeline,) = drawn(log)["Excitation and validity"].figure.data
    assert list(timeline.y) == NAMES
    m_q, y_dr, _ = np.array(timeline.z)
    assert m_q[[5, 15, 24, 29]].tolist() == [0, 1, 3, 2]
    assert y_dr[[5, 15, 24, 29]].tolist() == [0, 1, 1, 0]


def test_what_a_manoeuvre_taught_and_what_not_stands_there_and_in_the_summary(log: Log) -> None:
    sentence = "prbs: learned 2 of 3, 1 valid, 1 sigma up to 5 % (M_q); not identifiable: Y_dr (never excited)"
    prbs = {"manoeuvre": ManoeuvreKind.PRBS}
    begun = Event(EventKind.MANOEUVRE_BEGUN, Severity.WARNING, numbers=(2.0, 60.0), **prbs)
    done = Event(EventKind.MANOEUVRE_DONE, Severity.WARNING, numbers=(2.0, 0.0), **prbs)
    report = [
        Event(EventKind.LEARNING_REPORT, Severity.WARNING, cause=cause, numbers=numbers, names=names, **prbs)
        for cause, numbers, names in [
            (Cause.LEARNED, (2.0, 3.0, 1.0, 0.05), ("M_q",)),
            (Cause.NEVER_EXCITED, (), ("Y_dr",)),
        ]
    ]
    log.events[:] = [(0.5, (begun,)), (2.5, (done, *report))]
    assert drawn(log)["Excitation and validity"].note.endswith(f"filter is consistent. At 2.5 s, {sentence}.")
    assert summarise(log)["learned"]["taught"] == [[2.5, sentence]]
    log.events.clear()
    assert drawn(log)["Excitation and validity"].note.endswith("the filter is consistent.")
    assert summarise(log)["learned"]["taught"] == []


def test_the_water_is_drawn_while_the_filter_runs_beside_the_truth(log: Log) -> None:
    found = traces(log, "Current")
    assert np.isfinite(found["north"]).tolist() == [False] * 10 + [True] * 15 + [False] * 5
    assert found["north"][12] == pytest.approx(0.1)
    assert found["east"][12] == pytest.approx(-0.05)
    assert found["north, ±3 σ"] == pytest.approx([0.13] * 15 + [0.07] * 15)
    assert found["north, truth"] == pytest.approx(np.full(30, 0.1))
    assert found["east, truth"] == pytest.approx(np.zeros(30))
    assert traces(log, "Turbulence")["turbulence"][12] == pytest.approx(0.02)


def test_what_the_water_may_do_is_shaded_only_where_the_filter_runs_and_in_the_colour_of_its_line(log: Log) -> None:
    """Halted from 1.5 to 2 s: no area leads across that."""
    log.columns["state.learned.horizon"][150:200] = np.nan
    figure = drawn(log)["Current"].figure
    areas = {trace.name: trace for trace in figure.data if trace.fill}
    x = np.asarray(areas["north, ±3 σ"].x)
    gap = np.flatnonzero(np.isnan(x))
    assert [part[np.isfinite(part)].tolist() for part in np.split(x, gap)] == [
        pytest.approx([*side, *reversed(side)]) for side in (np.arange(1.0, 1.5, 0.1), np.arange(2.0, 2.5, 0.1))
    ]
    assert {trace.fill for trace in areas.values()} == {"toself"}
    assert areas["north, ±3 σ"].fillcolor != areas["east, ±3 σ"].fillcolor


def test_the_summary_has_values_sigmas_and_errors(log: Log) -> None:
    summary = summarise(log)
    learned = json.loads(json.dumps(summary, allow_nan=False))["learned"]
    m_q, y_dr, n_dot = (learned["coefficients"][name] for name in NAMES)
    value = float(log.columns["state.learned.value"][-1, 0])
    assert (m_q["value"], m_q["std"], m_q["valid"]) == (value, pytest.approx(0.0034), True)
    assert m_q["error_pct"] == pytest.approx(100.0 * (value / -0.08 - 1.0))
    assert m_q["error_sigmas"] == pytest.approx((value + 0.08) / 0.0034)
    assert (y_dr["valid"], y_dr["believed"], y_dr["truth"]) == (False, 0.027, 0.025)
    assert (n_dot["believed"], n_dot["truth"]) == (1.0, pytest.approx(1.25))
    errors = [one["error_sigmas"] ** 2 for one in (m_q, y_dr, n_dot)]
    assert learned["mean_square_error_sigmas"] == pytest.approx(np.mean(errors))
    assert learned["nis"] == {"dvl": None, "gyro": None, "attitude": None}
    assert (learned["current_m_s"], learned["turbulence_m_s"]) == ([0.1, -0.05], 0.02)
    assert (learned["rejected"], learned["dropped"], learned["resets"]) == (8, 7, 6)
    said = dict(key_figures(summary)["learned"])
    assert said["coefficients valid"] == "2 of 3"
    sigmas = abs(n_dot["error_sigmas"])
    assert said["worst valid coefficient"] == f"N_dot +3.9 % ({sigmas:.1f} σ)"


def test_errors_beyond_the_plot_of_sigmas_are_told(log: Log) -> None:
    assert "cut" not in drawn(log)["Errors in sigmas"].note
    log.columns["state.learned.value"][200:210, 0] += 20.0 * log.columns["state.learned.std"][200, 0]
    plot = drawn(log)["Errors in sigmas"]
    assert list(plot.figure.layout.yaxis.range) == [-10.0, 10.0]
    most = np.max(traces(log, "Errors in sigmas")["M_q"][10:])
    assert plot.note.endswith(f" The plot is cut at ±10 σ; beyond it at their worst: M_q {most:.0f} σ.")


def test_a_fault_that_takes_half_of_the_rudder_is_a_step_of_the_truth_and_no_error_of_the_estimate(log: Log) -> None:
    log.header["faults"] = ["lost:rudder_upper@2", "freeze:pressure@1"]
    plots = drawn(log)
    (truth,) = [trace for trace in plots["Y_dr"].figure.data if (trace.name or "").startswith("truth")]
    assert (truth.name, truth.line.shape) == ("truth with the fault", "hv")
    assert truth.x == pytest.approx([0.0, 2.0, 2.9])
    assert truth.y == pytest.approx([0.025, 0.0125, 0.0125])
    assert plots["Y_dr"].figure.layout.yaxis.range[0] < 0.0125
    assert " off the truth with the fault." in plots["Y_dr"].note
    assert plots["Errors in sigmas"].note.startswith("Estimate minus truth with the fault")
    value, std = (log.columns[f"state.learned.{name}"][::10, 1] for name in ("value", "std"))
    (errors,) = [trace.y for trace in plots["Errors in sigmas"].figure.data if trace.name == "Y_dr"]
    expected = (value - np.where(np.arange(30) < 20, 0.025, 0.0125)) / std
    assert errors[10:] == pytest.approx(expected[10:], rel=1e-5)
    learned = summarise(log)["learned"]
    value, std = (log.columns[f"state.learned.{name}"][-1, 1] for name in ("value", "std"))
    y_dr = learned["coefficients"]["Y_dr"]
    assert y_dr["truth"] == 0.0125
    assert y_dr["error_pct"] == pytest.approx(100.0 * (value / 0.0125 - 1.0))
    assert y_dr["error_sigmas"] == pytest.approx((value - 0.0125) / std)
    squares = [one["error_sigmas"] ** 2 for one in learned["coefficients"].values()]
    assert learned["mean_square_error_sigmas"] == pytest.approx(np.mean(squares))
    assert "truth" in [trace.name for trace in plots["M_q"].figure.data]  # no fin makes it
    assert plots["M_q"].note.endswith("off the truth.")


def test_after_a_fault_that_is_over_the_estimate_is_beside_what_was_built_again(log: Log) -> None:
    log.header["faults"] = ["weak:rudder_lower=20@1.5+1"]
    found = traces(log, "Y_dr")["truth with the fault"]
    assert found == pytest.approx([0.025, 0.6 * 0.025, 0.025, 0.025])
    assert summarise(log)["learned"]["coefficients"]["Y_dr"]["truth"] == 0.025
    assert " off the truth." in drawn(log)["Y_dr"].note


def test_at_sea_there_is_no_truth_to_compare_with(log: Log) -> None:
    del log.header["truth"]
    learned = summarise(log)["learned"]
    assert learned["mean_square_error_sigmas"] is None
    for one in learned["coefficients"].values():
        assert (one["truth"], one["error_pct"], one["error_sigmas"]) == (None, None, None)
    assert "worst valid coefficient" not in dict(key_figures(summarise(log))["learned"])
    assert set(traces(log, "M_q")) == {"in force", "±3 σ", "vehicle file", "estimate", "estimate, valid"}
    assert "truth" not in drawn(log)["M_q"].note
    assert "Errors in sigmas" not in drawn(log)


@pytest.mark.parametrize("key", ["density", "length"])
def test_numbers_made_dimensionless_by_another_hull_are_not_compared(log: Log, key: str) -> None:
    log.header["truth"][key] *= 1.025
    assert all(np.isnan(one.truth).all() and np.isnan(one.built) for one in coefficients(log.header, log.columns))


def test_a_group_has_a_truth_only_if_its_members_are_off_alike(log: Log) -> None:
    log.header["truth"]["coefficients"]["N_rdot"] *= 1.1
    found = coefficients(log.header, log.columns)
    assert [np.isfinite(one.truth).all() for one in found] == [np.isfinite(one.built) for one in found]
    assert [np.isfinite(one.built) for one in found] == [True, True, False]


@pytest.mark.parametrize("names", [NAMES[:2], "M_q", [1, 2, 3]])
def test_names_that_do_not_fit_are_not_guessed(log: Log, names: object) -> None:
    log.header["configuration"]["autopilot"]["estimation"]["coefficients"]["names"] = names
    assert [one.name for one in coefficients(log.header, log.columns)] == [
        "coefficient 1",
        "coefficient 2",
        "coefficient 3",
    ]


def test_names_of_a_log_stay_words(log: Log) -> None:
    nasty = "</h2><script>alert(1)</script>"
    log.header["configuration"]["autopilot"]["estimation"]["coefficients"]["names"] = [nasty, *NAMES[1:]]
    assert nasty not in flight_page.flight_page(log, summarise(log)).replace("<\\/", "")


def test_a_filter_that_never_began_has_learned_nothing(log: Log) -> None:
    log.columns["state.learned.horizon"] = np.full(CYCLES, np.nan)
    assert summarise(log)["learned"] is None
    assert not drawn(log)
    assert SECTION not in flight_page.flight_page(log, summarise(log))


def test_a_log_of_a_vehicle_that_does_not_learn_has_no_section(flown: Path) -> None:
    log = read(flown)
    assert "state.learned.value" not in log.columns
    assert summarise(log)["learned"] is None
    assert not drawn(log)


def test_the_band_of_the_innovations_is_that_of_an_exponential_window(log: Log) -> None:
    """Means of drawn chi-squares in the window of the DVL's rate; seven pings in 3 s."""
    c = log.columns
    log.header["configuration"]["autopilot"]["estimation"]["health"] = {"nis_slack_pct": 0.0}
    c["frame.dvl.fresh"] = np.arange(CYCLES) % 43 == 0
    c["frame.ahrs.fresh"] = np.zeros(CYCLES, dtype=bool)
    bands = figures(log).nis_bands
    assert list(bands) == ["dvl"]
    low, high = bands["dvl"]
    fade, rng = np.exp(-0.43 / 10.0), np.random.default_rng(3)
    total, count = np.zeros(100_000), 0.0
    for _ in range(200):
        total, count = total * fade + rng.chisquare(3.0, len(total)), count * fade + 3.0
    outside = np.mean((total / count < CAREFUL * low) | (total / count > high))
    assert 2e-4 < outside < 2e-3
    log.header["configuration"]["autopilot"]["estimation"]["health"] = {"nis_slack_pct": 25.0}
    assert figures(log).nis_bands["dvl"] == pytest.approx((low / 1.25, high * 1.25))
