"""The plot of what was not believed, what had failed, and how the vehicle came up: a strip for each over time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from firmware_py.records.command import AscentStage
from firmware_py.records.estimate import VelocitySource
from firmware_py.records.health import WEIGHT_FAULTS, SourceState
from firmware_py.records.health_text import sensor_text
from sternplane.logs.health_record import (
    HealthRecord,
    Span,
    Timeline,
    actuator_words,
    sensor_state,
    sensor_words,
    stage_words,
    velocity_words,
    weight_words,
)
from sternplane.report.drawing import Plot

TITLE = "Health"
_GOOD, _SUSPECT, _LOST, _FAULT, _RELEASED = "#86efac", "#fbbf24", "#fca5a5", "#ef4444", "#c4b5fd"
_STAGES = {
    AscentStage.POWERED: "#93c5fd",
    AscentStage.BLIND: "#f9a8d4",
    AscentStage.LEVEL: "#a5f3fc",
    AscentStage.REVERSE: "#fdba74",
    AscentStage.STOPPED: "#cbd5e1",
    AscentStage.WAITING: "#fde68a",
    AscentStage.FULL: "#3b82f6",
}
_ROW_PX, _AROUND_PX = 26, 100
"""Height of a row, and of the legend and the axis around them, pixels."""
_WORDS = "#111827"
"""Dark in a dark page too, as what it stands on is light."""


class _Strip(NamedTuple):
    """A row: its name, its values, the words of a value and the kind and colour of what is drawn for it."""

    name: str
    line: Timeline
    words: Callable[[int], str]
    kind: Callable[[int], tuple[str, str]]


def health_plot(health: HealthRecord, figure: Any) -> Plot | None:
    """Return the strips of what was ever not good, of a leak, the ascent and the drop weight; None where all was well.

    Beside a DVL that was not believed stands what the velocity rested on.
    """
    strips = list(_strips(health))
    if not strips:
        return None
    drawn: dict[tuple[str, str], list[tuple[str, Span, str]]] = {}
    for strip in strips:
        for span in strip.line.spans:
            if words := strip.words(span.value):
                drawn.setdefault(strip.kind(span.value), []).append((strip.name, span, words))
    for (kind, colour), bars in drawn.items():
        names, spans, texts = zip(*bars, strict=True)
        figure.add_bar(
            base=[span.begin for span in spans],
            x=[span.end - span.begin for span in spans],
            y=names,
            orientation="h",
            name=kind,
            marker={"color": colour, "line": {"color": "#ffffff", "width": 1}},
            width=0.7,
            text=[""] * len(texts) if kind == "good" else texts,
            textposition="inside",
            insidetextanchor="start",
            textangle=0,
            textfont={"size": 11, "color": _WORDS},
            customdata=[f"{words}, {span.begin:.2f} s to {span.end:.2f} s" for _, span, words in bars],
            hovertemplate="%{y}: %{customdata}<extra></extra>",
        )
    # Words that do not fit are left to the pointer.
    figure.update_layout(barmode="overlay", hovermode="closest", uniformtext={"minsize": 10, "mode": "hide"})
    rows = [strip.name for strip in strips]
    figure.update_yaxes(autorange="reversed", type="category", categoryorder="array", categoryarray=rows)
    figure.update_layout(showlegend=True)
    note = "What was ever not good, and how the vehicle came up. All other sensors and actuators were good throughout."
    return Plot(TITLE, note, figure, height=_AROUND_PX + _ROW_PX * len(rows))


def _strips(health: HealthRecord) -> Iterator[_Strip]:
    for name, line in health.sensors.items():
        if not line.quiet:
            yield _Strip(sensor_text(name), line, sensor_words, _sensor)
    if "dvl" in health.sensors and not (health.sensors["dvl"].quiet or health.velocity.quiet):
        yield _Strip("velocity", health.velocity, velocity_words, _velocity)
    for name, line in health.actuators.items():
        if not line.quiet:
            yield _Strip(name, line, actuator_words, _actuator)
    if not health.leak.quiet:
        yield _Strip("hull", health.leak, lambda value: "water in the hull" if value else "", _actuator)
    if not health.ascent.quiet:
        yield _Strip("coming up", health.ascent, stage_words, _stage)
    if not health.drop.quiet:
        yield _Strip("drop weight", health.drop, weight_words, _drop)


def _sensor(value: int) -> tuple[str, str]:
    state, _ = sensor_state(value)
    return {
        SourceState.GOOD: ("good", _GOOD),
        SourceState.SUSPECT: ("suspect", _SUSPECT),
        SourceState.LOST: ("lost", _LOST),
    }[state]


def _velocity(value: int) -> tuple[str, str]:
    known = value in (VelocitySource.DVL, VelocitySource.FILTER)
    return ("good", _GOOD) if known else ("suspect", _SUSPECT)


def _actuator(value: int) -> tuple[str, str]:
    return ("fault", _FAULT) if value else ("good", _GOOD)


def _stage(value: int) -> tuple[str, str]:
    """Each stage is named in the legend, as most are too short for words."""
    return f"coming up: {stage_words(value)}", _STAGES.get(AscentStage(value), _GOOD)


def _drop(value: int) -> tuple[str, str]:
    return ("fault", _FAULT) if value in WEIGHT_FAULTS else ("weight released", _RELEASED)
