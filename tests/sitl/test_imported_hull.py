"""A hull that does not hold its course by itself, made from a published table: what is called valid of it is right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from sternplane.cli.main import main
from sternplane.study.cases.honesty import FAR, judged, nothing

TABLE = Path(__file__).parents[1] / "unit" / "sternplane" / "published" / "prestero.csv"


def test_no_valid_value_is_wrong(tmp_path: Path) -> None:
    """When another coefficient began to learn the current was let walk; N_v went to -93 %, 61 sigma, and was valid."""
    hull = tmp_path / "hull"
    assert main(["vehicle", "import", str(TABLE), "--out", str(hull)]) == 0
    whole = (hull / "first_flight.toml").read_text()
    mission = whole.replace("duration_s = 330.0", "duration_s = 120.0").replace('"surfaced"', '"time"')
    assert mission.count("120.0") == mission.count('"time"') == 1
    _, off, valid = judged(mission, str(hull), nothing, 1)
    assert valid[-1].sum() >= 6
    assert np.abs(off[valid]).max() < FAR
