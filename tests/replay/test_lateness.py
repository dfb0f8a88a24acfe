"""Lateness in the summary and the report: there when the run was in real time, and only then."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from sternplane.logs import lateness_histogram
from sternplane.logs.reading import Log, read
from sternplane.logs.summary import summarise
from sternplane.logs.summary_text import key_figures
from sternplane.report.drawing import Plot
from sternplane.report.figures import Figures
from sternplane.report.flight_page import flight_page


@pytest.fixture
def late(tmp_path: Path, toy: SimpleNamespace) -> Log:
    """300 cycles: 297 are 60 us late, one 400 us, two 25 ms."""
    odd = {10: 25_000_000, 11: 25_000_000, 200: 400_000}
    return read(toy.fly(tmp_path / "log.mcap", late_ns=lambda k: odd.get(k, 60_000)))


def plot(log: Log) -> Plot:
    return next(plot for plot in Figures(log) if plot.title == "Lateness")


def test_the_summary_tells_it_as_plain_json(late: Log) -> None:
    found = summarise(late)["lateness"]
    assert (found["median_us"], found["p99_us"], found["p999_us"], found["max_us"]) == (60.0, 60.0, 25_000.0, 25_000.0)
    assert (found["slips"], sum(found["counts"])) == (2, 300)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    shown = dict(key_figures(summarise(late))["computer and links"])
    assert (shown["lateness, median"], shown["lateness, greatest"]) == ("60 µs", "25 ms")


def test_the_report_draws_every_cycle_not_only_the_thinned(late: Log) -> None:
    drawn = plot(late)
    title, note, figure = drawn[:3]
    bars, step = figure.data
    assert not drawn.over_time
    assert {text: n for text, n in zip(bars.customdata, bars.y, strict=True) if n} == {
        "50 µs to 70 µs": 297,
        "300 µs to 500 µs": 1,
        "20 ms to 30 ms": 2,
    }
    assert set(step.x) == {10_000.0}
    assert (figure.layout.xaxis.type, figure.layout.yaxis.type) == ("log", "log")
    assert note.endswith("99.9 % within 25 ms, the latest 25 ms; 2 of 300 slipped by more than a step.")
    page = flight_page(late, summarise(late))
    assert f"<h2>{title}</h2>" in page
    assert note in page


def test_bars_stand_where_their_edges_are(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap", late_ns=lambda k: 1_000 * (k % 100)))
    found = lateness_histogram.of_log(log)
    assert found is not None
    bars = plot(log).figure.data[0]
    x, width = np.array(bars.x), np.array(bars.width)
    assert x[1:] + width[1:] / 2 == pytest.approx(found.edges_us[2:])
    assert x[1:] - width[1:] / 2 == pytest.approx(found.edges_us[1:-1])
    assert x[0] - width[0] / 2 > 0.0, "a logarithmic axis has no 0"


def test_a_run_that_was_not_in_real_time_has_none(flown: Path) -> None:
    log = read(flown)
    summary = summarise(log)
    assert summary["lateness"] is None
    assert not any("lateness" in words for words, _ in key_figures(summary)["computer and links"])
    assert "Lateness" not in [plot.title for plot in Figures(log)]
