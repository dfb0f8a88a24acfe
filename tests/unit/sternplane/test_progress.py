"""Progress: a line per tenth where nobody looks on, a bar where somebody does."""

from __future__ import annotations

import io
import itertools
import math
import pickle
import re
import subprocess
import sys
from types import SimpleNamespace
from typing import Any

import pytest
from rich.cells import cell_len
from rich.console import Console
from sternplane.cli import progress
from sternplane.cli.progress import Progress

from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.order import Mode
from firmware_py.tick import Tick

CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
HIDE_CURSOR, SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"


def cycle(k: int, waypoint: int = 1, degrees: float = -90.0, events: tuple[Event, ...] = ()) -> Any:
    eta = SimpleNamespace(z=4.25, psi=math.radians(degrees))
    return SimpleNamespace(
        tick=Tick(k, 10_000_000),
        state=SimpleNamespace(eta=eta, attitude_ok=True, depth_ok=True, velocity_ok=True, candidates=()),
        reference=SimpleNamespace(waypoint=waypoint),
        mode=SimpleNamespace(mode=Mode.MISSION),
        events=events,
    )


def test_elsewhere_a_line_per_tenth() -> None:
    out = io.StringIO()
    with Progress(100.0, 5, Console(file=out, width=200)) as shown:
        for k in range(10_001):
            shown.update(cycle(k))
    lines = out.getvalue().splitlines()
    assert [round(float(line.split()[0]), 0) for line in lines] == [10, 20, 30, 40, 50, 60, 70, 80, 90]
    assert "depth  4.25 m  heading 270.0°  waypoint 2/5  mission" in lines[0]


def test_what_is_not_known_is_not_told() -> None:
    """A depth that went on without pressure was shown like one that is measured."""
    out = io.StringIO()
    with Progress(100.0, 5, Console(file=out, width=200)) as shown:
        for k in range(1_100):
            blind = cycle(k)
            blind.state.depth_ok = blind.state.attitude_ok = False
            shown.update(blind)
    assert "depth     ? m  heading     ?°  waypoint 2/5" in out.getvalue()


def test_without_a_mission_there_is_no_waypoint() -> None:
    out = io.StringIO()
    shown = Progress(1.0, 0, Console(file=out, width=200))
    for k in range(101):
        shown.update(cycle(k))
    assert "waypoint" not in out.getvalue()


def test_in_a_terminal_a_bar_no_oftener_than_it_can_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: now[0]))
    drawn: list[float] = []

    class Terminal(io.StringIO):
        def write(self, text: str) -> int:
            if "waypoint" in text:
                drawn.append(now[0])
            return super().write(text)

    out = Terminal()
    with Progress(100.0, 5, Console(file=out, width=160, force_terminal=True)) as shown:
        for k in range(5000):  # 2 s of wall time
            now[0] += 0.0004
            shown.update(cycle(k, waypoint=7))
        in_flight = drawn.copy()
    assert len(in_flight) in (15, 16)
    assert min(b - a for a, b in itertools.pairwise(in_flight)) >= 0.1
    assert "waypoint 5/5" in out.getvalue()
    assert "25.0×" in out.getvalue()


def drawn(width: int, of: Any, waypoints: int = 5) -> str:
    """The bar's line in a terminal of that width, 6 s after the beginning."""
    now, out = [0.0], io.StringIO()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: now[0]))
        with Progress(330.0, waypoints, Console(file=out, width=width, force_terminal=True)) as shown:
            for now[0] in (3.0, 6.0):  # what is heard for the first time is said before the first bar
                before = len(out.getvalue())
                for _ in range(16):  # so often it looks at the clock
                    shown.update(of)
            text = CONTROL.sub("", out.getvalue()[before:])
    (line,) = filter(None, re.split(r"[\r\n]+", text))
    assert cell_len(line) <= width
    return line


@pytest.mark.parametrize("waypoints", [0, 5, 100])
@pytest.mark.parametrize("width", [10, 20, 30, 40, 50, 60, 70, 80, 100, 200])
def test_a_bar_is_one_line_in_any_terminal(width: int, waypoints: int) -> None:
    assert drawn(width, cycle(30_123, waypoint=99), waypoints).strip()


def test_eighty_columns_show_a_bar_and_all_the_words() -> None:
    line = drawn(80, cycle(30_123))
    assert line.count("━") + line.count("╸") + line.count("╺") >= 8
    for words in ("301.2/330 s", "depth  4.25 m", "270.0°", "wp 2/5", "mission"):
        assert words in line
    assert line.rstrip().endswith("×")


def test_fifty_columns_show_the_essentials() -> None:
    line = drawn(50, cycle(30_123))
    for words in ("301/330 s", "4.25 m", "270.0°", "2/5", "mission"):
        assert words in line
    assert line.rstrip().endswith("×")


@pytest.mark.parametrize(("degrees", "shown"), [(359.96, "0.0°"), (-0.04, "0.0°"), (359.94, "359.9°"), (360.0, "0.0°")])
def test_a_heading_is_never_360(degrees: float, shown: str) -> None:
    for width in (30, 50, 80, 160):
        assert f" {shown}" in drawn(width, cycle(30_123, degrees=degrees))
        assert "360.0" not in drawn(width, cycle(30_123, degrees=degrees))


@pytest.mark.parametrize("terminal", [False, True])
def test_events_are_shown_at_once_and_stay(terminal: bool) -> None:
    out = io.StringIO()
    said = ("MISSION -> SURFACE: no good depth for 1 s", "waypoint 1 of 5 passed")
    lost = Event(
        *(EventKind.MODE_CHANGED, Severity.CRITICAL, Mode.MISSION, Mode.SURFACE, Cause.DEPTH_LOST), numbers=(1.0,)
    )
    passed = Event(EventKind.WAYPOINT_PASSED, Severity.INFO, numbers=(1.0, 5.0))
    with Progress(100.0, 5, Console(file=out, width=100, force_terminal=terminal)) as shown:
        shown.update(cycle(1))
        assert "SURFACE" not in out.getvalue()
        shown.update(cycle(1234, events=(lost, passed)))
        assert all(f"    12.34 s  {text}\n" in out.getvalue() for text in said)
    assert out.getvalue().count("SURFACE") == 1


def test_the_bar_goes_away_when_the_run_fails() -> None:
    out = io.StringIO()
    shown = Progress(1.0, 0, Console(file=out, width=100, force_terminal=True))
    with pytest.raises(KeyboardInterrupt), shown:
        raise KeyboardInterrupt
    gone = out.getvalue()
    assert gone.count(HIDE_CURSOR) == gone.count(SHOW_CURSOR) == 1
    assert gone.index(HIDE_CURSOR) < gone.index(SHOW_CURSOR)


def test_in_flight_nothing_is_loaded_any_more() -> None:
    script = (
        "import io, pickle, sys; from rich.console import Console; from sternplane.cli.progress import Progress\n"
        "lost = pickle.load(sys.stdin.buffer)\n"
        "with Progress(1.0, 0, Console(file=io.StringIO())) as shown:\n"
        "    before = set(sys.modules)\n"
        "    shown.update(lost)\n"
        "    print(sorted(set(sys.modules) - before))\n"
    )
    lost = Event(EventKind.MODE_CHANGED, Severity.NOTICE, Mode.MANUAL, Mode.HOLD, Cause.ORDERED)
    command, heard = [sys.executable, "-c", script], pickle.dumps(cycle(1, events=(lost,)))
    assert subprocess.run(command, input=heard, capture_output=True, check=True, timeout=60).stdout == b"[]\n"


@pytest.mark.parametrize(("terminal", "lines"), [(True, 2), (False, 1)])
def test_an_event_is_folded_between_words_on_a_terminal_alone(terminal: bool, lines: int) -> None:
    out = io.StringIO()
    lost = Event(
        *(EventKind.MODE_CHANGED, Severity.CRITICAL, Mode.MISSION, Mode.SURFACE, Cause.DEPTH_LOST), numbers=(1.0,)
    )
    with Progress(100.0, 5, Console(file=out, width=40, force_terminal=terminal)) as shown:
        shown.update(cycle(1234, events=(lost,)))
    said = [line for line in CONTROL.sub("", out.getvalue()).splitlines() if line.strip()]
    assert len(said) == lines
    assert " ".join(" ".join(said).split()) == "12.34 s MISSION -> SURFACE: no good depth for 1 s"
    assert not terminal or max(map(len, said)) <= 40
