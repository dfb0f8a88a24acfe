"""Published derivatives made into our coefficients; each says what became of it, and none is dropped without a word.

A derivative in SI that names no speed holds at one, and is divided by it; one with the prime is ours already. Damping
by squares (Y_vv, Z_ww) becomes cross-flow drag; what that leaves of N_rr and M_qq, and K_pp, N_vv and so on, are made
linear at an amplitude a: f|f| is taken for 8 / (3 pi) a f, which takes the same work out of a sine (equivalent
linearisation).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from firmware_py.error_text import quoted, shortened
from firmware_py.params import ParamError
from sternplane.vehicles.derivative_table import Entry
from sternplane.vehicles.particulars import MissingError, Particulars, unknown_text
from sternplane.vehicles.signs import refuse_driving
from sternplane.vehicles.terms import OURS, Term, parse
from sternplane.vehicles.units import Unit, parse_unit

_EQUIVALENT = 8.0 / (3.0 * math.pi)
_AMPLITUDES = {"v": 0.1, "w": 0.05, "p": 0.2, "q": 0.1, "r": 0.2}
"""Share of the speed for v and w; rad/s, at a hull of 1.33 m and 1.54 m/s, for p, q, r: see configs/remus100."""
_CROSS_FLOW_MAX = 5.0
"""A cylinder across the flow has 1.1, a flat plate 2."""
_REFERENCE = 1.54 / 1.33
_MOST_NAMED = 8


class Became(NamedTuple):
    """What became of an entry of the table: its name and value there, ours, and a remark; ours is "" if nothing."""

    name: str
    value: str
    ours: str
    remark: str = ""


@dataclass
class Converted:
    """Our coefficients and drag, and what became of each entry of a table.

    Attributes:
        coefficients: by our name.
        drag: C_d0, C_dy, C_dz, as far as the table has them.
        rows: what became of each entry.
    """

    coefficients: dict[str, float] = field(default_factory=dict)
    drag: dict[str, float] = field(default_factory=dict)
    rows: list[Became] = field(default_factory=list)

    @property
    def lost(self) -> list[Became]:
        """Return the entries that became nothing."""
        return [row for row in self.rows if not row.ours]


def convert(entries: Iterable[Entry], hull: Particulars, required: Collection[str] = ()) -> Converted:
    """Return our coefficients of a table.

    Args:
        entries: the derivatives.
        hull: complete.
        required: coefficients that no law can do without.

    Raises:
        ParamError: two entries are the same derivative, one has an impossible value or the wrong sign, or a required
            one a unit that it cannot have.
    """
    entries = tuple(entries)
    _refuse_twice(entries, hull.where)
    made, squares = Converted(), []
    for entry in entries:
        term = parse(entry.name)
        if term is not None and not (isinstance(entry.value, float) and math.isfinite(entry.value)):
            said = "must be a finite number; take the row out if it is not known"
            raise ParamError(f"{hull.where}: {entry.name} = {quoted(entry.value)}: {said}")
        shown = f"{entry.value:g}" if isinstance(entry.value, float) else str(entry.value)
        if term is None or not isinstance(entry.value, float):
            why = f"no derivative and no particular; {unknown_text(entry.name)}"
            made.rows.append(Became(entry.name, shown, "", why))
            continue
        value, full, remark = _whole(entry, term, hull)
        if value is None and OURS.get(term._replace(bars=False).with_speed(max(2 - term.speeds, 0))) in required:
            raise ParamError(f"{hull.where}: {entry.name} = {shown}: {remark}; no law can do without it")
        if value is None:
            made.rows.append(Became(entry.name, shown, "", remark))
        elif _is_square(full, term.bars):
            squares.append((entry, full, value, remark))
        else:
            made.rows.append(_placed(made, entry.name, shown, full, value, remark))
    refuse_driving(entries, made.coefficients, hull.where)
    _linearise(made, squares, hull)
    _turn_fins(made)
    return made


def _refuse_twice(entries: Iterable[Entry], where: str) -> None:
    """Refuse a derivative under two names, such as Yvdot and Y_vdot; Yv and Yuv are two products, and add."""
    named: dict[Term, str] = {}
    for entry in entries:
        term = parse(entry.name)
        if term is None:
            continue
        plain = term._replace(bars=False)
        # bars tell a product such as v|r| from v r; damping by squares is odd without them too
        known = term if _is_odd(term) and not _is_square(plain, False) else plain
        if known in named:
            both = f"{quoted(named[known])} and {quoted(entry.name)}"
            raise ParamError(f"{where}: {both} are the same derivative, which has one value; leave one of them out")
        named[known] = entry.name


def _whole(entry: Entry, term: Term, hull: Particulars) -> tuple[float | None, Term, str]:
    """Return a derivative without dimension, the term with every u, and a remark; None and why if it cannot be one."""
    assert isinstance(entry.value, float)
    if term.speeds > 2 or term.fins > 2 or (term.is_inertia and len(term.factors) > 1):
        return None, term, "a product of more than two; the model has none of these"
    prime, value, remark = hull.texts.get("form") == "prime" or entry.name[-1:] in "'’′", entry.value, ""
    unit = parse_unit(entry.unit) if entry.unit else None
    if entry.unit and unit is None:
        return None, term, f"its unit {entry.unit} is not understood; write one such as kg m/s"
    if unit is not None:
        value, prime = value * unit.factor, unit.is_plain
        if not prime:
            more = _more_speeds(unit, term)
            if more is None or not 0 <= more <= 2 - term.speeds:
                return None, term, f"its unit {entry.unit} is not that of {entry.name}, {_unit_text(term)}"
            if more:
                term, remark = term.with_speed(more), f"by its unit for {'u ' * more}".rstrip() + " too"
    missing = 0 if term.is_inertia else 2 - term.speeds
    full = term.with_speed(missing)
    if prime:
        return value, full, remark
    U = hull.get("speed_m_s")
    if missing:
        remark = f"holds at {U:g} m/s" + ("" if not remark else f"; {remark}")
    return value / (U**missing * _scale(full, hull)), full, remark


def _scale(term: Term, hull: Particulars) -> float:
    return 0.5 * hull.get("density_kg_m3") * hull.get("length_m") ** term.power


def _exponents(term: Term) -> tuple[int, int]:
    """Return the exponents of m and s in the SI unit of a derivative by the factors that it names."""
    moving = [factor for factor in term.factors if factor[0] in "uvwpqr" and factor != "prop"]
    ways = sum(1 for factor in moving if factor[0] in "uvw")
    motions = sum(2 if factor.endswith("dot") else 1 for factor in moving)
    return (2 if term.axis in "KMN" else 1) - ways, motions - 2


def _more_speeds(unit: Unit, term: Term) -> int | None:
    """Return for how many more factors u a unit is than its term names; None if it is no such unit."""
    m, s = _exponents(term)
    more = unit.s - s
    return more if unit.kg == 1 and unit.m == m - more else None


def _unit_text(term: Term) -> str:
    m, s = _exponents(term)
    return " ".join(["kg", *(f"{name}^{power}" for name, power in (("m", m), ("s", s)) if power)])


def _is_square(term: Term, bars: bool) -> bool:
    """Return whether a term is f|f| of v, w, p, q or r, odd in it, which the model does not have."""
    doubled = len(term.factors) == 2 and term.factors[0] == term.factors[1] and term.factors[0] in "vwpqr"
    return doubled and term.axis != "X" and (bars or term not in OURS)


def _is_odd(term: Term) -> bool:
    """Return whether bars make a term change its sign with one of two motions."""
    return term.bars and len([factor for factor in term.factors if factor in "vwpqr"]) == 2


def _placed(made: Converted, name: str, shown: str, full: Term, value: float, remark: str) -> Became:
    plain = full._replace(bars=False)
    if plain == Term("X", ("u", "u")):
        if not value < 0.0:
            return Became(name, shown, "", "no drag")
        said = f"C_d0 {'+=' if 'C_d0' in made.drag else '='} {-value:.4g}"
        made.drag["C_d0"] = made.drag.get("C_d0", 0.0) - value
        return Became(name, shown, said, remark)
    odd = _is_odd(full)
    ours = None if odd else OURS.get(plain)
    if ours is None:
        said = f"the model has no {'odd ' if odd else ''}term {' '.join(full.factors)} in {full.axis}"
        return Became(name, shown, "", said)
    return Became(name, shown, added(made, ours, value), remark)


def added(made: Converted, ours: str, value: float) -> str:
    """Add a value to a coefficient; return that in words."""
    said = f"{ours} {'+=' if ours in made.coefficients else '='} {value:.4g}"
    made.coefficients[ours] = made.coefficients.get(ours, 0.0) + value
    return said


def _linearise(made: Converted, squares: list[tuple[Entry, Term, float, str]], hull: Particulars) -> None:
    """Take damping by squares for cross-flow drag, and what is left of it for damping at an amplitude."""
    L, rest = hull.get("length_m"), {}
    for entry, term, value, remark in sorted(squares, key=lambda one: one[1].factors[0] not in "vw"):
        key, side = {"Yv": ("C_dy", "height_m"), "Zw": ("C_dz", "width_m")}.get(term.axis + term.factors[0], ("", ""))
        if key and key not in hull.values and value < 0.0:
            made.drag[key] = -value * L / hull.get(side)
            if made.drag[key] > _CROSS_FLOW_MAX:
                raise ParamError(
                    f"{hull.where}: {entry.name} = {entry.value:g} makes {key} = {made.drag[key]:.3g}, and a cylinder "
                    "has about 1: check its power of ten and its unit"
                )
            # drag at every station damps turning by itself: the integral of |x| x^2 over the length is L^4 / 32
            turning = {"C_dy": ("N", "r"), "C_dz": ("M", "q")}[key]
            rest[turning] = value / 32.0
            made.rows.append(Became(entry.name, f"{entry.value:g}", f"{key} = {made.drag[key]:.4g}", remark))
            continue
        factor = term.factors[0]
        left = value - rest.get((term.axis, factor), 0.0)
        amplitude, said = _amplitude(factor, hull)
        U = hull.get("speed_m_s")
        a = amplitude / U if factor in "vw" else amplitude * L / U
        ours = OURS.get(Term(term.axis, tuple(sorted(("u", factor)))))
        if ours is None:
            remark = f"damping by squares, and the model has no term u {factor} in {term.axis}"
            made.rows.append(Became(entry.name, f"{entry.value:g}", "", remark))
            continue
        linear = left * _EQUIVALENT * a
        taken = "; cross-flow drag has the rest" if left != value else ""
        said = f"made linear at {said}, {U:g} m/s{taken}"
        made.rows.append(Became(entry.name, f"{entry.value:g}", added(made, ours, linear), said))


def _amplitude(factor: str, hull: Particulars) -> tuple[float, str]:
    """Return the amplitude at which a square is made linear, m/s or rad/s, and in words."""
    U = hull.get("speed_m_s")
    if factor in "vw":
        value = hull.get(f"amplitude_{factor}_m_s", _AMPLITUDES[factor] * U)
        return value, f"{factor} = {value:.3g} m/s"
    value = math.radians(
        hull.get(f"amplitude_{factor}_deg_s", math.degrees(_AMPLITUDES[factor] * U / hull.get("length_m") / _REFERENCE))
    )
    return value, f"{factor} = {value:.3g} rad/s"


def _turn_fins(made: Converted) -> None:
    """Turn the angles of fins that are counted the other way round: here M_ds and N_dr are negative."""
    for fin, moment in (("ds", "M_ds"), ("dr", "N_dr")):
        if made.coefficients.get(moment, 0.0) > 0.0:
            for name in made.coefficients:
                if name.count(fin) == 1:
                    made.coefficients[name] = -made.coefficients[name]
            said = f"{moment} is positive in the table: the angle is counted the other way here"
            made.rows.append(Became(fin, "", f"−{fin}", said))


def not_understood(entries: Iterable[Entry]) -> str:
    """Return the names of entries that are no derivatives, in words; "" if there are none."""
    names = [entry.name for entry in entries if parse(entry.name) is None]
    if not names:
        return ""
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    listed = ", ".join([shortened(name) for name in names[:_MOST_NAMED]])
    return f"; not understood: {listed}{more} (configs/hull.md tells the names)"


def needed(made: Converted, names: Iterable[str], where: str) -> None:
    """Refuse a table that lacks what no law can do without.

    Raises:
        MissingError: what is missing, and how to get it.
    """
    missing = [name for name in names if name not in made.coefficients]
    if missing:
        raise MissingError(
            f"{where}: {', '.join(missing)} missing, without which no law can be designed; write them, or take a plane "
            "from the other with symmetric = true (a round hull with equal fins)"
        )
