"""The page of every report: one HTML file with its style, scripts and plots inside, so that it opens without a network.

A page is a title with a status, key figures, and sections of text, tables and plots; `page.html` lays them out.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import plotly.offline
from markupsafe import Markup, escape

from sternplane.report.drawing import Plot

_HERE = Path(__file__).parent
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""What the browser may load: nothing that is not in the page."""
_LAYOUT: dict[str, Any] = {
    "template": "none",
    "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "#94a3b8", "activecolor": "#2563eb"},
    "margin": {"l": 60, "r": 12, "t": 30, "b": 42},
    "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "font": {"size": 11}},
    "font": {"family": "system-ui, DejaVu Sans, sans-serif", "size": 12, "color": "#334155"},
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "rgba(0,0,0,0)",
}
_AXIS = {"gridcolor": "#e2e8f0", "zerolinecolor": "#cbd5e1", "linecolor": "#cbd5e1", "ticks": "outside", "ticklen": 3}


class Cell(NamedTuple):
    """A cell of a table: its text, and "good", "warn", "bad", "head", "note" or ""; `span` columns wide."""

    text: str
    state: str = ""
    span: int = 1


class Table(NamedTuple):
    """Rows of cells, each a `Cell` or a text, below a head; `style` is "numbers" (to the right), "words" or "log"."""

    rows: Sequence[Sequence[Any]]
    head: Sequence[str] = ()
    caption: str = ""
    style: str = "words"


class Section(NamedTuple):
    """A box of a page: notes, text (HTML from a template), tables and a plot below one title.

    Attributes:
        title: its heading.
        notes: sentences below the heading.
        text: HTML that a template made.
        tables: see `Table`.
        plot: a plot; its own title and note are not shown again.
        wide: it takes the whole width.
        anchor: what a link leads to.
    """

    title: str
    notes: Sequence[str] = ()
    text: Markup = Markup()
    tables: Sequence[Table] = ()
    plot: Plot | None = None
    wide: bool = False
    anchor: str = ""

    @property
    def tall(self) -> bool:
        """It stands beside two others."""
        return self.plot is not None and self.plot.tall and not self.wide


class Heading(NamedTuple):
    """A heading across the page, above the sections that follow it."""

    title: str
    note: str = ""
    anchor: str = ""


@dataclass(frozen=True)
class Page:
    """What a page shows.

    Attributes:
        title: of the page.
        status: one phrase beside the title, in the colour of `mood`: "good", "warn", "bad" or "neutral".
        mood: see status.
        sections: the boxes, in order.
        description: a sentence or two below the title.
        identity: what was measured and by which revision; shown small, one line each.
        warnings: shown in boxes that nobody overlooks.
        key_figures: (label, value with unit), by the title of their group; "" for none.
        colours: (colour, label): what the shades in the plots mean.
        marks: (number, text): what the numbered lines in the plots mean.
        footnote: below everything.
    """

    title: str
    status: str
    mood: str
    sections: Sequence[Section | Heading]
    description: str = ""
    identity: Sequence[str] = ()
    warnings: Sequence[str] = ()
    key_figures: Mapping[str, Sequence[tuple[str, str]]] = field(default_factory=dict)
    colours: Sequence[tuple[str, str]] = ()
    marks: Sequence[tuple[str, str]] = ()
    footnote: str = ""


def environment(*folders: Path) -> jinja2.Environment:
    """The templates in these folders and in this one; whatever is filled in is escaped."""
    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader([*folders, _HERE]),
        autoescape=jinja2.select_autoescape(["html"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["breakable"] = breakable
    return made


def breakable(text: str) -> str:
    """Return a text in which a line may end behind each slash of a path rather than inside of a word."""
    if isinstance(text, Markup):
        return text
    return Markup("").join(
        Markup("/<wbr>").join(word.split("/")) if word.count("/") > 1 else escape(word)
        for word in re.split(r"(\s+)", text)
    )


def plot_section(plot: Plot, *, wide: bool = False) -> Section:
    """The section that shows a plot below its title and note."""
    return Section(plot.title, (plot.note,) if plot.note else (), plot=plot, wide=wide)


def render(page: Page) -> str:
    """The page as HTML."""
    boxes: list[tuple[Section | Heading, str]] = []
    plots: list[Any] = []
    for section in page.sections:
        place = ""
        if isinstance(section, Section) and section.plot is not None:
            place = f"plot{len(plots)}"
            plots.append([place, *_drawn(section.plot)])
        boxes.append((section, place))
    return (
        environment()
        .get_template("page.html")
        .render(
            page=page,
            boxes=boxes,
            links=[(s.anchor, s.title) for s in page.sections if s.anchor],
            policy=_POLICY,
            plots=_script(plots),
            plotly=Markup(plotly.offline.get_plotlyjs()) if plots else "",
        )
    )


def rows_of(pairs: Iterable[tuple[Any, Any]]) -> list[list[str]]:
    """Rows of a table from pairs of anything that has a text."""
    return [[str(a), str(b)] for a, b in pairs]


def made_by(header: Mapping[str, Any]) -> list[list[str]]:
    """Rows of the machine and the libraries that a run was made with, from the header of its log."""
    words = {"cpu flags": "cpu flags, hash of their names"}
    found = header.get("machine", {}) | header.get("versions", {})
    return [[words.get(name, str(name)), str(value)] for name, value in found.items()]


def _drawn(plot: Plot) -> tuple[Any, Any, bool]:
    """What plotly.js draws: data and layout; and whether its x axis is the time that all plots share."""
    figure = plot.figure
    raised = {} if figure.layout.legend.y is None else {"y": figure.layout.legend.y}
    figure.update_layout(_LAYOUT | {"legend": _LAYOUT["legend"] | raised})
    if figure.layout.hovermode is None:
        figure.update_layout(hovermode="x unified" if plot.over_time else "closest")
    figure.update_xaxes(_AXIS)
    figure.update_yaxes(_AXIS, automargin=True)  # long numbers push their axis's title aside
    content = json.loads(figure.to_json())
    return content["data"], content["layout"], plot.over_time


def _script(value: Any) -> Markup:
    """JSON that stays what it is inside a script element."""
    return Markup(json.dumps(value, separators=(",", ":")).replace("<", "\\u003c").replace(">", "\\u003e"))
