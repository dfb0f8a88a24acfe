"""What came of a sweep, for people and as JSON."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from firmware_py.vehicle.fins import Fin
from sternplane.hardware.fin_judgement import Verdict
from sternplane.hardware.output import BAD, DOUBTFUL, GOOD, Row, Sheet
from sternplane.hardware.sweep import Sweep
from sternplane.hardware.trailing_edge import trailing_edge

_MILD = (Verdict.SLOW, Verdict.OFFSET, Verdict.UNHEARD)


def sheet(sweep: Sweep, fins: Sequence[Fin]) -> Sheet:
    """Return the table."""
    titles = ("fin", "result*", "told>", "reported>", "off by>", "late by>", "turns at>", "at + its edge points*")
    rows = []
    for fin, judgement in sweep.judged().items():
        steps = sweep.steps[fin]
        look = GOOD if judgement.verdict is Verdict.WELL else DOUBTFUL if judgement.verdict in _MILD else BAD
        widest = max(steps, key=lambda step: abs(step.target))
        error = max((abs(step.after[fin] - step.target) for step in steps), default=math.nan)
        late = max((step.lag for step in steps if step.lag == step.lag), default=math.nan)
        speed = max((step.speed for step in steps if step.speed == step.speed), default=math.nan)
        reported = math.nan if judgement.verdict is Verdict.UNHEARD else widest.after[fin]
        numbers = (_deg(widest.target), _deg(reported), _deg(error), _unit(late, "s", 2))
        turning = _unit(math.degrees(speed), "°/s", 0)
        rows.append(Row((fins[fin].name, judgement.verdict.value, *numbers, turning, trailing_edge(fins[fin])), look))
    return Sheet("", titles, rows)


def sentences(sweep: Sweep, fins: Sequence[Fin]) -> Iterator[str]:
    """Yield what is the matter, and what to do."""
    for fin, judgement in sweep.judged().items():
        if judgement.sentence:
            yield f"{fins[fin].name}: {judgement.sentence}"
    if sweep.well:
        yield "every fin that was moved does as it is told; look whether each trailing edge points where the table says"


def found(sweep: Sweep, fins: Sequence[Fin]) -> dict[str, Any]:
    """Return all of it, for JSON."""
    judged = sweep.judged()
    return {
        "complete": sweep.finished,
        "passed": sweep.well,
        "fins": [
            {
                "fin": fins[i].name,
                "result": one.verdict.name.lower(),
                "sentence": one.sentence,
                "steps": [
                    {
                        "told_deg": math.degrees(step.target),
                        "reported_deg": [math.degrees(angle) for angle in step.after],
                        "late_s": step.lag,
                        "turned_at_deg_s": math.degrees(step.speed),
                    }
                    for step in sweep.steps[i]
                ],
            }
            for i, one in judged.items()
        ],
    }


def _deg(angle: float) -> str:
    return _unit(math.degrees(angle), "°", 1)


def _unit(value: float, unit: str, decimals: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{decimals}f}{' ' if unit.isalpha() else ''}{unit}"
