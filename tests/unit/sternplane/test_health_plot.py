"""The plot of health: what it shows of water in the hull, and what it says of all that it does not show."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sternplane.logs.health_record import HealthRecord
from sternplane.logs.reading import Piece
from sternplane.report.health_plot import health_plot

go = pytest.importorskip("plotly.graph_objects")


def record(leak: list[bool]) -> HealthRecord:
    t = 0.1 * np.arange(len(leak))
    columns: Any = {
        "t": t,
        "tick.dt_ns": np.full(len(leak), 100_000_000),
        "state.leak": np.array(leak),
        "mode.ascent": np.zeros(len(leak), dtype=int),
    }
    log: Any = SimpleNamespace(header={})
    health = HealthRecord(log)
    health.add(Piece(0, columns, {}))
    return health


def test_water_in_the_hull_is_shown_and_nothing_else_is_said_to_be_good() -> None:
    plot = health_plot(record([False] * 10 + [True] * 10), go.Figure())
    assert plot is not None
    bars = {str(text): str(bar.y[i]) for bar in plot.figure.data for i, text in enumerate(bar.text)}
    assert bars == {"water in the hull": "hull"}
    assert "All else" not in plot.note
    assert plot.note.endswith("All other sensors and actuators were good throughout.")


def test_a_dry_vehicle_of_which_all_is_good_has_no_plot() -> None:
    assert health_plot(record([False] * 20), go.Figure()) is None
