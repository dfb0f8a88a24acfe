"""The plots of what was learned: coefficients in their bands, the water, and whether the filter is consistent."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from firmware_py.estimation.coefficient_validity import SENSORS
from firmware_py.number_text import signed
from sternplane.logs.adoption import in_force
from sternplane.logs.learned import Certainty, Coefficient, certainty, coefficients, manoeuvre_results
from sternplane.logs.reading import Columns
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array
from sternplane.report.design_plot import design_plot, was_adopted
from sternplane.report.drawing import ESTIMATE, REFERENCE, TRUTH, Plot, band, line, minimum_height
from sternplane.report.thinning import Drawn

SECTION = "Coefficients"
_SENSORS = dict(zip(SENSORS, (("DVL", ESTIMATE), ("gyros", "#059669"), ("attitude", "#be185d")), strict=True))
_UNSURE, _IN_FORCE, _EARLIER = "#94a3b8", "#be185d", "#0891b2"
_MOST_SIGMAS = 10.0
"""The plot of errors over their sigmas reaches no further: the band of 3 would be hidden."""
_STATES = ("#e2e8f0", "#a5b4fc", "#bbf7d0", "#16a34a")
"""Of the timeline: neither, excited, valid, both."""


def plots(log: Run, drawn: Drawn, current: Array | None, figure: Callable[[str], Any]) -> Iterator[Plot]:
    """All of them; none where nothing was learned.

    Args:
        log: the run.
        drawn: its data.
        current: the true current at the points, if it is known.
        figure: makes an empty plot over time with a y axis of that name.
    """
    figures, c = drawn.learned, drawn.c
    last, t = figures.last, c["t"].astype(np.float32)
    learned, adopted = coefficients(log.header, c) if last else [], in_force(c)
    if learned and (design := design_plot(c, drawn.designs, SECTION, figure("ratio"))):
        yield design
    limits = certainty(log.header) if any(map(was_adopted, drawn.designs.values())) else None
    reasons = drawn.reasons.of(figures) if last else {}
    for coefficient, end in zip(learned, last, strict=False):
        name = coefficient.name
        plot = _coefficient(coefficient, end, adopted.get(name), limits, t, figure(f"{name}, nondimensional"))
        yield plot._replace(note=f"{plot.note} Why it is not valid: {reasons[name].text}.") if name in reasons else plot
    if not learned:
        return
    yield _timeline(learned, manoeuvre_results(log), t, figure(""))
    known = [(one, end) for one, end in zip(learned, last, strict=True) if np.isfinite(one.built)]
    if known:
        yield _errors(known, t, figure("error, σ"))
    yield _nis(c["state.learned.nis"], figures.nis_bands, t, figure("mean square of innovations"))
    running = np.isfinite(c["state.learned.horizon"])
    if np.isfinite(c["state.learned.current"]).any():
        yield _current(c, running, current, t, figure("current, m/s"))
    yield _turbulence(np.where(running, c["state.learned.turbulence"], np.nan), t, figure("intensity, m/s"))


def _coefficient(
    one: Coefficient, end: Coefficient, in_force: Array | None, limits: Certainty | None, t: Array, figure: Any
) -> Plot:
    """The estimate in its band. What is valid or in force makes the height of the axis, not what was tried at first."""
    value, reach, valid = one.value, 3.0 * one.std, one.valid
    band(figure, t, value - reach, value + reach, "±3 σ")
    for level, name, colour in ((one.believed, "vehicle file", REFERENCE), (one.earlier, "passport", _EARLIER)):
        line(figure, t[[0, -1]], np.full(2, level), name, colour, dash="dot")
    steps = np.concatenate(([0], np.flatnonzero(np.diff(one.truth)) + 1, [-1]))
    line(figure, t[steps], one.truth[steps], _truth(one), TRUTH, line_shape="hv")
    line(figure, t, value, "estimate", _UNSURE)
    line(figure, t, np.where(valid, value, np.nan), "estimate, valid", ESTIMATE, width=2.2)
    if in_force is not None:
        line(figure, t, in_force, "in force", _IN_FORCE, dash="dash")
    ends = [*value[valid if valid.any() else slice(None)], value[-1] - reach[-1], value[-1] + reach[-1]]
    flown = [] if in_force is None or limits is None else [*in_force]
    low, high = _fit(figure, [*ends, one.believed, *one.truth[steps], *flown], 0.1 * abs(value[-1]))
    note = _note(end)
    if np.nanmin(value) < low or np.nanmax(value) > high:
        note += f" Where the estimate leaves the plot it was {'neither valid nor in force' if flown else 'not valid'}."
    if limits and flown and not end.valid[-1] and flown[-1] != one.believed:
        note += f" In force all the same: {limits.text(float(end.std[-1] / abs(one.believed)))}."
    return Plot(one.name, note, figure, section=SECTION)


def _note(one: Coefficient) -> str:
    value, std = one.value[-1], one.std[-1]
    text = f"At the end {value:.4g} ± {3.0 * std:.2g} (3 σ), {'valid' if one.valid[-1] else 'not valid'}"
    if one.truth[-1]:
        share = 100.0 * (value / one.truth[-1] - 1.0)  # + is larger in size
        if np.isfinite(share):
            text += f"; {signed(share, '.2f')} % ({abs(one.error_sigmas[-1]):.1f} σ) off the {_truth(one)}"
    return f"{text}."


def _truth(one: Coefficient) -> str:
    return "truth with the fault" if one.damaged else "truth"


def _timeline(learned: list[Coefficient], manoeuvres: list[tuple[float, str]], t: Array, figure: Any) -> Plot:
    states = np.array([one.excited + 2 * one.valid.astype(np.int8) for one in learned], dtype=np.int8)
    steps = (
        [(i / 4, colour) for i, colour in enumerate(_STATES)],
        [(i / 4, colour) for i, colour in enumerate(_STATES, 1)],
    )
    figure.add_heatmap(
        x=t,
        y=[one.name for one in learned],
        z=states,
        zmin=-0.5,
        zmax=3.5,
        colorscale=[edge for pair in zip(*steps, strict=True) for edge in pair],
        colorbar={"tickvals": [0, 1, 2, 3], "ticktext": ["neither", "excited", "valid", "both"], "thickness": 10},
        hoverinfo="x+y",
    )
    figure.update_yaxes(autorange="reversed", dtick=1)
    note = "Excited: the motion tells something about it. Valid: certain, and the filter is consistent."
    results = [f"At {end:.1f} s, {text}." for end, text in manoeuvres]
    return Plot("Excitation and validity", " ".join((note, *results)), figure, section=SECTION)


def _errors(known: list[tuple[Coefficient, Coefficient]], t: Array, figure: Any) -> Plot:
    band(figure, t, np.full(len(t), -3.0), np.full(len(t), 3.0), "±3 σ")
    for one, _ in known:
        figure.add_scatter(x=t, y=one.error_sigmas.astype(np.float32), name=one.name, mode="lines")
    most = max(float(np.nanmax(np.abs(one.error_sigmas))) for one, _ in known)
    top = min(max(1.1 * most, 4.0), _MOST_SIGMAS)
    figure.update_yaxes(range=[-top, top])
    mean = float(np.mean([end.error_sigmas[-1] ** 2 for _, end in known]))
    true = "truth with the fault" if any(one.damaged for one, _ in known) else "truth"
    note = f"Estimate minus {true}, over its own sigma. Mean square at the end {mean:.2g}, correlations left out."
    beyond = {one.name: float(np.nanmax(np.abs(one.error_sigmas))) for one, _ in known}
    if far := [f"{name} {size:.0f} σ" for name, size in beyond.items() if size > top]:
        note += f" The plot is cut at ±{top:g} σ; beyond it at their worst: {', '.join(far)}."
    return Plot("Errors in sigmas", note, figure, section=SECTION)


def _nis(nis: Array, bands: dict[str, tuple[float, float]], t: Array, figure: Any) -> Plot:
    for i, (sensor, (name, colour)) in enumerate(_SENSORS.items()):
        line(figure, t, nis[:, i], name, colour, legendgroup=name)
        for level in bands.get(sensor, ()):
            pen: dict[str, Any] = {"dash": "dot", "legendgroup": name, "showlegend": False, "hoverinfo": "skip"}
            line(figure, t[[0, -1]], np.full(2, level), name, colour, width=1.0, **pen)
    minimum_height(figure, 0.5)
    note = "NIS per degree of freedom, running mean; 1 where consistent. Dotted: where it may be, in a full window."
    return Plot("Innovations", note, figure, section=SECTION)


def _current(c: Columns, running: Array, truth: Array | None, t: Array, figure: Any) -> Plot:
    """The water's velocity, where the filter runs."""
    ends: list[float] = []
    for i, (name, colour) in enumerate((("north", ESTIMATE), ("east", "#059669"))):
        value, reach = (
            np.where(running, c[f"state.learned.{key}"][:, i], np.nan) for key in ("current", "current_std")
        )
        band(figure, t, value - 3.0 * reach, value + 3.0 * reach, f"{name}, ±3 σ", colour)
        if truth is not None:
            line(figure, t, truth[:, i], f"{name}, truth", TRUTH, dash="dash" if i else "solid")
        line(figure, t, value, name, colour)
        ends += [*value, *(value + reach)[running][-1:], *(value - reach)[running][-1:]]
    _fit(figure, ends if truth is None else [*ends, *truth[:, :2].ravel()], 0.2)
    return Plot("Current", "The steady part of the water's velocity.", figure, section=SECTION)


def _turbulence(intensity: Array, t: Array, figure: Any) -> Plot:
    line(figure, t, intensity, "turbulence", ESTIMATE)
    minimum_height(figure, 0.02)
    note = "Intensity of the eddies that the bank of filters finds likely."
    return Plot("Turbulence", note, figure, section=SECTION)


def _fit(figure: Any, values: list[float], least: float) -> tuple[float, float]:
    """Make the y axis as high as these, and at least so high; the rest goes on beyond it. Return its ends."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    middle, half = 0.5 * (low + high), max(0.55 * (high - low), 0.5 * least)
    figure.update_yaxes(range=[middle - half, middle + half])
    return middle - half, middle + half
