"""Units of derivatives in words: `kg/s`, `kg m/(s rad)`, `N s/m`, `1/deg`; what they say of speeds and of degrees."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

_BASE: dict[str, dict[str, float]] = {
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "n": {"kg": 1, "m": 1, "s": -2},
    "nm": {"kg": 1, "m": 2, "s": -2},
    "rad": {},
    "deg": {"deg": 1},
    "°": {"deg": 1},
    "1": {},
    "-": {},
    "–": {},
}
_POWERS = str.maketrans("⁰¹²³⁴⁵⁻", "012345-")
_TOKEN = re.compile(r"([a-z°]+|1|-|–)(?:\^?\(?([+-]?\d+)\)?)?")


class Unit(NamedTuple):
    """Exponents of kg, m, s and of degrees in a unit."""

    kg: int
    m: int
    s: int
    deg: int

    @property
    def is_plain(self) -> bool:
        """Return whether it has no dimension: a prime derivative."""
        return (self.kg, self.m, self.s) == (0, 0, 0)

    @property
    def angle(self) -> float:
        """Return what turns a value by degrees into one by radians."""
        return math.degrees(1.0) ** -self.deg


def parse_unit(text: str) -> Unit | None:
    """Return what a unit is made of; None for words that are no unit."""
    plain = re.sub(r"[·*.]", " ", text.strip().lower().translate(_POWERS))
    found = {"kg": 0.0, "m": 0.0, "s": 0.0, "deg": 0.0}
    sign, depth = 1, 0
    for part in re.findall(r"[()/]|[^()/\s]+", plain):
        if part == "/":
            sign = -1
        elif part in "()":
            depth += 1 if part == "(" else -1
            sign = sign if depth else 1
        else:
            token = _TOKEN.fullmatch(part)
            if token is None or token[1] not in _BASE:
                return None
            for base, exponent in _BASE[token[1]].items():
                found[base] += sign * exponent * int(token[2] or 1)
            sign = sign if depth else 1
    return Unit(*(round(value) for value in found.values()))
