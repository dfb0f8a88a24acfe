"""What a run leaves for people: report.html and summary.json."""

from __future__ import annotations

import argparse
import html
import json
import sys
from pathlib import Path
from typing import Any

import plotly.offline
from rich.console import Console

from firmware_py.adapters.storage.recorder import LogError
from sternplane.logs.reading import Log, find, read
from sternplane.logs.summary import Summary, figures, summarise, table, verdict
from sternplane.report.figures import Figures, mode_colours
from sternplane.report.template import PAGE, POLICY

_LAYOUT: dict[str, Any] = {
    "template": "none",
    "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "#94a3b8", "activecolor": "#2563eb"},
    "margin": {"l": 56, "r": 12, "t": 30, "b": 42},
    "hovermode": "x unified",
    "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "font": {"size": 11}},
    "font": {"family": "system-ui, DejaVu Sans, sans-serif", "size": 12, "color": "#334155"},
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "rgba(0,0,0,0)",
}
_AXIS = {"gridcolor": "#e2e8f0", "zerolinecolor": "#cbd5e1", "linecolor": "#cbd5e1", "ticks": "outside", "ticklen": 3}

_LARGE = 10_000_000
"""A log of so many bytes takes ten seconds to report."""


def leave(log: Log, folder: str | Path) -> Summary:
    """Writes report.html and summary.json into a folder, each whole or not at all, and returns the summary.

    Raises:
        LogError: nothing to report, or the folder cannot be written.
    """
    folder = Path(folder)
    summary = summarise(log)
    text, drawn = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False), page(log, summary)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _write(folder / "summary.json", f"{text}\n")
        _write(folder / "report.html", drawn)
    except OSError as error:
        raise LogError(f"{folder}: the report cannot be written ({error.strerror}); choose another --out") from None
    return summary


def leave_of(path: Path, folder: Path) -> Summary:
    """`leave` for the log in a file; of a large one it says so first, for nothing is to be seen for a while."""
    size = path.stat().st_size
    if size > _LARGE:
        print(f"making the report of a log of {size / 1e6:.0f} MB", file=sys.stderr)
    return leave(read(path), folder)


def command(options: argparse.Namespace) -> int:
    """`sternplane report LOG`: makes both again, beside the log or in --out."""
    path = find(options.log)
    folder = options.out or path.parent
    console = Console()
    console.print(table(leave_of(path, folder)))
    console.print(f"{folder / 'report.html'}", highlight=False, soft_wrap=True)
    return 0


def page(log: Log, summary: Summary) -> str:
    """The report as HTML, with all it needs inside."""
    drawn = Figures(log)
    cards, plots = [], []
    section = ""
    for i, (title, note, figure, over_time, part) in enumerate(drawn):
        figure.update_layout(_LAYOUT)
        figure.update_xaxes(_AXIS)
        figure.update_yaxes(_AXIS, automargin=True)  # long numbers push their axis's title aside
        if not over_time:
            figure.update_layout(hovermode="closest")
        if part != section:
            section = part
            cards.append(f'<h3 class="section">{html.escape(section)}</h3>')
        wide = " wide" if i == 0 else ""
        words = f'<h2>{html.escape(title)}</h2><p class="soft">{html.escape(note)}&nbsp;</p>'
        cards.append(f'<div class="card{wide}">{words}<div class="plot" id="plot{i}"></div></div>')
        content = json.loads(figure.to_json())
        plots.append([f"plot{i}", content["data"], content["layout"], over_time])
    if section:
        cards.append('<h3 class="section">The log</h3>')
    header = log.header
    scenario = str(header.get("scenario", "run"))
    identity = " · ".join(
        f"{name} {html.escape(', '.join(header[key]) if isinstance(header[key], list) else str(header[key]))}"
        for name, key in (("seed", "seed"), ("faults", "faults"), ("revision", "git"), ("recorded", "stamp"))
        if header.get(key) not in (None, [])
    )
    cells = "".join(f"<div>{html.escape(words)}<b>{html.escape(value)}</b></div>" for words, value in figures(summary))
    key = "".join(f'<span><i style="background:{c}"></i>{name}</span>' for name, c in mode_colours(drawn.bands))
    return PAGE.substitute(
        policy=POLICY,
        title=html.escape(scenario),
        verdict=html.escape(verdict(summary)),
        mood={True: "good", False: "bad"}.get(summary["completed"], "even"),
        description=html.escape(str(header.get("description", ""))),
        identity=identity,
        warning=f'<p class="warning">The log is {html.escape(log.lost)}.</p>' if log.lost else "",
        figures=cells,
        key=key,
        cards="".join(cards),
        events=_rows([(f"{t:.2f} s", text) for t, text in log.events] or [("", "none")]),
        origin=_rows([*(header.get("machine", {}) | header.get("versions", {})).items()]),
        thinned=f"Plots show every {_ordinal(drawn.stride)} cycle ({drawn.rate:.3g} Hz); the figures use all of them.",
        plotly=plotly.offline.get_plotlyjs(),
        plots=json.dumps(plots, separators=(",", ":")).replace("</", "<\\/"),
    )


def _write(path: Path, text: str) -> None:
    """Whoever reads the file at any time finds the old one or the new one."""
    fresh = path.with_name(f"{path.name}.new")
    try:
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(path)
    except BaseException:
        fresh.unlink(missing_ok=True)
        raise


def _rows(rows: list[tuple[Any, Any]]) -> str:
    return "".join(f"<tr><td>{html.escape(str(a))}</td><td>{html.escape(str(b))}</td></tr>" for a, b in rows)


def _ordinal(n: int) -> str:
    endings = {1: "st", 2: "nd", 3: "rd"}
    return "" if n == 1 else f"{n}{'th' if 10 < n % 100 < 14 else endings.get(n % 10, 'th')}"
