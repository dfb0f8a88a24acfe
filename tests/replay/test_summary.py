"""The figures of a run, against what the toy's formulas say."""

from __future__ import annotations

import io
import itertools
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from tools.log import read
from tools.summary import figures, summarise, table, verdict

HELD = np.arange(200, 300) * 0.01
"""The toy flies its mission from 2 s on; it is armed from 1 s on."""


def test_figures_of_a_run_with_truth(flown: Path) -> None:
    s = summarise(read(flown))
    assert (s["completed"], s["reason"], s["against"]) == (True, "surfaced", "truth")
    assert (s["vehicle_time_s"], s["wall_time_s"], s["speed_up"]) == pytest.approx((3.0, 0.5, 6.0))
    assert (s["cycles"], s["complete"], s["lost"]) == (300, True, "")
    assert s["depth_error_rms_m"] == pytest.approx(4.0 * math.sqrt(np.mean(np.exp(-HELD / 6.0) ** 2)), rel=1e-9)
    assert s["heading_error_rms_deg"] == pytest.approx(0.0, abs=1e-9)
    assert s["cross_track_rms_m"] == pytest.approx(math.sqrt(np.mean(np.sin(HELD[1:]) ** 2)), rel=1e-9)
    assert s["cross_track_max_m"] == pytest.approx(math.sin(2.01), rel=1e-9)
    assert s["depth_max_m"] == pytest.approx(4.0 - 4.0 * math.exp(-2.99 / 6.0))
    # The estimate runs ahead by the integral of gain sin(psi), and stays behind to the east by 1 cm/s.
    ahead = 0.25 * (1.0 - math.cos(0.02 * 2.99)) / 0.02
    assert s["navigation_error_end_m"] == pytest.approx(math.hypot(ahead, 0.0299), abs=2e-3)
    assert s["navigation_error_max_m"] >= s["navigation_error_end_m"]


def test_fin_travel_is_the_total_variation_over_the_time_armed(flown: Path) -> None:
    def way(i: int) -> float:
        """Degrees: the jump to the first angle at 1 s, then from turning point to turning point."""
        turning = [t for n in range(-9, 9) if 1.0 < (t := (math.pi * (n + 0.5) - i) / 0.3) < 2.99]
        angles = [0.0, *(8.0 * math.sin(0.3 * t + i) for t in (1.0, *turning, 2.99))]
        return sum(abs(b - a) for a, b in itertools.pairwise(angles))

    expected = sum(way(i) for i in range(4)) / 4 / 2.0
    assert summarise(read(flown))["fin_travel_deg_s"] == pytest.approx(expected, rel=1e-4)


def test_a_sea_log_has_no_truth_and_says_so(tmp_path: Path, toy: SimpleNamespace) -> None:
    s = summarise(read(toy.fly(tmp_path / "log.mcap", truth=False)))
    assert s["against"] == "estimate"
    assert s["navigation_error_end_m"] is None
    assert s["navigation_error_max_m"] is None
    assert s["depth_error_rms_m"] == pytest.approx(4.0 * math.sqrt(np.mean(np.exp(-HELD / 5.0) ** 2)), rel=1e-9)


def test_a_truth_that_is_logged_less_often_is_held(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = read(toy.fly(tmp_path / "log.mcap"))
    topic = log.topics["/truth"]
    del topic.times[1::2], topic.messages[1::2]
    s = summarise(log)
    assert s["against"] == "truth"
    z = 4.0 - 4.0 * np.exp(-np.floor(HELD / 0.02 + 1e-9) * 0.02 / 6.0)
    assert s["depth_error_rms_m"] == pytest.approx(math.sqrt(np.mean((4.0 - z) ** 2)), rel=1e-9)


def test_late_cycles_are_those_more_than_a_step_late(tmp_path: Path, toy: SimpleNamespace) -> None:
    path = toy.fly(tmp_path / "log.mcap", late_ns=lambda k: 10_000_001 if k % 100 == 7 else 10_000_000)
    assert summarise(read(path))["late_cycles"] == 3


def test_waypoints_passed(tmp_path: Path, toy: SimpleNamespace, flown: Path) -> None:
    assert [summarise(read(flown))[f"waypoints_{name}"] for name in ("passed", "total")] == [0, 3]
    s = summarise(read(toy.fly(tmp_path / "log.mcap", 50.0)))
    assert (s["waypoints_passed"], s["waypoints_total"]) == (1, 3)
    s = summarise(read(toy.fly(tmp_path / "log.mcap", 111.0)))
    assert (s["waypoints_passed"], s["waypoints_total"]) == (3, 3)


def test_a_log_that_was_cut_off_is_not_completed(flown: Path, tmp_path: Path) -> None:
    data = flown.read_bytes()
    (tmp_path / "log.mcap").write_bytes(data[: len(data) // 2])
    s = summarise(read(tmp_path / "log.mcap"))
    assert not s["completed"]
    assert verdict(s).startswith("not completed: the log is cut off; recovered up to ")
    assert s["speed_up"] is None


def test_one_cycle_and_no_order_are_enough(tmp_path: Path, toy: SimpleNamespace) -> None:
    s = summarise(read(toy.fly(tmp_path / "log.mcap", 0.01)))
    assert s["cycles"] == 1
    assert s["depth_error_rms_m"] is None
    assert s["fin_travel_deg_s"] is None


def test_the_table_shows_what_is_known(flown: Path) -> None:
    summary = summarise(read(flown))
    out = io.StringIO()
    Console(file=out, width=80).print(table(summary))
    for words in ("completed", "vehicle time", "3.0 s", "0 of 3", "°/s"):
        assert words in out.getvalue()
    assert len(figures({**summary, "speed_up": None})) == len(figures(summary)) - 1
