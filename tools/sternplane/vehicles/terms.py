"""The term that each coefficient multiplies, spelled out: the names of SNAME, of MSS and of Prestero are read here.

A name is a force or moment and the factors of a product: `Y_v`, `Yuv` and `Yv` are sway force by u v, `Yuudr` and
`Y_dr` by u|u| delta_r. What a name leaves out are powers of u, since every force goes with the square of speeds.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from dataclasses import fields
from typing import NamedTuple

from sim_bridge.plant.coefficients import PlantCoefficients, length_power

_AXES = "XYZKMN"
_MOTION = "uvwpqr"
_DIRECT = ("Y_v", "Z_w", "K_p", "M_q", "N_r")
"""Damping that takes |u|, so that it damps astern too."""
_FINS = {"ds": "delta_s", "dr": "delta_r", "db": "delta_b"}
_TOKEN = re.compile(r"prop|[uvwpqr]dot|dot[uvwpqr]|\|?[uvwpqr]\|?|d[srb]|n")
NAMES = tuple(field.name for field in fields(PlantCoefficients))
"""Every coefficient that the simulated vehicle knows; the autopilot's model knows all but X_dbdb."""


class Term(NamedTuple):
    """A force or moment, and the factors of a product: motions, `udot`, fins, `prop`, and `n` for the race.

    Attributes:
        axis: X, Y, Z, K, M or N.
        factors: sorted; every u that is in the product, also what the name leaves out.
        bars: one of the factors stood in bars: the term is odd in it.
    """

    axis: str
    factors: tuple[str, ...]
    bars: bool = False

    @property
    def speeds(self) -> int:
        """Return how many of the factors are velocities or rates."""
        return sum(1 for factor in self.factors if factor in _MOTION)

    @property
    def is_inertia(self) -> bool:
        """Return whether it is added mass."""
        return any(factor.endswith("dot") for factor in self.factors)

    @property
    def power(self) -> int:
        """Return the power of L in its scale rho/2 L^k."""
        return length_power(f"{self.axis}_{''.join(f for f in self.factors if f != 'n') or 'u'}")

    @property
    def fins(self) -> int:
        """Return how many of the factors are fin angles."""
        return sum(1 for factor in self.factors if factor in _FINS)

    def with_speed(self, count: int) -> Term:
        """Return the term with so many more factors u."""
        return self._replace(factors=tuple(sorted((*self.factors, *("u",) * count))))


def parse(name: str) -> Term | None:
    """Return the term that a published name spells, with the factors it names and no others; None if it spells none."""
    text = unicodedata.normalize("NFD", name).replace("\u0307", "dot")
    axis, rest = text.strip()[:1], text.strip()[1:]
    if axis not in tuple(_AXES):
        return None
    rest = _plain(rest, axis)
    tokens = _TOKEN.findall(rest)
    if not tokens or "".join(tokens) != rest:
        return None
    factors = [token.strip("|") for token in tokens]
    factors = [f"{factor[3]}dot" if factor.startswith("dot") else factor for factor in factors]
    return Term(axis, tuple(sorted(factors)), "|" in rest)


def _plain(text: str, axis: str) -> str:
    """Return the factors without what typesetting adds; a fin without a name is that of the axis."""
    text = re.sub(r"[\s_{}'’′\\*()$^,.]", "", text).replace("δ", "delta").replace("Δ", "delta").lower()
    text = re.sub(r"del(?:ta)?(?=[srbe])", "d", text)
    text = re.sub(r"del(?:ta)?", "ds" if axis in "XZM" else "dr", text)
    return text.replace("de", "ds")


def term_of(name: str) -> Term:
    """Return the term of one of our coefficients, with every u: Y_v is u v, X_dsds is u u ds ds, M_qdot is qdot.

    Raises:
        ValueError: it is none of ours.
    """
    found = parse(name)
    if found is None or name not in NAMES:
        raise ValueError(f"{name!r} is no coefficient")
    return found if found.is_inertia else found.with_speed(2 - found.speeds)


OURS = {term_of(name): name for name in NAMES}
"""The coefficient of each term."""


def product(name: str) -> str:
    """Return what a coefficient multiplies, as it is computed, such as `|u| q` or `u |u| delta_s`; times rho/2 L^k."""
    term = term_of(name)
    if term.is_inertia:
        return f"{term.factors[0][0]}_dot"
    count = Counter(term.factors)
    race = "eps(n) " if count["n"] else ""
    speeds = [factor for factor in _MOTION[1:] for _ in range(count[factor])]
    fins = [_FINS[factor] for factor in _FINS for _ in range(count[factor])]
    ahead = count["u"]
    first = ["|u|" if name.rstrip("n") in _DIRECT else "u"] if ahead == 1 else ["u |u|"] if ahead == 2 else []
    return " ".join([*first, *([race.strip()] if race else []), *_powers([*speeds, *fins])])


def _powers(factors: list[str]) -> list[str]:
    return [factor if times == 1 else f"{factor}^{times}" for factor, times in Counter(factors).items()]


def scale(name: str) -> str:
    """Return the scale of a coefficient, `rho/2 L^3`."""
    return f"rho/2 L^{length_power(name)}"


def unit(name: str) -> str:
    """Return the unit of a coefficient times its scale: N or N m over the unit of its product; fin angles in rad."""
    power, fins = length_power(name), term_of(name).fins
    mass = {2: "kg/m", 3: "kg", 4: "kg m", 5: "kg m^2"}[power]
    return f"{mass} / rad{'^2' if fins == 2 else ''}" if fins else mass


def elsewhere(name: str) -> str:
    """Return how MSS and Prestero write it: `Yuv`, `Muuds`, `Xudot`."""
    term = term_of(name)
    if term.is_inertia or "prop" in term.factors:
        return name.replace("_", "")
    count = Counter(term.factors)
    order = ("u", "v", "w", "p", "q", "r", "ds", "dr", "db", "n")
    return term.axis + "".join(factor * count[factor] for factor in order)
