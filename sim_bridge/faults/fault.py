"""A fault as it is written, KIND:TARGET[=VALUE]@T[+DURATION], and as a value."""

from __future__ import annotations

import difflib
import math
import re
from dataclasses import dataclass

from firmware_py.error_text import quoted, shortened
from firmware_py.params import ParamError
from firmware_py.units import UNITS, to_si
from sim_bridge.faults.catalogue import FORM, KINDS, Kind, groups_of, kind_of, meant

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_WRITTEN = re.compile(
    rf"(?P<kind>[\w-]+):(?P<target>[\w.-]+)(?:=(?P<value>{_NUMBER}))?@(?P<t>{_NUMBER})(?:\+(?P<for>{_NUMBER}))?"
)
_PARTS = re.compile(r"(?P<kind>[\w-]+):(?P<target>[\w.-]+)(?:=(?P<value>[^@]*))?@(?P<t>[^+]*)(?:\+(?P<for>.*))?")
"""The same with anything in place of the numbers: what is wrong with them can be said."""
_T_MAX = 1e6
"""Latest time of a fault, s: the longest scenario."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault of a run.

    Attributes:
        text: as it was written.
        kind: what happens.
        target: to what: the name of a sensor, of one of its channels, of a fin, ...
        value: how much, SI; NaN if none is given.
        t: when it begins, s.
        duration: how long it lasts, s; infinite if it is for good.
    """

    text: str
    kind: Kind
    target: str
    value: float
    t: float
    duration: float


def parse_fault(text: str) -> Fault:
    """Return the fault of a text.

    Raises:
        ParamError: one line that says what is wrong and what would be right.
    """
    if not isinstance(text, str) or (found := _WRITTEN.fullmatch(text.strip())) is None:
        why = _not_numbers(text) if isinstance(text, str) else ""
        form = f"write {FORM} with times in s, such as freeze:pressure@60 or jam:FIN=10@60+20"
        raise ParamError(f"fault {quoted(text)}: {why or form}")
    name, target, t = found["kind"], found["target"], float(found["t"])
    duration = math.inf if found["for"] is None else float(found["for"])
    if not 0.0 <= t <= _T_MAX:
        raise ParamError(f"fault {quoted(text)}: T is {t:g} s; write 0 to {_T_MAX:g}")
    if not duration > 0.0:
        raise ParamError(f"fault {quoted(text)}: DURATION is {duration:g} s; write more than 0")
    names = dict.fromkeys(kind.name for kind in KINDS)
    if name not in names:
        near = difflib.get_close_matches(name.lower(), names, n=1)
        also = f"; did you mean {near[0]}?" if near else ""
        raise ParamError(f"fault {quoted(text)}: {name} is not known; known: {', '.join(names)}{also}")
    kind = kind_of(name, target)
    if kind is None:
        known = f"it applies to {groups_of(name)}{meant(name, target)}"
        raise ParamError(f"fault {quoted(text)}: {name} does not apply to {shortened(target)}; {known}")
    return Fault(text.strip(), kind, target, _value(text, kind, target, found["value"]), t, duration)


def _not_numbers(text: str) -> str:
    """Return which part of a fault should be a number and is none; "" where something else is wrong."""
    found = _PARTS.fullmatch(text.strip())
    if found is None:
        return ""
    kind = kind_of(found["kind"], found["target"])
    unit = kind.unit_text(found["target"]) if kind is not None and kind.unit else ""
    units = {"value": ("VALUE", f" in {unit}" if unit else ""), "t": ("T", " in s"), "for": ("DURATION", " in s")}
    for part, (name, of) in units.items():
        if found[part] is not None and not re.fullmatch(_NUMBER, found[part]):
            return f"{name} is {quoted(found[part])}; {name} must be a plain number{of}, without unit"
    return ""


def _value(text: str, kind: Kind, target: str, written: str | None) -> float:
    unit = kind.unit_of(target)
    if written is None:
        if kind.needs_value:
            raise ParamError(
                f"fault {quoted(text)}: how much? write {kind.name}:{target}=VALUE@T, VALUE in {kind.unit_text(target)}"
            )
        return math.nan
    if not unit:
        raise ParamError(f"fault {quoted(text)}: {kind.name}:{target} takes no value")
    value = float(written)
    if math.isinf(value):
        raise ParamError(f"fault {quoted(text)}: VALUE is {written}; write a number that a double can hold")
    low, high = kind.bounds_of(target)
    if not low <= value <= high:
        told = kind.unit_text(target)
        raise ParamError(f"fault {quoted(text)}: {value:g} {told} is not within {low:g} ... {high:g}")
    si: float = to_si(value, UNITS[unit][1]) if unit in UNITS else value
    return si
