"""The demonstration, whole: its vehicle file is 40 % off, the vehicle learns, and its laws use what it learned."""

from __future__ import annotations

from sternplane.logs.summary import summarise

from tests.shared_flights import Flights


def test_the_demonstration_learns_adopts_and_flies_better_for_it(flown: Flights) -> None:
    outcome, log = flown("demo")
    assert outcome.completed
    adoption = summarise(log)["adoption"]
    assert adoption is not None
    for law in adoption["laws"].values():
        assert law["adopted_s"] < 150.0
        assert law["rms_after"] < law["rms_before"]
    assert adoption["laws"]["depth"]["rms_after"] < 0.06
    errors = adoption["coefficients"].values()
    assert {round(abs(one["error_before_pct"]), 6) for one in errors} == {40.0}
    assert max(abs(one["error_after_pct"]) for one in errors) < 20.0
    turning = [adoption["coefficients"][name]["error_after_pct"] for name in ("M_q", "M_ds", "N_r", "N_dr")]
    assert max(map(abs, turning)) < 8.0
