"""What the command prints of people's, files' and logs' texts: as they are, and nothing of it acts on a terminal."""

from __future__ import annotations

import io

import pytest
from rich.padding import Padding
from rich.table import Table
from rich.text import Text
from sternplane.plain_console import PlainConsole


def test_texts_are_no_markup_and_send_no_escape_sequence() -> None:
    out = io.StringIO()
    console = PlainConsole(file=out, width=200, force_terminal=True, color_system=None)
    table = Table(box=None)
    table.add_column("[/head]\x1b[2J")
    table.add_row("[bold]:smile:\x07", style="red")
    console.print("runs/[/x]\x1b[31m", Text("told", style="bold"))
    console.print(table)
    console.print("two\nlines", highlight=False, soft_wrap=True)
    said = out.getvalue()
    for shown in (r"runs/[/x]\x1b[31m told", r"[/head]\x1b[2J", r"[bold]:smile:\x07", "two\nlines\n"):
        assert shown in said
    assert "\x1b" not in said
    assert "\x07" not in said


def test_in_a_pipe_no_line_is_wrapped_or_filled_up_and_on_a_terminal_none_is_wider(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    words = "jammed, at 68.4 s, and not believed from then on, in all 12 s"
    for terminal in (False, True):
        out = io.StringIO()
        table = Table(box=None, show_header=False)
        table.add_column()
        table.add_column(overflow="fold")
        table.add_row("rudder_upper", words)
        table.add_row("a", "b")
        PlainConsole(file=out, force_terminal=terminal, color_system=None).print(table, Padding("end", (0, 2)))
        lines = out.getvalue().splitlines()
        if terminal:
            assert max(map(len, lines)) <= 40
        else:
            assert [line.split(None, 1) for line in lines] == [["rudder_upper", words], ["a", "b"], ["end"]]
            assert lines == [line.rstrip() for line in lines]


def test_what_is_captured_from_a_console_in_a_pipe_does_not_come_out_of_it() -> None:
    file = io.StringIO()
    console = PlainConsole(file=file)
    with console.capture() as caught:
        console.print("within  ")
    console.print("behind")
    assert (caught.get(), file.getvalue()) == ("within\n", "behind\n")
