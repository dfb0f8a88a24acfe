"""What the command prints of people's, files' and logs' texts: as they are, and nothing of it acts on a terminal."""

from __future__ import annotations

import io

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
