"""Why coefficients are not valid, or why nothing was learned, against logs whose columns were written by hand."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sternplane.logs.learned import LearnedFigures
from sternplane.logs.learning_reasons import LearningReasons, Reason, grouped
from sternplane.logs.reading import Log, Piece, read
from sternplane.logs.summary import summarise
from sternplane.logs.summary_text import key_figures
from sternplane.report.figures import Figures

from tests.replay.test_report_learned import BEGUN, BELIEVED, CYCLES, NAMES, VEHICLE, hear

Q, DR, DOT = range(3)


@pytest.fixture
def log(tmp_path: Path, toy: SimpleNamespace) -> Log:
    configuration = {"vehicle": VEHICLE, "autopilot": {"estimation": {"coefficients": {"names": NAMES}}}}
    log = hear(read(toy.fly(tmp_path / "log.mcap", configuration=configuration)))
    c = log.columns
    c["state.learned.valid"] = np.zeros((CYCLES, 3), dtype=bool)
    c["state.learned.std"] = np.abs(BELIEVED) * np.full((CYCLES, 3), 0.05)
    c["state.learned.resets"] = np.zeros(CYCLES, dtype=np.int64)
    return log


def reasons(log: Log, pieces: int = 1) -> dict[str, str]:
    """Of the whole log, or of as many pieces: the reasons must be the same."""
    why, figures = LearningReasons(log), LearnedFigures(log)
    for part in np.array_split(np.arange(CYCLES), pieces):
        piece = Piece(int(part[0]), {name: values[part] for name, values in log.columns.items()}, {})
        why.add(piece)
        figures.add(piece)
    assert pieces > 1 or reasons(log, 7) == {name: one.text for name, one in why.of(figures).items()}
    return {name: one.text for name, one in why.of(figures).items()}


def test_each_reason_is_told_of_the_coefficient_that_it_is_about(log: Log) -> None:
    c = log.columns
    c["state.learned.excited"][:, DR] = False
    c["state.learned.std"][:, DOT] = 0.14
    c["state.learned.valid"][150:200, Q] = True
    c["state.learned.std"][200:, Q] = 0.25 * abs(BELIEVED[Q])
    assert reasons(log) == {
        "M_q": "valid until 2.0 s, when 1 σ was over 20 %",
        "Y_dr": "never excited",
        "N_dot": "1 σ is over 10 % (14 %)",
    }
    c["state.learned.valid"][-1, Q] = True
    assert reasons(log).keys() == {"Y_dr", "N_dot"}


def test_what_ended_the_validity_of_a_coefficient_is_told(log: Log) -> None:
    """It falls in the cycle at 2 s: the filter pauses from there on; or runs, and the gyros speak against it."""
    c = log.columns
    c["state.learned.valid"][150:200, Q] = True
    c["state.learned.horizon"][200:220] = np.nan
    assert reasons(log)["M_q"] == "valid until 2.0 s, when the filter paused"
    c["state.learned.horizon"][200:220] = 2.0
    assert reasons(log)["M_q"] == "valid for a while only (until 2.0 s; 1 σ is 5 % at the end)", "nothing tells of it"
    c["state.learned.nis"][200, 1] = 0.1
    assert reasons(log)["M_q"] == "valid until 2.0 s, when gyro residuals were too small"
    c["state.learned.nis"][200, 1] = 4.0
    assert reasons(log)["M_q"] == "valid until 2.0 s, when gyro residuals were too great"
    c["state.learned.nis"][200, 1] = 0.9
    c["state.learned.std"][200, Q] = 0.3 * abs(BELIEVED[Q])
    assert reasons(log)["M_q"] == "valid until 2.0 s, when 1 σ was over 20 %"


def test_a_filter_that_began_anew_is_named(log: Log) -> None:
    c = log.columns
    c["state.learned.valid"][150:200, Q] = True
    c["state.learned.resets"][210:230], c["state.learned.resets"][230:] = 1, 2
    said = reasons(log)
    assert said["M_q"] == "valid until 2.0 s, when the filter began anew"
    assert said["Y_dr"] == "the filter began anew at 2.3 s only"


def test_a_filter_that_is_not_consistent_names_the_sensor(log: Log) -> None:
    log.columns["state.learned.nis"] = np.tile([1.0, 4.0, np.nan], (CYCLES, 1))
    said = reasons(log)
    assert said["M_q"].startswith("gyro residuals are too great for a consistent filter (NIS 4; ")
    assert said["M_q"].endswith(" at most expected)")
    log.columns["state.learned.nis"] = np.tile([1.0, 0.1, np.nan], (CYCLES, 1))
    said = reasons(log)
    assert said["M_q"].startswith("gyro residuals are too small for a consistent filter (NIS 0.1; at least 0.")
    assert said["M_q"].endswith(" expected)")


@pytest.mark.parametrize(("share", "told"), [(0.105, "10.5 %"), (0.1001, "10.01 %"), (0.14, "14 %"), (0.25, "25 %")])
def test_a_sigma_that_is_over_its_limit_is_told_as_more_than_that(log: Log, share: float, told: str) -> None:
    log.columns["state.learned.std"][:, DOT] = share
    assert reasons(log)["N_dot"] == f"1 σ is over 10 % ({told})"


def test_who_was_certain_only_while_nothing_moved_is_told_so(log: Log) -> None:
    c = log.columns
    c["state.learned.std"][:200, Q] = abs(BELIEVED[Q])
    c["state.learned.excited"][200:, Q] = False
    assert reasons(log)["M_q"] == "not excited once it was certain (1 σ is 5 %)"


@pytest.mark.parametrize(
    ("change", "learning", "said"),
    [
        ({}, {"enabled": False}, "learning is off (estimation.learning.enabled = false)"),
        ({"state.eta.z": 0.5}, {}, "never deeper than estimation.learning.depth_min_m = 1"),
        ({"frame.dvl.ok": False}, {}, "no DVL with bottom lock was heard under water"),
        ({"frame.dvl.value.u": 0.2}, {}, "never faster under water than estimation.learning.speed_min_m_s = 0.3"),
        ({"state.attitude_ok": False}, {}, "the attitude was never known under water"),
    ],
)
def test_a_flight_in_which_nothing_was_learned_tells_why(
    log: Log, change: dict[str, Any], learning: dict[str, Any], said: str
) -> None:
    c = log.columns
    log.header["configuration"]["autopilot"]["estimation"]["learning"] = learning
    c["state.learned.horizon"] = np.full(CYCLES, np.nan)
    c["state.learned.excited"] = np.zeros((CYCLES, 3), dtype=bool)
    good = {"state.eta.z": 5.0, "frame.dvl.fresh": True, "frame.dvl.ok": True, "frame.dvl.value.u": 1.5}
    for name, value in (good | {"state.attitude_ok": True, "state.depth_std": 0.1} | change).items():
        c[name] = np.full(CYCLES, value)
    summary = summarise(log)
    assert summary["not_learned_because"] == said
    assert ("coefficients", f"not learned: {said}") in key_figures(summary)["learned"]


def test_summary_and_report_have_the_reasons(log: Log) -> None:
    log.columns["state.learned.excited"][:, DR] = False
    log.columns["state.learned.std"][:, DOT] = 0.14
    log.columns["state.learned.valid"][BEGUN + 50 :, Q] = True
    summary = summarise(log)
    assert summary["learned"]["coefficients"]["M_q"]["not_valid_because"] is None
    assert summary["learned"]["coefficients"]["Y_dr"]["not_valid_because"] == "never excited"
    rows = dict(key_figures(summary)["learned"])
    assert rows["coefficients valid"] == "1 of 3"
    assert rows["why not the others"] == "never excited: Y_dr; 1 σ is over 10 %: N_dot (14 %)"
    notes = {plot.title: plot.note for plot in Figures(log)}
    assert notes["N_dot"].endswith("Why it is not valid: 1 σ is over 10 % (14 %).")
    assert "Why" not in notes["M_q"]


def test_coefficients_that_share_a_reason_stand_together() -> None:
    over = {name: Reason("1 σ is over 10 %", own) for name, own in (("Y_v", "12 %"), ("Y_r", "22 %"))}
    assert (
        grouped(over | {"N_v": Reason("never excited")})
        == "1 σ is over 10 %: Y_v (12 %), Y_r (22 %); never excited: N_v"
    )
