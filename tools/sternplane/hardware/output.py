"""How a bench tool shows what it found: tables in colour on a terminal, plain columns in a pipe, or JSON.

Whatever is shown may hold what a device said of itself, and is made visible here.
"""

from __future__ import annotations

import contextlib
import json
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text

from firmware_py.foreign_text import text_or_hex, visible
from firmware_py.run.usage_error import UsageError

_REDRAW_S = 0.25
_GAP = "  "
"""Between two columns."""
_LONG_WORD = 16
"""Words of a folded cell are broken only where they have more characters than this."""
GOOD, DOUBTFUL, BAD, PLAIN = "green", "yellow", "red", ""
"""How a row looks on a terminal."""


class Row(NamedTuple):
    """A row of a table: its cells, and how it looks on a terminal."""

    cells: Sequence[str]
    look: str = PLAIN


class Sheet(NamedTuple):
    """A table.

    Attributes:
        title: what it is of; "" for none.
        columns: their titles; one that ends with ">" is aligned to the right, one with "*" has cells that may be folded
            where the terminal is narrow. Where that is not enough, every row becomes lines of title and cell.
        rows: from the top.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Row]


def console() -> Console:
    """Return where tables go: stdout."""
    return Console(highlight=False)


@contextlib.contextmanager
def written() -> Iterator[None]:
    """Turn a failure to write what is told into an error in one line; a pipe whose reader has left is none.

    Raises:
        UsageError: the disk is full, or the like.
    """
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        sys.stdout = None  # what waits in it could not be written at the end either
        raise UsageError(f"the output cannot be written: {error.strerror or error}") from None


def show(where: Console, sheets: Iterable[Sheet], sentences: Iterable[str] = ()) -> None:
    """Print tables, and sentences below them; raises as `written`."""
    with written():
        if where.is_terminal:
            where.print(_drawn(sheets, where.width))
        else:
            for sheet in sheets:
                _say(where, [*([sheet.title] if sheet.title else []), *_aligned(sheet)])
        _say(where, sentences)


def show_json(where: Console, found: Mapping[str, Any], indent: int | None = 2) -> None:
    """Print JSON; what is not finite is null, bytes are text or hexadecimal digits. Raises as `written`."""
    with written():
        where.out(json.dumps(plain(found), indent=indent, ensure_ascii=False), highlight=False)


def plain(value: Any) -> Any:
    """Return a value in the types of JSON."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, bytes):
        return text_or_hex(value)
    if isinstance(value, str):
        return visible(value)
    if isinstance(value, Mapping):
        return {visible(str(key)): plain(one) for key, one in value.items()}
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if isinstance(value, Iterable):
        return [plain(one) for one in value]
    return value


@contextlib.contextmanager
def live(where: Console, sheets: Callable[[], Iterable[Sheet]], wanted: bool = True) -> Iterator[Callable[[], None]]:
    """Yield what is to be called often: on a terminal it draws the tables anew, a few times a second.

    At the end the drawing is gone; `show` prints the tables for good.
    """
    if not (wanted and where.is_terminal):
        yield lambda: None
        return
    drawn = -math.inf
    with Live(console=where, auto_refresh=False, transient=True, vertical_overflow="ellipsis") as screen:

        def draw() -> None:
            nonlocal drawn
            if (now := time.monotonic()) - drawn >= _REDRAW_S:
                drawn = now
                screen.update(_drawn(sheets(), where.width, where.height), refresh=True)

        yield draw


def _drawn(sheets: Iterable[Sheet], width: int, most: int | None = None) -> RenderableType:
    """Return tables for a terminal; `most` rows of each, where no more can be seen."""
    return Group(*[_shown(sheet._replace(rows=sheet.rows[:most]), width) for sheet in sheets])


def _shown(sheet: Sheet, width: int) -> RenderableType:
    widths = _fitting(sheet, width)
    return _table(sheet, widths) if sum(widths) <= _room(sheet, width) else _stacked(sheet)


def _table(sheet: Sheet, widths: Sequence[int]) -> Table:
    table = Table(
        title=sheet.title or None,
        title_justify="left",
        title_style="bold",
        box=SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, len(_GAP) - 1, 0, 0),  # and the line between two columns
    )
    for column, wide in zip(sheet.columns, widths, strict=True):
        table.add_column(
            Text(_titled(column)), justify="right" if column.endswith(">") else "left", width=wide, overflow="fold"
        )
    for cells, look in sheet.rows:
        table.add_row(*[Text(visible(cell)) for cell in cells], style=look or None)
    return table


def _stacked(sheet: Sheet) -> Group:
    """Return the rows below each other: each cell in a line of its own, behind its title."""
    parts: list[RenderableType] = [Text(sheet.title, style="bold")] if sheet.title else []
    for cells, look in sheet.rows:
        table = Table.grid(padding=(0, len(_GAP), 0, 0), pad_edge=False)
        table.add_column(no_wrap=True, style="dim")
        table.add_column(overflow="fold")
        for column, cell in zip(sheet.columns, cells, strict=True):
            if cell:
                table.add_row(_titled(column), Text(visible(cell), style=look))
        parts += [table, Text()]
    return Group(*parts)


def _titled(column: str) -> str:
    return column.rstrip(">*")


def _room(sheet: Sheet, width: int) -> int:
    return width - len(_GAP) * (len(sheet.columns) - 1)


def _fitting(sheet: Sheet, width: int) -> list[int]:
    """Return how wide each column is on a terminal: titles are folded first, then the widest of what may be."""
    widths, room = _widths(sheet), _room(sheet, width)
    if sum(widths) <= room:
        return widths
    unbroken = [max((_longest_word(title), *map(len, cells))) for title, *cells in _columns(sheet)]
    least = [
        min(max(map(_longest_word, column)), _LONG_WORD) if name.endswith("*") else wide
        for name, column, wide in zip(sheet.columns, _columns(sheet), unbroken, strict=True)
    ]
    while sum(widths) > room and widths != least:
        i = max(range(len(widths)), key=lambda i: (widths[i] > unbroken[i], widths[i] > least[i], widths[i]))
        widths[i] -= 1
    return widths


def _widths(sheet: Sheet) -> list[int]:
    """Return how wide each column is, if nothing is folded."""
    return [max(map(len, column)) for column in _columns(sheet)]


def _columns(sheet: Sheet) -> list[tuple[str, ...]]:
    """Return title and cells of each column."""
    titles = [_titled(column) for column in sheet.columns]
    return [*zip(titles, *([*map(visible, row.cells)] for row in sheet.rows), strict=True)]


def _longest_word(text: str) -> int:
    return max(map(len, text.split()), default=0)


def _aligned(sheet: Sheet) -> Iterator[str]:
    """Yield the lines of a table without a frame; nothing in it is cut."""
    widths = _widths(sheet)
    for row in ([_titled(column) for column in sheet.columns], *([*map(visible, row.cells)] for row in sheet.rows)):
        cells = [
            cell.rjust(width) if title.endswith(">") else cell.ljust(width)
            for cell, width, title in zip(row, widths, sheet.columns, strict=True)
        ]
        yield _GAP.join(cells).rstrip()


def _say(where: Console, lines: Iterable[str]) -> None:
    for line in lines:
        where.print(visible(line), highlight=False, markup=False, soft_wrap=not where.is_terminal)
