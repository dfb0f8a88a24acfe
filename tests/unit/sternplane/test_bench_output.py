"""What the bench tools print: on a terminal nothing is wider than it, nothing is cut anywhere, JSON is JSON."""

from __future__ import annotations

import io
import json
import math
from typing import NamedTuple

import pytest
from rich.console import Console
from sternplane.hardware.output import GOOD, Row, Sheet, plain, show, show_json

SHEET = Sheet("a bus", ("node>", "name*", "state", "last*"), [Row(("7", "n" * 40, "fresh", "[v] " * 40), GOOD)])


def printed(width: int, terminal: bool) -> str:
    out = io.StringIO()
    show(Console(file=out, width=width, force_terminal=terminal, color_system=None), [SHEET], ["[all] is well"])
    return out.getvalue()


@pytest.mark.parametrize("width", [40, 60, 80, 120, 400])
def test_a_table_fits_its_terminal_and_loses_nothing(width: int) -> None:
    text = printed(width, terminal=True)
    assert max(map(len, text.splitlines())) <= width
    assert "fresh" in text
    assert "[all] is well" in text
    assert (text.count("n") - "name node".count("n"), text.count("[v]")) == (40, 40)
    assert ("n" * 40 in text) == (width >= 120)


def test_where_not_even_folded_columns_fit_each_cell_has_a_line_of_its_own() -> None:
    out = io.StringIO()
    rows = [Row(("12", "rudder_upper", "-23.0°", "as seen from behind"), GOOD), Row(("", "rudder_lower", "1.0°", ""))]
    sheet = Sheet("fins", ("node>", "fin", "told>", "trailing edge*"), rows)
    show(Console(file=out, width=30, force_terminal=True, color_system=None), [sheet])
    assert [line.split() for line in out.getvalue().splitlines() if line.strip()] == [
        ["fins"],
        ["node", "12"],
        ["fin", "rudder_upper"],
        ["told", "-23.0°"],
        ["trailing", "edge", "as", "seen", "from"],
        ["behind"],
        ["fin", "rudder_lower"],
        ["told", "1.0°"],
    ]


def test_titles_are_folded_before_cells() -> None:
    out = io.StringIO()
    sheet = Sheet("", ("fin", "turns at>", "points*"), [Row(("rudder_upper", "60°/s", "to starboard, from behind"))])
    show(Console(file=out, width=46, force_terminal=True, color_system=None), [sheet])
    first, second, _, row = (line.rstrip() for line in out.getvalue().splitlines() if line.strip())
    assert (first.split(), second.split()) == (["turns"], ["fin", "at", "points"])
    assert row.split("  ") == ["rudder_upper", "60°/s", "to starboard, from behind"]


def test_in_a_pipe_nothing_is_cut_and_columns_stand_below_their_titles() -> None:
    title, head, row, sentence = printed(20, terminal=False).splitlines()
    assert (title, sentence) == ("a bus", "[all] is well")
    assert row.rstrip().endswith("[v]")
    assert "n" * 40 in row
    assert head.index("state") == row.index("fresh")


class Two(NamedTuple):
    a: float
    b: bytes


def test_json_has_no_nan_and_no_bytes() -> None:
    out = io.StringIO()
    found = {"x": [math.nan, math.inf, 1.5], "two": Two(-math.inf, b"abc"), "raw": b"\x00\xff", 7: True}
    show_json(Console(file=out), found)
    told = {"x": [None, None, 1.5], "two": {"a": None, "b": "abc"}, "raw": "00ff", "7": True}
    assert json.loads(out.getvalue()) == told == plain(found)


EVIL = "evil\x1b[2J\x1b]0;owned\x07\n[/red]\x9b1m\u202ex\r"


@pytest.mark.parametrize("terminal", [True, False])
def test_what_a_device_calls_itself_moves_no_cursor_and_breaks_no_table(terminal: bool) -> None:
    out = io.StringIO()
    sheet = Sheet("a bus", ("node>", "name*"), [Row(("7", EVIL), GOOD), Row(("8", "plain"))])
    show(
        Console(file=out, width=200, force_terminal=terminal, color_system=None), [sheet], [f"node 7 ({EVIL}) is there"]
    )
    text = out.getvalue()
    assert [one for one in text if not one.isprintable()] == ["\n"] * text.count("\n")
    assert text.count("evil\\x1b[2J\\x1b]0;owned\\x07\\n[/red]\\x9b1m\\u202ex\\r") == 2
    assert len([line for line in text.splitlines() if "evil" in line or "plain" in line]) == 3


def test_json_shows_it_so_too() -> None:
    out = io.StringIO()
    show_json(Console(file=out), {EVIL: [EVIL, {"name": EVIL}]}, indent=None)
    [line] = out.getvalue().splitlines()
    assert line.isprintable()
