"""The section of a report on what the laws were designed from: vehicle file and learned values, before and after."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from sternplane.logs.summary import Summary
from sternplane.report.page import Section, Table

_UNITS = {"depth": "m", "heading": "°"}
_LAWS = (
    "law",
    "first values from",
    "all of it from",
    "error in dives or turns before all of it, RMS",
    "error in dives or turns after, RMS",
    "whole course before, RMS",
    "whole course after, RMS",
    "poles, 1/s",
    "s'b by the file",
    "s'b at the end",
    "authority of the fins by the file, rad/s²",
    "authority at the end, rad/s²",
)
_ERRORS = ("rms_moving_before", "rms_moving_after", "rms_before", "rms_after")
_COEFFICIENTS = (
    "coefficient",
    "vehicle file",
    "first adopted",
    "in force at the end",
    "valid at the end",
    "truth at the end",
    "file off the truth by",
    "in force off the truth by",
)


_NOTE = (
    "First values: those of the law's coefficients that are certain enough are in force, the others are the vehicle "
    "file's. All of it: every one is, none held at a bound. Valid asks for more certainty than adoption does: a "
    "coefficient may be in force before it is valid. Before and after are compared while the reference dives or turns; "
    "those of the whole course hang on how much of it was straight."
)


def adoption_section(summary: Summary) -> Iterator[Section]:
    """Yield the section, of a run whose laws used what was learned."""
    adoption = summary["adoption"]
    if not adoption:
        return
    learned = (summary["learned"] or {}).get("coefficients", {})
    valid = {name: "yes" if one["valid"] else "no" for name, one in learned.items()}
    laws = [_law(name, one) for name, one in adoption["laws"].items()]
    earlier = {one.get("earlier_s") for one in adoption["laws"].values()} - {None}
    coefficients = [
        _coefficient(name, one, valid.get(name, "–"), earlier) for name, one in adoption["coefficients"].items()
    ]
    tables = (Table(laws, head=_LAWS, style="numbers"), Table(coefficients, head=_COEFFICIENTS, style="numbers"))
    title = "Adoption: what the laws were designed from"
    yield Section(title, notes=(_NOTE,), tables=tables, wide=True, anchor="adoption")


def _law(name: str, one: dict[str, Any]) -> list[str]:
    errors = [_text(one[key], ".3g", f" {_UNITS[name]}".replace(" °", "°")) for key in _ERRORS]
    file, now = one["by_file"], one["in_force"]
    poles = ", ".join(_text(pole, ".3g") for pole in now["poles"])
    strengths = [_text(design[key], ".3g") for key in ("s_b", "authority") for design in (file, now)]
    times = [_text(one[key], ".1f", " s") for key in ("first_s", "adopted_s")]
    if (earlier := one.get("earlier_s")) is not None:
        times[0] = f"earlier flight at {earlier:.1f} s; confirmed {times[0]}"
    return [name, *times, *errors, poles, *strengths]


def _coefficient(name: str, one: dict[str, Any], valid: str, earlier: set[float]) -> list[str]:
    first = _text(one["adopted_s"], ".1f", " s")
    first += ", earlier flight" if one["adopted_s"] in earlier else ""
    values = [_text(one["file"], ".4g"), first, _text(one["in_force"], ".4g")]
    errors = [_text(one[key], "+.3g", " %") for key in ("error_before_pct", "error_after_pct")]
    return [name, *values, valid, _text(one["truth"], ".4g"), *errors]


def _text(value: float | None, form: str, unit: str = "") -> str:
    return "–" if value is None else f"{value:{form}}{unit}"
