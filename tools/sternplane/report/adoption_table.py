"""The section of a report on what the laws were designed from: vehicle file and learned values, before and after."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from sternplane.logs.adoption import adopted_text
from sternplane.logs.summary import Summary
from sternplane.report.page import Cell, Section, Table

_UNITS = {"depth": " m", "heading": "°"}
_LAWS = ("", "depth law, before", "after", "heading law, before", "after")
_COMPARED = "error in dives or turns, RMS"
_ERRORS = {
    _COMPARED: ("rms_moving_before", "rms_moving_after"),
    "error over the whole course, RMS": ("rms_before", "rms_after"),
}
_DESIGNS = {"poles, 1/s": "poles", "s'b": "s_b", "authority of the fins, rad/s²": "authority"}
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


_NOTES = (
    "Before: errors until all of it was learned, or confirmed, and the design by the vehicle file. After: errors from "
    "then on, and the design at the end. Errors are compared while the reference dives or turns; those of the whole "
    "course hang on how much of it was straight.",
    "First values: those of the law's coefficients that are certain enough are in force, the others are the vehicle "
    "file's. All of it: every one is, none held at a bound. Valid asks for more certainty than adoption does: a "
    "coefficient may be in force before it is valid.",
    "Poles: on the sliding surface an error fades with exp(pole t). s'b: by how much a radian of fin angle moves the "
    "law's sliding variable in a second; the switching term is divided by it. Authority: the turning acceleration that "
    "the fins make at the end of their travel. All at the speed of trim.",
)


def adoption_section(summary: Summary) -> Iterator[Section]:
    """Yield the section, of a run whose laws used what was learned."""
    adoption = summary["adoption"]
    if not adoption:
        return
    learned = (summary["learned"] or {}).get("coefficients", {})
    valid = {name: "yes" if one["valid"] else "no" for name, one in learned.items()}
    laws = [*_laws(adoption["laws"])]
    earlier = {one.get("earlier_s") for one in adoption["laws"].values()} - {None}
    coefficients = [
        _coefficient(name, one, valid.get(name, "–"), earlier) for name, one in adoption["coefficients"].items()
    ]
    tables = (Table(laws, head=_LAWS, style="numbers"), Table(coefficients, head=_COEFFICIENTS, style="numbers"))
    title = "Adoption: what the laws were designed from"
    yield Section(title, notes=_NOTES, tables=tables, wide=True, anchor="adoption")


def _laws(laws: Mapping[str, Mapping[str, Any]]) -> Iterator[list[str | Cell]]:
    """Yield the rows of what both laws were designed from and what that changed, two columns for each law."""
    yield ["learned", *(Cell(adopted_text(one), span=2) for one in laws.values())]
    for label, keys in _ERRORS.items():
        row: list[str | Cell] = [label]
        for name, one in laws.items():
            if label == _COMPARED and one["not_compared_because"]:
                row.append(Cell(f"not compared: {one['not_compared_because']}", "note", span=2))
            else:
                row += [_text(one[key], ".3g", _UNITS[name]) for key in keys]
        yield row
    for label, key in _DESIGNS.items():
        designs = [one[when][key] for one in laws.values() for when in ("by_file", "in_force")]
        yield [label, *(", ".join(_text(x, ".3g") for x in (v if isinstance(v, list) else [v])) for v in designs)]


def _coefficient(name: str, one: dict[str, Any], valid: str, earlier: set[float]) -> list[str]:
    first = _text(one["adopted_s"], ".1f", " s")
    first += ", earlier flight" if one["adopted_s"] in earlier else ""
    values = [_text(one["file"], ".4g"), first, _text(one["in_force"], ".4g")]
    errors = [_text(one[key], "+.3g", " %") for key in ("error_before_pct", "error_after_pct")]
    return [name, *values, valid, _text(one["truth"], ".4g"), *errors]


def _text(value: float | None, form: str, unit: str = "") -> str:
    return "–" if value is None else f"{value:{form}}{unit}"
