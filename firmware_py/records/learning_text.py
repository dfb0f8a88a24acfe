"""The words for what was learned in a manoeuvre, and what was not."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_py.records.event import Cause, Event


def combination(weights: Sequence[float], names: Sequence[str]) -> str:
    """Return a combination of coefficients with weights to one digit, such as "0.3 Y_dr + 0.9 Y_r - 0.3 Y_v"."""
    parts = [(f"{abs(w):.1f} {name}", w < 0.0) for name, w in zip(names, weights, strict=True)]
    text = "".join(f" {'-' if minus else '+'} {part}" for part, minus in parts)
    return text[3:] if text.startswith(" + ") else text[1:].replace("- ", "-", 1)


def report_text(events: Sequence[Event]) -> str:
    """Return a report in one text.

    Such as "learned 8 of 10, 7 valid, 1 sigma up to 12 % (N_r); not identifiable: N_v, Y_v (never excited)".
    """
    parts: list[str] = []
    unknown: list[str] = []
    calm: list[str] = []
    for event in events:
        cause, numbers, names = event.cause, event.numbers, event.names
        if cause is Cause.NOT_FINITE:
            parts.append(f"learned 0 of {numbers[0]:.0f}: the filter's numbers are not finite")
        elif cause is Cause.NOT_BEGUN:
            parts.append(f"learned 0 of {numbers[0]:.0f}: learning has not begun")
        elif cause is Cause.LEARNED_ALL:
            parts.append(f"learned all {numbers[0]:.0f}{_worst(numbers[1:], names)}")
        elif cause is Cause.LEARNED:
            learned, count, valid = numbers[:3]
            parts.append(f"learned {learned:.0f} of {count:.0f}, {valid:.0f} valid{_worst(numbers[3:], names)}")
        elif cause is Cause.NEVER_EXCITED:
            unknown.append(f"{', '.join(names)} (never excited)")
        elif cause is Cause.NOT_IDENTIFIABLE:
            unknown += names
        elif cause is Cause.COMBINATION:
            unknown.append(combination(numbers, names))
        else:
            calm += names
    if unknown:
        parts.append(f"not identifiable: {' and '.join(unknown)}")
    if calm:
        parts.append(f"not excited at the end: {', '.join(calm)}")
    return "; ".join(parts)


def _worst(sigma: Sequence[float], names: Sequence[str]) -> str:
    return f", 1 sigma up to {100.0 * sigma[0]:.3g} % ({names[0]})" if sigma else ""
