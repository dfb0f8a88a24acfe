"""Eddies between two intensities of the bank: no filter is right, and what is called valid is right all the same."""

from __future__ import annotations

import numpy as np
from sternplane.study.cases.honesty import FAR, REMUS, SCENARIO, judged, nothing

WATER = "current_ned_m_s = [0.06, 0.08, 0.0]\nturbulence_m_s = 0.03"


def test_no_valid_value_is_wrong() -> None:
    """By the likeliest filter alone, that of 0.02 m/s, M_ds was 7 sigma off and N_v 4, with the file right."""
    flown = {"u": REMUS.u, "n": REMUS.n, "fins": REMUS.fins, "register": 112}
    _, off, valid = judged(SCENARIO.format(water=WATER, duration=150.0, **flown), REMUS.folder, nothing, 1000)
    assert valid[-1].sum() >= 6
    assert np.abs(off[valid]).max() < FAR
