"""The tables of the page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from firmware_py.estimation.coefficient_params import TEN
from firmware_py.number_text import signed
from sternplane.paper.control import IDEAL, StepFlight
from sternplane.paper.design import OPPOSITE, Comparison
from sternplane.paper.estimation import SHARES, Estimation
from sternplane.paper.figures import BY
from sternplane.paper.printed import ERRATA, TABLE_1
from sternplane.report.page import Cell, Table

_FIGURES = (
    ("settling_s", "settled within 5 % after, s", "{:.1f}"),
    ("settling_back_s", "and on the way back, s", "{:.1f}"),
    ("overshoot_pct", "overshoot, %", "{:.1f}"),
    ("rms_m", "off the step, RMS, m", "{:.3f}"),
    ("fin_max_deg", "greatest fin angle asked for, °", "{:.1f}"),
    ("fin_travel_deg_s", "fin travel asked for, °/s", "{:.2f}"),
)


def table_1(found: Estimation) -> Table:
    """Return the steady-state errors beside the paper's."""
    columns = ("ekf", "smo", "smo_weighted", "ekf_prbs", "smo_prbs")
    rows = []
    for name in TEN:
        ekf, smo, weighted, ekf_prbs, smo_prbs = (found.learned[who].errors[name] for who in columns)
        limit, loose = TABLE_1["ekf"][name], TABLE_1["smo"][name]
        rows.append(
            [
                name,
                f"{limit:g}",
                marked(percent(ekf), abs(ekf) <= limit),
                f"{loose:g}",
                percent(smo),
                percent(weighted),
                marked(percent(smo_prbs), abs(smo_prbs) <= loose),
                percent(ekf_prbs),
            ]
        )
    head = (
        "%",
        "EKF, paper",
        "EKF",
        "SMO, paper",
        "SMO, constant L",
        "SMO, weighted L",
        "SMO, weighted L, PRBS",
        "EKF, PRBS",
    )
    return Table(
        rows,
        head,
        "Estimate over truth, less 1, at the end; the paper gives no signs. A tick: at or under the paper's row of the "
        "same estimator; results.json has all digits. The last two columns are of another motion, under a PRBS.",
        "numbers",
    )


def equations(rows: Iterable[Comparison]) -> Table:
    """Return Eq. 27 to 33 beside the printed ones."""
    lines = [
        [
            row.number.equation,
            row.number.what,
            row.number.printed + (" *" if row.number.key in OPPOSITE else ""),
            marked(span(row.low, row.high), row.follows),
            *(number(row.found[who]) for who in ("ekf", "smo", "truth")),
        ]
        for row in rows
    ]
    return Table(
        lines,
        ("Eq.", "number", "printed", "from the paper's own inputs", "from our EKF", "from our SMO", "from the truth"),
        "The paper's own inputs are Table 1's EKF column for Eq. 27 and 31, with the signs that fit best, and the "
        "printed Eq. 27 and 31 for the rest, each anywhere within its rounding; a tick says that the printed number is "
        "among what they give. * Printed with the other sign than Eq. 25 gives: compared by size.",
        "numbers",
    )


def flights(flown: Mapping[str, StepFlight]) -> Table:
    """Return the figures of the flights."""
    names = {**{who: name for who, (_, name) in BY.items()}, IDEAL: "true coefficients, servos without lag"}
    return Table(
        [[names[who], *(number(one.figures[key], form) for key, _, form in _FIGURES)] for who, one in flown.items()],
        ("law designed from", *(title for _, title, _ in _FIGURES)),
        style="numbers",
    )


def starts(found: Estimation) -> Table:
    """Return the errors from other starts."""
    who = (("smo", "SMO, constant L"), ("smo_prbs", "SMO, weighted L, PRBS"), ("ekf", "EKF"))
    head = ("%", *(f"{label}, from {share:g}" for _, label in who for share in SHARES))
    rows = [[name, *(percent(found.starts[key][share][name]) for key, _ in who for share in SHARES)] for name in TEN]
    return Table(rows, head, style="numbers")


def hyperplanes(found: Estimation) -> Table:
    """Return where the constant-gain observer rests, by forces."""
    rows = []
    for name, at in found.planes["smo"].items():
        unit = "N" if name in "XYZ" else "N m"
        parts = ", ".join(f"{one} {signed(force, '.0f')}" for one, force in at.parts.items())
        begin = found.planes["begin"][name]
        rows.append(
            [
                name,
                f"{signed(begin.sum, '.0f')} {unit}",
                f"{signed(at.sum, '.2f')} {unit}",
                f"{parts} {unit}",
                f"{100.0 * at.share:.2f} %",
                f"{100.0 * found.paper['smo'][name]:.0f} %",
                f"{100.0 * found.paper['ekf'][name]:.0f} %",
            ]
        )
    return Table(
        rows,
        (
            *("equation", "wrong force at the start", "at the end", "of which by"),
            *("sum over greatest part", "the paper's SMO at best", "the paper's EKF at best"),
        ),
        style="numbers",
    )


def errata() -> Table:
    """Return the errors of the print."""
    return Table(ERRATA, ("where", "printed", "right"))


def marked(text: str, good: bool) -> Cell:
    """Return a cell with a tick or a cross."""
    return Cell(f"{text} ✓", "good") if good else Cell(f"{text} ✗", "bad")


def percent(value: float) -> str:
    """Return a signed error, %."""
    return signed(value, ".3f") if math.isfinite(value) else "not finite"


def number(value: float | None, form: str = "{:.5g}") -> str:
    """Return a number as text, or a dash where there is none."""
    return "–" if value is None else form.format(value)


def span(low: float, high: float) -> str:
    """Return a range as text, or one number if its ends look alike."""
    a, b = f"{low:.5g}", f"{high:.5g}"
    return a if a == b else f"{a} … {b}"
