"""Added mass and damping of the wrong sign: tables of the matrices M_A and D list both as positive numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from firmware_py.params import ParamError
from sternplane.vehicles.derivative_table import Entry
from sternplane.vehicles.terms import OURS, Term, parse

_OWN = dict(zip("XYZKMN", "uvwpqr", strict=True))
"""The motion along or about each axis. What it does to its own force has the same sign in whatever axes."""
_MOST_NAMED = 6


class _Wrong(NamedTuple):
    name: str
    value: float


def refuse_driving(entries: Iterable[Entry], coefficients: Mapping[str, float], where: str) -> None:
    """Refuse added mass and damping that would drive a motion in place of opposing it.

    Args:
        entries: of the table.
        coefficients: what its linear damping comes to: of two that are summed, one may be above 0.
        where: the file.

    Raises:
        ParamError: which they are, and what to write.
    """
    wrong = []
    for name, value, _ in entries:
        term = parse(name)
        if term is not None and isinstance(value, float) and value > 0.0 and _drives(term, coefficients):
            wrong.append(_Wrong(name, value))
    if not wrong:
        return
    shown, more = wrong[:_MOST_NAMED], ", ..." if len(wrong) > _MOST_NAMED else ""
    given = ", ".join([f"{one.name} = {one.value:g}" for one in shown])
    right = ", ".join([f"{-one.value:g}" for one in shown])
    raise ParamError(
        f"{where}: {given}{more}: must be below 0: added mass and damping are forces against the motion here, and many "
        f"tables list -X_udot, -N_rr, ... or the matrices M_A and D, which are positive; write {right}{more}"
    )


def _drives(term: Term, coefficients: Mapping[str, float]) -> bool:
    """Return whether a term above 0 drives the motion of its own axis."""
    own = _OWN[term.axis]
    if term.factors in ((f"{own}dot",), (own, own)):
        return True
    if own == "u":
        return term.factors == ("u",)
    linear = OURS.get(Term(term.axis, tuple(sorted(("u", own)))), "")
    return term.factors in ((own,), tuple(sorted(("u", own)))) and coefficients.get(linear, 0.0) > 0.0
