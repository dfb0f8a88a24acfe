"""The figures as PNG files, by matplotlib."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas

from sternplane.paper.figures import Figure, Line, Panel

_DASHES = {"solid": "-", "dash": (0, (5, 2)), "dot": (0, (1, 1.5)), "dashdot": (0, (5, 2, 1, 2))}
_INK, _SOFT, _GRID = "#0f172a", "#475569", "#e2e8f0"
_INCHES, _DPI = (5.0, 3.6), 130


def draw(figure: Figure, folder: Path) -> Path:
    """Writes `name`.png.

    Raises:
        OSError: it cannot be written.
    """
    count = len(figure.panels)
    columns = 2 if count == 4 else count
    rows = -(-count // columns)
    canvas = Canvas(figsize=(_INCHES[0] * columns, _INCHES[1] * rows + 0.9), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(canvas)
    for i, panel in enumerate(figure.panels):
        space = panel.lines[0].z is not None
        axes = canvas.add_subplot(rows, columns, i + 1, **({"projection": "3d"} if space else {}))
        _in_space(axes, panel) if space else _in_plane(axes, panel)
        axes.set_title(panel.title, fontsize=10, color=_INK, loc="left")
    canvas.suptitle(figure.title, fontsize=13, color=_INK, x=0.01, ha="left", weight="bold")
    canvas.supxlabel(figure.note, fontsize=8, color=_SOFT, x=0.01, ha="left", wrap=True)
    path = folder / f"{figure.name}.png"
    canvas.savefig(path)
    return path


def _in_plane(axes: Any, panel: Panel) -> None:
    for line in panel.lines:
        axes.plot(line.x, line.y, label=line.name, **_pen(line))
    axes.set_xlabel(panel.labels[0], fontsize=9)
    axes.set_ylabel(panel.labels[1], fontsize=9)
    axes.margins(x=0.01)
    if panel.log:
        axes.set_yscale("log")
    if panel.downwards:
        axes.invert_yaxis()
    axes.grid(color=_GRID, linewidth=0.8)
    axes.tick_params(labelsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(fontsize=7, framealpha=0.8, ncols=2 if len(panel.lines) > 4 else 1)


def _in_space(axes: Any, panel: Panel) -> None:
    for line in panel.lines:
        axes.plot(line.x, line.y, line.z, label=line.name, **_pen(line))
        axes.scatter(line.x[:1], line.y[:1], line.z[:1] if line.z is not None else 0.0, color=_INK, label="start")
    axes.invert_zaxis()
    axes.set_xlabel(panel.labels[0], fontsize=9)
    axes.set_ylabel(panel.labels[1], fontsize=9)
    axes.set_zlabel(panel.labels[2], fontsize=9)
    axes.tick_params(labelsize=8)
    axes.legend(fontsize=7)


def _pen(line: Line) -> dict[str, Any]:
    return {"color": line.style.colour, "linewidth": line.style.width, "linestyle": _DASHES[line.style.dash]}
