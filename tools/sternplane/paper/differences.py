"""What differs from the paper, and why: the text is in `differences.html`, this run's figures are filled in here."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup

from sternplane.paper import tables
from sternplane.paper.control import StepFlight
from sternplane.paper.design import Comparison
from sternplane.paper.estimation import LENGTH, SHARE, STD, Estimation
from sternplane.paper.printed import TABLE_1
from sternplane.report.page import Section, environment

_BALANCED = 0.05
"""Forces whose sum is below this part of the greatest are taken to balance."""


def sections(found: Estimation, rows: list[Comparison], flown: Mapping[str, Mapping[str, StepFlight]]) -> list[Section]:
    """Return the sections of the page."""
    template: Any = environment(Path(__file__).parent).get_template("differences.html").module

    def text(name: str, values: dict[str, Any]) -> Markup:
        return Markup(getattr(template, name)(values))

    hyperplane = _hyperplane(found)
    return [
        Section("What the paper does not say, and what was taken", text=text("taken", _taken(found)), wide=True),
        Section("The extended Kalman filter", text=text("ekf", _ekf(found)), wide=True),
        Section(
            "The hyperplane on which a constant-gain observer rests",
            text=text("hyperplane", hyperplane),
            tables=(tables.hyperplanes(found),),
            wide=True,
        ),
        Section(
            "The paper's errors, and other starts",
            text=text("at_best", hyperplane),
            tables=(tables.starts(found),),
            wide=True,
        ),
        Section("The design", text=text("design", _design(rows)), wide=True),
        Section("The flights", text=text("flights", _flights(flown)), wide=True),
        Section("Errata of the print", tables=(tables.errata(),), wide=True),
    ]


def outcome(found: Estimation) -> tuple[str, bool]:
    """Return one phrase on Table 1, and whether every row of the EKF is at or under the paper's."""
    errors = found.learned["ekf"].errors
    over = [name for name, limit in TABLE_1["ekf"].items() if not abs(errors[name]) <= limit]
    if over:
        return f"EKF above the paper's Table 1 in {', '.join(over)}", False
    return "every EKF row of Table 1 is at or under the paper's", True


def _taken(found: Estimation) -> dict[str, Any]:
    wrong = [name for name, error in found.learned["smo"].errors.items() if error < 100.0 * (SHARE - 1.0)]
    return {
        "share": f"{SHARE:g}",
        "wrong": ", ".join(wrong),
        "length": f"{LENGTH:g}",
        "pitch": f"{math.degrees(found.nose[0]):.0f}",
        "at": f"{found.nose[1]:.0f}",
        "speed": f"{STD[0]:.3g}",
        "rate": f"{math.degrees(STD[3]):.2g}",
        "angle": f"{math.degrees(STD[6]):.2g}",
    }


def _ekf(found: Estimation) -> dict[str, Any]:
    errors = found.learned["ekf"].errors
    worst = max(errors, key=lambda name: abs(errors[name]))
    share = 100.0 * min(found.paper["ekf"].values())
    return {"worst": tables.percent(errors[worst]), "name": worst, "share": f"{share:.0f}"}


def _hyperplane(found: Estimation) -> dict[str, Any]:
    smo, weighted = found.learned["smo"].errors, found.learned["smo_prbs"].errors
    return {
        "share": f"{SHARE:g}",
        "low": f"{min(map(abs, smo.values())):.0f}",
        "high": f"{max(map(abs, smo.values())):.0f}",
        "left": f"{100.0 * max(at.share for at in found.planes['smo'].values()):.1f}",
        "balanced": f"{100.0 * _BALANCED:.0f}",
        "near": ", ".join(name for name, share in found.paper["smo"].items() if share < _BALANCED) or "no equation",
        "far": ", ".join(name for name, share in found.paper["smo"].items() if share >= _BALANCED) or "none",
        "weighted": f"{max(map(abs, weighted.values())):.2g}",
    }


def _design(rows: list[Comparison]) -> dict[str, Any]:
    gaps = "; ".join(
        f"{row.number.what}, printed {row.number.printed}, is {tables.span(row.low, row.high)}"
        for row in rows
        if not row.follows
    )
    ours = [(row.found["ekf"], row.found["truth"]) for row in rows]
    off = max(abs(ekf / true - 1.0) for ekf, true in ours if ekf is not None and true)
    return {"gaps": f"What does not follow: {gaps}." if gaps else "All of it follows.", "off": f"{100.0 * off:.2g}"}


def _flights(flown: Mapping[str, Mapping[str, StepFlight]]) -> dict[str, Any]:
    dive, turn = flown["fig9"], flown["fig10"]
    return {
        "travel": {who: tables.number(one.figures["fin_travel_deg_s"], "{:.1f}°/s") for who, one in turn.items()},
        "settling": {who: tables.number(one.figures["settling_s"], "{:.0f} s") for who, one in dive.items()},
        "over": tables.number(dive["pid"].figures["overshoot_pct"], "{:.1f} %"),
    }
