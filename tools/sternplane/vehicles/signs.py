"""Added mass and damping of the wrong sign: tables of the matrices M_A and D list both as positive numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.plant.truth import Truth
from sternplane.vehicles.derivative_table import Entry
from sternplane.vehicles.finding import Finding, Grade
from sternplane.vehicles.terms import OURS, Term, parse

_OWN = dict(zip("XYZKMN", "uvwpqr", strict=True))
"""The motion along or about each axis. What it does to its own force has the same sign in whatever axes."""
_ADDED_MASS = tuple(f"{axis}_{motion}dot" for axis, motion in _OWN.items())
_FIN_DRAG = ("X_dsds", "X_drdr")
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


def judged(vehicle: Vehicle, truth: Truth) -> Iterator[Finding]:
    """Yield added mass and drag of fins above 0: neither a hull nor a fin has them, whoever wrote the file."""
    believed = {name: getattr(vehicle.coefficients, name) for name in _ADDED_MASS + _FIN_DRAG}
    true = {name: getattr(truth.coefficients, name) for name in believed}
    other = {name: value for name, value in true.items() if value != believed[name]}  # not those that it takes over
    for file, values in (("vehicle.toml", believed), ("truth.toml", other)):
        for topic, names, why in (
            ("added mass", _ADDED_MASS, "the water that a hull moves makes it heavier; many tables list -X_udot, ..."),
            ("fins", _FIN_DRAG, "a fin that is turned holds the hull back, and does not push it"),
        ):
            wrong = ", ".join([f"{name} = {values[name]:g}" for name in names if values.get(name, 0.0) > 0.0])
            if wrong:
                yield Finding(topic, Grade.FAIL, f"{wrong} in {file} must be below 0: {why}")


def _drives(term: Term, coefficients: Mapping[str, float]) -> bool:
    """Return whether a term above 0 drives the motion of its own axis."""
    own = _OWN[term.axis]
    if term.factors in ((f"{own}dot",), (own, own)):
        return True
    if own == "u":
        return term.factors == ("u",)
    linear = OURS.get(Term(term.axis, tuple(sorted(("u", own)))), "")
    return term.factors in ((own,), tuple(sorted(("u", own)))) and coefficients.get(linear, 0.0) > 0.0
