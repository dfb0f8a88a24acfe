"""Progress: a line per tenth where nobody looks on, a bar where somebody does."""

from __future__ import annotations

import io
import itertools
import math
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console

from firmware_py.records.order import Mode
from firmware_py.schedule import Tick
from tools import progress
from tools.progress import Progress


def cycle(k: int, waypoint: int = 1) -> Any:
    eta = SimpleNamespace(z=4.25, psi=math.radians(-90.0))
    return SimpleNamespace(
        tick=Tick(k, 10_000_000),
        state=SimpleNamespace(eta=eta),
        reference=SimpleNamespace(waypoint=waypoint),
        mode=SimpleNamespace(mode=Mode.MISSION),
    )


def test_elsewhere_a_line_per_tenth() -> None:
    out = io.StringIO()
    with Progress(100.0, 5, Console(file=out, width=200)) as shown:
        for k in range(10_001):
            shown.update(cycle(k))
    lines = out.getvalue().splitlines()
    assert [round(float(line.split()[0]), 0) for line in lines] == [10, 20, 30, 40, 50, 60, 70, 80, 90]
    assert "depth  4.25 m  heading 270.0°  waypoint 2/5  mission" in lines[0]


def test_without_a_mission_there_is_no_waypoint() -> None:
    out = io.StringIO()
    shown = Progress(1.0, 0, Console(file=out, width=200))
    for k in range(101):
        shown.update(cycle(k))
    assert "waypoint" not in out.getvalue()


def test_in_a_terminal_a_bar_no_oftener_than_it_can_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: now[0]))
    out = io.StringIO()
    shown = Progress(100.0, 5, Console(file=out, width=160, force_terminal=True))
    drawn: list[float] = []
    real = shown._bar.update

    def draw(*words: Any, **more: Any) -> None:
        drawn.append(now[0])
        real(*words, **more)

    monkeypatch.setattr(shown._bar, "update", draw)
    with shown:
        for k in range(5000):  # 2 s of wall time
            now[0] += 0.0004
            shown.update(cycle(k, waypoint=7))
    assert len(drawn) in (15, 16)
    assert min(b - a for a, b in itertools.pairwise(drawn)) >= 0.1
    assert "waypoint 5/5" in out.getvalue()
    assert "25.0×" in out.getvalue()


@pytest.mark.parametrize("width", [20, 60, 80, 100, 200])
def test_a_bar_is_one_line_in_any_terminal(width: int) -> None:
    console = Console(file=io.StringIO(), width=width, force_terminal=True)
    shown = Progress(100.0, 5, console)
    shown._bar.update(shown._task, completed=50.0, description=shown._line(cycle(5000)))  # type: ignore[arg-type]
    lines = console.render_lines(shown._bar.get_renderable(), pad=False)
    assert len(lines) == 1
    assert sum(segment.cell_length for segment in lines[0]) <= width


def test_the_bar_goes_away_when_the_run_fails() -> None:
    out = io.StringIO()
    shown = Progress(1.0, 0, Console(file=out, width=100, force_terminal=True))
    with pytest.raises(KeyboardInterrupt), shown:
        raise KeyboardInterrupt
    assert not shown._bar.live.is_started
