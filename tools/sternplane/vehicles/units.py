"""Units in words, as published tables have them: `kg/s`, `kg.m²/(s·rad)`, `N–m s`, `kn`, `cm`, `rev/min`."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

G = 9.81


class Unit(NamedTuple):
    """A unit: its exponents of kg, m, s and of an angle, and what turns a number of it into SI and radians."""

    kg: int = 0
    m: int = 0
    s: int = 0
    angle: int = 0
    factor: float = 1.0

    @property
    def dimension(self) -> tuple[int, int, int, int]:
        """Return the exponents."""
        return self[:4]

    @property
    def is_plain(self) -> bool:
        """Return whether it has no dimension: a prime derivative, by radians or degrees too."""
        return (self.kg, self.m, self.s) == (0, 0, 0)

    def times(self, other: Unit, power: int) -> Unit:
        """Return the product of this and a power of another."""
        kg, m, s, angle = (mine + power * its for mine, its in zip(self.dimension, other.dimension, strict=True))
        return Unit(kg, m, s, angle, self.factor * other.factor**power)


_SYMBOLS = {
    **{name: Unit(kg=1, factor=factor) for name, factor in (("kg", 1.0), ("g", 1e-3), ("t", 1e3), ("lb", 0.45359237))},
    **{name: Unit(m=1, factor=factor) for name, factor in (("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("km", 1e3))},
    **{name: Unit(m=1, factor=factor) for name, factor in (("in", 0.0254), ("ft", 0.3048))},
    "l": Unit(m=3, factor=1e-3),
    **{name: Unit(s=1, factor=factor) for name, factor in (("s", 1.0), ("min", 60.0), ("h", 3600.0))},
    **{
        name: Unit(1, 1, -2, factor=factor)
        for name, factor in (("N", 1.0), ("kN", 1e3), ("kgf", G), ("lbf", 4.4482216))
    },
    **{name: Unit(m=1, s=-1, factor=1852.0 / 3600.0) for name in ("kn", "kt", "kts", "knot", "knots")},
    "rad": Unit(angle=1),
    **{name: Unit(angle=1, factor=math.radians(1.0)) for name in ("deg", "°", "º")},
    "rev": Unit(angle=1, factor=math.tau),
    "rpm": Unit(s=-1, angle=1, factor=math.tau / 60.0),
    **{name: Unit(s=-1, angle=1, factor=math.tau) for name in ("rps", "Hz")},
    "-": Unit(),
}
_KNOWN = {name.lower(): unit for name, unit in _SYMBOLS.items()} | _SYMBOLS  # kN is none of kn
_LONGEST = 60
"""Characters of a unit."""
_TOKEN = re.compile(f"({'|'.join(sorted(map(re.escape, _KNOWN), key=len, reverse=True))})([+-]?[0-9])?")
_PLAIN = str.maketrans("⁰¹²³⁴⁵⁻−‐‑–—·⋅∙•×*.", "012345------       ")  # a dash between two units does no harm
_POWER = re.compile(r"\^?[({]([+-]?[0-9])[)}]|\^")


def parse_unit(text: str) -> Unit | None:
    """Return what a unit is made of; None for words that are no unit. Only in kN and kn do capitals matter."""
    if len(text) > _LONGEST:
        return None
    plain = _POWER.sub(r"\1", text.replace("**", "^").translate(_PLAIN))
    return _parsed(plain) or _parsed(plain.lower())


def _parsed(text: str) -> Unit | None:
    words = re.findall(r"[()/]|[^()/\s]+", text)
    try:
        unit = _product(words)
    except (LookupError, ArithmeticError):  # no unit, or a power of one that no number holds
        return None
    return unit if not words and 0.0 < unit.factor < math.inf else None


def _product(words: list[str]) -> Unit:
    """Return the product of words up to the end or a closing parenthesis, and take them away.

    A / divides by the next word or parenthesis alone.

    Raises:
        LookupError: a word that is no unit, or a parenthesis that does not close.
    """
    unit, sign = Unit(), 1
    while words and words[0] != ")":
        word = words.pop(0)
        if word == "/":
            sign = -1
            continue
        if word == "(":
            part, power = _product(words), 1
            words.pop(0)
            if words and re.fullmatch("[+-]?[0-9]", words[0]):
                power = int(words.pop(0))
            unit = unit.times(part, sign * power)
        elif word != "1":
            unit = unit.times(_word(word), sign)
        sign = 1
    return unit


def _word(word: str) -> Unit:
    """Return the product of units that are written together, such as kgm2."""
    unit, at = Unit(), 0
    while at < len(word):
        if not (token := _TOKEN.match(word, at)):
            raise LookupError(word)
        unit, at = unit.times(_KNOWN[token[1]], int(token[2] or 1)), token.end()
    return unit
