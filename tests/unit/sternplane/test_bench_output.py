"""What the bench tools print: on a terminal nothing is wider than it, in a pipe nothing is cut, JSON is JSON."""

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


@pytest.mark.parametrize("width", [60, 80, 120, 400])
def test_a_table_fits_its_terminal_and_keeps_what_may_not_be_cut(width: int) -> None:
    text = printed(width, terminal=True)
    assert max(map(len, text.splitlines())) <= width
    assert "fresh" in text
    assert "[all] is well" in text
    assert ("n" * 40 in text) == (width >= 120)


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
