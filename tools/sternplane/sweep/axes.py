"""What is varied: a key and its values, as `KEY=VALUES` gives them."""

from __future__ import annotations

import dataclasses
import math
import re
import tomllib
from typing import Any, NamedTuple

from firmware_py.error_text import quoted, shortened
from firmware_py.own_parts import KINDS
from firmware_py.params import ParamError, dump
from firmware_py.reconfiguration import AutopilotParams
from firmware_py.settings import setting_text, value_at
from firmware_py.toml_text import refuse_times
from sternplane.sitl.flight import Flight
from sternplane.sitl.request import parse_settings

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(rf"(log:)?({_NUMBER})\.\.({_NUMBER})")
_AROUND = re.compile(rf"(?:±|\+-|\+/-)({_NUMBER})(%?)")
FORM = "KEY=VALUES, VALUES as ±20%, ±0.1, 0..0.3, log:0.01..1 or a,b,c"


class Axis(NamedTuple):
    """One key that is varied.

    Attributes:
        key: whole, with the file before it.
        low: least value, in the key's unit, of a range.
        high: greatest value.
        log: whether the range is even in the logarithm.
        whole: whether the values are whole numbers.
        choices: the values of a list; empty for a range.
    """

    key: str
    low: float = math.nan
    high: float = math.nan
    log: bool = False
    whole: bool = False
    choices: tuple[Any, ...] = ()

    def at(self, share: float) -> Any:
        """Return the value at a share of the range, or of the list, in [0, 1].

        A whole number has all that is rounded to it, the first and the last too: shares drawn evenly give even values.
        """
        if self.choices:
            return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]
        if not self.whole:
            return self._between(share)
        first, last = round(self.low), round(self.high)
        low = first - 0.5 if first > 0 or not self.log else self.low
        return min(max(round(self._replace(low=low, high=last + 0.5)._between(share)), first), last)

    def grid(self, n: int) -> list[Any]:
        """Return `n` values from end to end, or all of a list."""
        if self.choices:
            return list(self.choices)
        values = [self._between(i / (n - 1) if n > 1 else 0.5) for i in range(n)]
        return list(dict.fromkeys([round(value) if self.whole else value for value in values]))

    def most(self, n: int) -> int:
        """Return how many values `grid` has at most, without making them."""
        return len(self.choices) or (min(n, round(self.high) - round(self.low) + 1) if self.whole else n)

    def _between(self, share: float) -> float:
        if self.log:
            value = math.exp((1.0 - share) * math.log(self.low) + share * math.log(self.high))
        else:
            value = (1.0 - share) * self.low + share * self.high
        return min(max(value, self.low), self.high)

    def plain(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        if self.choices:
            return {"key": self.key, "choices": list(self.choices)}
        return {"key": self.key, "low": self.low, "high": self.high, "log": self.log, "whole": self.whole}

    @property
    def numeric(self) -> bool:
        """Return whether its values are numbers, which have an order."""
        return all(isinstance(value, int | float) and not isinstance(value, bool) for value in self.choices)


def axis_of(found: dict[str, Any]) -> Axis:
    """Return the axis of `Axis.plain`."""
    choices = [tuple(value) if isinstance(value, list) else value for value in found.get("choices", ())]
    return Axis(**{**found, "choices": tuple(choices)})


def parse_axis(text: str, flight: Flight) -> Axis:
    """Return the axis of `FORM`; what is relative is so to the value that flies if nothing is varied.

    Args:
        text: as a person writes it.
        flight: that one.

    Raises:
        ParamError: not of that form, an unknown key, or nothing to vary.
    """
    shown = shortened(text)
    key, equals, values = (part.strip() for part in text.partition("="))
    if not equals or not values:
        raise ParamError(f"--vary {shown}: write {FORM}")
    if around := _AROUND.fullmatch(values):
        key, now = _nominal(key, "0.0", flight)
        if now is None:
            raise ParamError(f"--vary {key}: has no value as it stands; write LOW..HIGH, or a,b,c")
        if isinstance(now, bool) or not isinstance(now, int | float):
            raise ParamError(f"--vary {key}: is no number but {quoted(now)}; write values, such as a,b,c")
        off = abs(float(around[1]) * (0.01 * now if around[2] else 1.0))
        if not off:
            raise ParamError(
                f"--vary {shown}: is {now:g} as it stands, so that nothing varies; write ±VALUE or LOW..HIGH"
            )
        if not math.isfinite(off):
            raise ParamError(f"--vary {shown}: is beyond every number; write a smaller one")
        return _range(Axis(key, now - off, now + off, whole=isinstance(now, int)), shown)
    if span := _RANGE.fullmatch(values):
        key, now = _nominal(key, span[2], flight)
        low, high = float(span[2]), float(span[3])
        if not low < high < math.inf or (span[1] and low <= 0.0):
            raise ParamError(f"--vary {shown}: write LOW..HIGH with LOW below HIGH, and above 0 behind log:")
        whole = isinstance(now, int) and not isinstance(now, bool)
        return _range(Axis(key, low, high, log=bool(span[1]), whole=whole), shown)
    choices = _choices(values, shown)
    if len(choices) < 2 and ".." in values:
        raise ParamError(f"--vary {shown}: write LOW..HIGH with two numbers, LOW below HIGH")
    if len(choices) < 2:
        raise ParamError(f"--vary {shown}: one value does not vary; write {FORM}, or give it to --set")
    key, _ = _nominal(key, setting_text("", choices[0])[1:], flight)
    return Axis(key, choices=choices)


def _range(axis: Axis, shown: str) -> Axis:
    """Return a range, of whole numbers one with more than one of them."""
    if axis.whole and axis.at(0.0) == axis.at(1.0):
        raise ParamError(f"--vary {shown}: the values are whole numbers, here all {axis.at(0.0)}; write a wider range")
    return axis


def _choices(text: str, shown: str) -> tuple[Any, ...]:
    """Return the values of a list, each as TOML has it; what is no TOML are texts."""
    try:
        values = tomllib.loads(f"values = [{text}]")["values"]
    except (ValueError, RecursionError):
        values = [word.strip() for word in text.split(",")]
    refuse_times(values, f"--vary {shown}")
    try:
        return tuple(dict.fromkeys(tuple(value) if isinstance(value, list) else value for value in values))
    except TypeError:  # tables, or lists of lists
        raise ParamError(f"--vary {shown}: values must be numbers, texts, or lists of these") from None


def _nominal(key: str, value: str, flight: Flight) -> tuple[str, Any]:
    """Return the whole key, and what stands there in a flight, as TOML has it; `value`: one that it may have."""
    try:
        [setting] = parse_settings([f"{key}={value}"])
    except ParamError as error:
        raise ParamError(str(error).replace("--set", "--vary", 1)) from None
    sea = flight.scenario.environment.current_ned
    if setting.key == "truth.current_m_s":
        return setting.key, math.hypot(sea[0], sea[1])
    if setting.key == "truth.current_towards_deg":
        return setting.key, math.degrees(math.atan2(sea[1], sea[0]))
    records = {
        "vehicle": flight.vehicle,
        "autopilot": _with_defaults_of_own_parts(flight),
        "truth": flight.truth,
        "sensors": flight.devices,
        "io": flight.io,
        "scenario": flight.scenario,
    }
    return setting.key, value_at(records[setting.file], setting.path, f"--vary {setting.key}")


def _with_defaults_of_own_parts(flight: Flight) -> AutopilotParams:
    """Return the parameters of the autopilot, where those of parts of one's own stand too that no file has."""
    params, own = flight.params, flight.autopilot.reconfigurator.own
    for field, kind in KINDS.items():
        if part := getattr(own, field):
            table = getattr(params, kind.table)
            table = dataclasses.replace(table, own={**dump(part.params), **table.own})
            params = dataclasses.replace(params, **{kind.table: table})
    return params
