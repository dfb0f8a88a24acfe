"""What a report says that the vehicle could do is what guidance went by, before and after a fin was lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sternplane.logs.manoeuvrability import limits
from sternplane.logs.reading import read
from sternplane.logs.summary import summarise
from sternplane.report.flight_page import flight_page
from sternplane.report.thinning import Drawn
from sternplane.sitl.flight import FlightRequest, fly, prepare

from tests.straight_run import hold, under_way


def test_the_limits_before_and_after_a_jam_are_in_summary_and_report(tmp_path: Path) -> None:
    scenario = tmp_path / "jam.toml"
    faults = ("jam:rudder_upper=10@2", "silent:stern_port@1")
    scenario.write_text(under_way(5.0, 8.0, hold(8.0), faults=faults))
    fly(prepare(FlightRequest(scenario=str(scenario)), {}), tmp_path / "log.mcap")
    log = read(tmp_path / "log.mcap")
    summary = summarise(log)
    sound, stuck = (list(log.cycles)[k].left for k in (100, -1))
    said = summary["limits"]["turn_radius_m"]
    assert said == pytest.approx({"begin": sound.turn_radius, "worst": stuck.turn_radius, "end": stuck.turn_radius})
    assert stuck.turn_radius > 1.5 * sound.turn_radius
    assert summary["limits"]["turn_left_pct"]["end"] == pytest.approx(100.0 * stuck.turn_left)
    radius = limits(log.columns)["turn_radius_m"]
    assert (radius[0], radius[-1]) == pytest.approx((sound.turn_radius, stuck.turn_radius))
    page = flight_page(log, summary)
    assert "Limits: what the vehicle can do" in page
    assert f"{stuck.turn_radius:.3g}" in page


def test_of_a_fin_that_falls_silent_nothing_is_drawn_as_reported(tmp_path: Path) -> None:
    scenario = tmp_path / "silent.toml"
    scenario.write_text(under_way(4.0, 8.0, hold(8.0), faults=("silent:stern_port@1",)))
    fly(prepare(FlightRequest(scenario=str(scenario)), {}), tmp_path / "log.mcap")
    c = Drawn(read(tmp_path / "log.mcap"), 4000).c
    drawn = np.isfinite(c["frame.fins"])
    assert drawn[(c["t"] > 0.5) & (c["t"] < 1.9)].all()
    assert not drawn[c["t"] > 2.2, 0].any()
    assert drawn[c["t"] > 0.5, 1:].all()


def test_a_log_without_limits_has_none() -> None:
    assert limits({"t": np.zeros(3)}) == {}
