"""Hulls made from published tables: what is called valid of one that does not hold its course; a quick one turns."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from sternplane.cli.main import main
from sternplane.study.cases.honesty import FAR, judged, nothing

PUBLISHED = Path(__file__).parents[1] / "unit" / "sternplane" / "published"
TABLE = PUBLISHED / "prestero.csv"


def test_no_valid_value_is_wrong(tmp_path: Path) -> None:
    """When another coefficient began to learn the current was let walk; N_v went to -93 %, 61 sigma, and was valid."""
    hull = tmp_path / "hull"
    assert main(["vehicle", "import", str(TABLE), "--out", str(hull)]) == 0
    whole = (hull / "first_flight.toml").read_text()
    mission = whole.replace("duration_s = 330.0", "duration_s = 120.0").replace('"surfaced"', '"time"')
    assert mission.count("120.0") == mission.count('"time"') == 1
    _, off, valid = judged(mission, str(hull), nothing, 2)
    assert valid[-1].sum() >= 6
    assert np.abs(off[valid]).max() < FAR


TURN = """
description = "Hold 4 m, and turn."
duration_s = 80
completes = "time"
orders = [
    {t_s = 1, arming = "arm"},
    {t_s = 2, mode = "hold", depth_m = 4, heading_deg = 0, speed_m_s = 1.4},
    {t_s = 50, heading_deg = 90},
]
[environment]
turbulence_m_s = 0.02
"""


def test_a_small_quick_hull_turns_with_its_reference(tmp_path: Path) -> None:
    """Poles by size and speed alone left it more than twice as far behind: its own are up to eight times as fast."""
    hull, scenario, run = tmp_path / "hull", tmp_path / "turn.toml", tmp_path / "run"
    scenario.write_text(TURN)
    assert main(["vehicle", "import", str(PUBLISHED / "lauv.csv"), "--out", str(hull)]) == 0
    words = ["--config", str(hull), "--scenario", str(scenario), "--out", str(run), "--no-report"]
    assert main(["sitl", *words, "--set", "autopilot.control.adoption.enabled=false"]) == 0
    summary = json.loads((run / "summary.json").read_text())
    assert summary["heading_tracking_error_rms_deg"] < 1.6
