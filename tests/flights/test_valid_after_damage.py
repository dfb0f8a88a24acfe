"""All fins lose half of their force, one axis named after the other: what is called valid is right all the same."""

from __future__ import annotations

import numpy as np
from sternplane.study.adaptation.courses import halved, track
from sternplane.study.cases.honesty import FAR, SHARE, judged, nothing
from sternplane.study.safety.mission import scenario as dive

from firmware_py.estimation.coefficient_params import TEN

AT, DURATION = 30.0, 90.0


def test_no_valid_value_is_wrong() -> None:
    """Planes that were believed sound spoilt what was learned anew of rudders: valid values were up to 16 sigma off."""
    scenario = halved(track(DURATION), AT).scenario.format(adoption="true")
    completed, off, valid = judged(scenario, "npsauv2", nothing, 1000)
    damaged = np.arange(len(off)) >= len(off) * (AT + 1.0) / DURATION  # 1 s: a third of it names the first axis
    assert completed
    assert valid[-1].sum() >= 7
    assert (np.abs(off[damaged][valid[damaged]]) > FAR).mean() <= SHARE


def test_planes_are_not_valid_after_lost_rudders_before_a_pass_confirms_them() -> None:
    """M_ds was, 5 s after the rudders were named: 1.9 times what it is, 9 sigma off, and corrected a second later."""
    text = dive(("lost:rudder_upper@100", "lost:rudder_lower@100"), duration=135.0)
    _, off, valid = judged(text, "npsauv2", nothing, 1000)
    planes, named = [TEN.index("M_q"), TEN.index("M_ds")], round(len(off) * 103.0 / 135.0)
    assert valid[-1, planes].all()
    assert (np.abs(off[named:, planes])[valid[named:, planes]] < FAR).all()
