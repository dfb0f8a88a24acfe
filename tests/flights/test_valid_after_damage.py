"""All fins lose half of their force, one axis named after the other: what is called valid is right all the same."""

from __future__ import annotations

import numpy as np
from sternplane.study.adaptation.courses import halved, track
from sternplane.study.cases.honesty import FAR, SHARE, judged, nothing

AT, DURATION = 30.0, 90.0


def test_no_valid_value_is_wrong() -> None:
    """Planes that were believed sound spoilt what was learned anew of rudders: valid values were up to 16 sigma off."""
    scenario = halved(track(DURATION), AT).scenario.format(adoption="true")
    completed, off, valid = judged(scenario, "npsauv2", nothing, 1000)
    damaged = np.arange(len(off)) >= len(off) * (AT + 1.0) / DURATION  # 1 s: a third of it names the first axis
    assert completed
    assert valid[-1].sum() >= 7
    assert (np.abs(off[damaged][valid[damaged]]) > FAR).mean() <= SHARE
