"""The tables of the page, as HTML."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Mapping, Sequence

from firmware_py.estimation.coefficient_params import TEN
from sternplane.paper.control import IDEAL, Flown
from sternplane.paper.design import OPPOSITE, Row
from sternplane.paper.estimation import SHARES, Estimation
from sternplane.paper.figures import BY
from sternplane.paper.printed import ERRATA, TABLE_1

_FIGURES = (
    ("settling_s", "settled within 5 % after, s", "{:.1f}"),
    ("settling_back_s", "and on the way back, s", "{:.1f}"),
    ("overshoot_pct", "overshoot, %", "{:.1f}"),
    ("rms_m", "off the step, RMS, m", "{:.3f}"),
    ("fin_max_deg", "greatest fin angle asked for, °", "{:.1f}"),
    ("fin_travel_deg_s", "fin travel asked for, °/s", "{:.2f}"),
)


def table(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", kind: str = "numbers") -> str:
    """A table, of "numbers" or "words"; cells that begin with "<" are HTML already."""
    top = "".join(f"<th>{html.escape(word)}</th>" for word in head)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(cell)}</td>' for cell in row)}</tr>" for row in rows)
    words = f'<p class="soft">{html.escape(caption)}</p>' if caption else ""
    return f'<div class="scroll"><table class="{kind}"><tr>{top}</tr>{body}</table></div>{words}'


def table_1(found: Estimation) -> str:
    """Steady-state errors beside the paper's."""
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
    return table(
        head,
        rows,
        "Estimate over truth, less 1, at the end; the paper gives no signs. A tick: at or under the paper's row of the "
        "same estimator. The last two columns are of another motion, under a PRBS.",
    )


def equations(rows: Iterable[Row]) -> str:
    """Eq. 27 to 33 beside the printed ones."""
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
    return table(
        ("Eq.", "number", "printed", "from the paper's own inputs", "from our EKF", "from our SMO", "from the truth"),
        lines,
        "The paper's own inputs are Table 1's EKF column for Eq. 27 and 31, with the signs that fit best, and the "
        "printed Eq. 27 and 31 for the rest, each anywhere within its rounding; a tick says that the printed number is "
        "among what they give. * Printed with the other sign than Eq. 25 gives: compared by size.",
    )


def flights(flown: Mapping[str, Flown]) -> str:
    """What the flights of a figure came to."""
    words = {**{who: name for who, (_, name) in BY.items()}, IDEAL: "true coefficients, servos without lag"}
    return table(
        ("law designed from", *(title for _, title, _ in _FIGURES)),
        [[words[who], *(number(one.figures[key], form) for key, _, form in _FIGURES)] for who, one in flown.items()],
    )


def starts(found: Estimation) -> str:
    """What other starts lead to."""
    who = (("smo", "SMO, constant L"), ("smo_prbs", "SMO, weighted L, PRBS"), ("ekf", "EKF"))
    head = ("%", *(f"{words}, from {share:g}" for _, words in who for share in SHARES))
    rows = [[name, *(percent(found.starts[key][share][name]) for key, _ in who for share in SHARES)] for name in TEN]
    return table(head, rows)


def hyperplanes(found: Estimation) -> str:
    """Where the constant-gain observer rests, by forces."""
    rows = []
    for name, at in found.planes["smo"].items():
        unit = "N" if name in "XYZ" else "N m"
        parts = ", ".join(f"{one} {force:+.0f}" for one, force in at.parts.items())
        begin = found.planes["begin"][name]
        rows.append(
            [
                name,
                f"{begin.sum:+.0f} {unit}",
                f"{at.sum:+.2f} {unit}",
                f"{parts} {unit}",
                f"{100.0 * at.share:.2f} %",
                f"{100.0 * found.paper['smo'][name]:.0f} %",
                f"{100.0 * found.paper['ekf'][name]:.0f} %",
            ]
        )
    return table(
        (
            *("equation", "wrong force at the start", "at the end", "of which by"),
            *("sum over greatest part", "the paper's SMO at best", "the paper's EKF at best"),
        ),
        rows,
    )


def errata() -> str:
    """Where the print is in error."""
    return table(("where", "printed", "right"), ERRATA, kind="words")


def marked(text: str, good: bool) -> str:
    """A cell with a tick or a cross."""
    kind, sign = ("yes", "✓") if good else ("no", "✗")
    return f'<span class="{kind}">{html.escape(text)} {sign}</span>'


def percent(value: float) -> str:
    """A signed error, %, with two figures that count."""
    if not math.isfinite(value):
        return "not finite"
    return f"{value:+.1f}" if abs(value) >= 10.0 else f"{value:+.2g}" if abs(value) >= 1e-3 else f"{value:+.0e}"


def number(value: float | None, form: str = "{:.5g}") -> str:
    """A number, or a dash where there is none."""
    return "–" if value is None else form.format(value)


def span(low: float, high: float) -> str:
    """A range, or one number if its ends look alike."""
    a, b = f"{low:.5g}", f"{high:.5g}"
    return a if a == b else f"{a} … {b}"


def _cell(text: str) -> str:
    return text if text.startswith("<") else html.escape(text)
