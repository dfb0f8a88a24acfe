"""Fence and rally points in the plan view of a report: those that were in force, and when."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sternplane.logs.reading import Log, read
from sternplane.report import areas
from sternplane.report.drawing import Plot
from sternplane.report.figures import Figures

from firmware_py.records.fence import Disc, Fence, Place, Polygon, fence_to_plain
from firmware_py.records.mission import Mission
from firmware_py.records.order import Change, FenceChange, MissionChange, RallyChange

BAY = Polygon(((-20.0, -50.0), (-20.0, 70.0), (80.0, 70.0), (80.0, -50.0)))
POND, ROCK, REEF = Disc(90.0, 0.0, 30.0), Disc(30.0, 30.0, 5.0), Polygon(((40.0, 0.0), (50.0, 0.0), (45.0, 10.0)))


def logged(folder: Path, toy: SimpleNamespace, changes: dict[int, tuple[Change, ...]], **configuration: Any) -> Log:
    """The log of a vehicle that began with that configuration, and of what stations changed, by time, ns."""
    log = read(toy.fly(folder / "log.mcap", 3.0))
    log.header["configuration"] |= configuration
    log.__dict__["changes"] = changes
    return log


def plan(log: Log) -> Plot:
    return next(plot for plot in Figures(log) if plot.title == "Plan view")


def drawn(log: Log) -> dict[str, Any]:
    return {t.name: t for t in plan(log).figure.data if t.name.startswith(("fence", "rally"))}


def rings(trace: Any) -> list[np.ndarray]:
    """Corners (north, east) of each line of a trace."""
    places = np.column_stack((trace.y, trace.x)).astype(float)
    return [ring[np.isfinite(ring[:, 0])] for ring in np.split(places, np.flatnonzero(np.isnan(places[:, 0])))]


def test_what_the_vehicle_began_with_is_drawn_and_told_apart(tmp_path: Path, toy: SimpleNamespace) -> None:
    fence = fence_to_plain(Fence((BAY, POND), (ROCK, REEF)))
    found = drawn(logged(tmp_path, toy, {}, fence=fence, rally={"points": [[10.0, -40.0], [60.0, 60.0]]}))
    assert list(found) == ["fence, inclusion", "fence, exclusion", "rally points"]
    bay, pond = rings(found["fence, inclusion"])
    assert bay.tolist() == [*map(list, BAY.corners), list(BAY.corners[0])]
    assert np.hypot(*(pond - [90.0, 0.0]).T) == pytest.approx(30.0, abs=1e-4)
    rock, reef = rings(found["fence, exclusion"])
    assert np.hypot(*(rock - [30.0, 30.0]).T) == pytest.approx(5.0, abs=1e-4)
    assert len(reef) == 4
    inside, outside = (found[f"fence, {side}"] for side in ("inclusion", "exclusion"))
    assert inside.line.color != outside.line.color
    assert (inside.line.dash, outside.line.dash) == ("dash", "solid")
    assert (inside.fillpattern.shape, outside.fillpattern.shape) == (None, "/")
    assert rings(found["rally points"])[0].tolist() == [[10.0, -40.0], [60.0, 60.0]]


def test_nothing_is_drawn_where_there_is_none(tmp_path: Path, toy: SimpleNamespace) -> None:
    assert drawn(logged(tmp_path, toy, {})) == {}
    empty = {"fence": fence_to_plain(Fence()), "rally": {"points": []}}
    assert drawn(logged(tmp_path, toy, {10_000_000: (FenceChange(Fence()), RallyChange(()))}, **empty)) == {}
    assert plan(logged(tmp_path, toy, {})).note == "Local frame; scales are equal."


def test_what_stations_changed_is_drawn_for_as_long_as_it_stood(tmp_path: Path, toy: SimpleNamespace) -> None:
    first, second = Fence((BAY,)), Fence((BAY,), (ROCK,))
    changes: dict[int, tuple[Change, ...]] = {
        1_000_000_000: (RallyChange((Place(10.0, -40.0),)), FenceChange(first)),  # the same once more
        1_500_000_000: (MissionChange(Mission()),),
        2_000_000_000: (FenceChange(second),),
    }
    found = drawn(logged(tmp_path, toy, changes, fence=fence_to_plain(first)))
    assert list(found) == [
        "fence, inclusion, until 2.0 s",
        "fence, inclusion, from 2.0 s",
        "fence, exclusion, from 2.0 s",
        "rally points, from 1.0 s",
    ]
    assert found["fence, inclusion, until 2.0 s"].opacity < found["fence, inclusion, from 2.0 s"].opacity == 1.0
    changes[2_500_000_000] = (FenceChange(Fence()),)
    found = drawn(logged(tmp_path, toy, changes, fence=fence_to_plain(first)))
    assert list(found)[1:3] == ["fence, inclusion, from 2.0 s until 2.5 s", "fence, exclusion, from 2.0 s until 2.5 s"]


def test_a_fence_of_a_hundred_kilometres_does_not_hide_the_vehicle(tmp_path: Path, toy: SimpleNamespace) -> None:
    log = logged(tmp_path, toy, {}, fence=fence_to_plain(Fence((Disc(0.0, 0.0, 1e5),))))
    plot = plan(log)
    for axis in (plot.figure.layout.xaxis, plot.figure.layout.yaxis):
        ends = axis.autorangeoptions.clipmin, axis.autorangeoptions.clipmax
        assert ends[1] - ends[0] < 1000.0
        assert ends[0] < 0.0 < ends[1]
    assert plot.note.endswith("The fence or a rally point is beyond the plot.")
    near = logged(tmp_path, toy, {}, fence=fence_to_plain(Fence((BAY,))))
    assert plan(near).note == "Local frame; scales are equal."
    assert [fence.when for fence in areas.fences(near)] == [""]
