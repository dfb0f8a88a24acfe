"""The Munk moment: what added mass alone does across the flow, beside the coefficients that hold all of it.

A hull that meets the flow at an angle is turned across it, by (Y_vdot - X_udot) u v and (X_udot - Z_wdot) u w: a part
of -C_A(nu) nu (Fossen 2011, Eq. 6.43). Lift of hull and fins takes some of it away.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from sternplane.vehicles.finding import Finding, Grade

MUNK = {"N_v": (("Y_vdot", 1.0), ("X_udot", -1.0)), "M_w": (("X_udot", 1.0), ("Z_wdot", -1.0))}
"""Added mass, and its sign, by the coefficient that has the moment."""
_LEAST, _MOST = 0.05, 1.25
"""Share of the Munk moment that is usual: 0.16 and 0.43 on NPS AUV II, 0.58 on REMUS 100, 0.49 on LAUV. More than all
of it takes fins ahead of the origin; less than none takes tail fins that weathercock the hull into the flow."""


def munk_moments(coefficients: Mapping[str, float]) -> dict[str, float]:
    """Return N_v and M_w by added mass alone, without dimension; none of a plane whose added mass is not known."""
    return {
        name: sum(sign * coefficients.get(given, 0.0) for given, sign in parts)
        for name, parts in MUNK.items()
        if coefficients.get("Y_vdot" if name == "N_v" else "Z_wdot")
    }


def judged(coefficients: Mapping[str, float]) -> Iterator[Finding]:
    """Yield whether N_v and M_w are what is usual beside the Munk moment."""
    odd: list[tuple[str, float]] = []
    usual: list[tuple[str, float]] = []
    for name, munk in munk_moments(coefficients).items():
        share = coefficients.get(name, 0.0) / munk if munk else math.nan
        text = f"{name} = {coefficients.get(name, 0.0):.4g}, by added mass alone {munk:.4g}"
        (usual if not share < _LEAST and not share > _MOST else odd).append((text, share))
    for text, share in odd:
        twice, lost = "is it counted twice?", 'coriolis = "full" of a table adds it, see configs/hull.md'
        why = f"{100.0 * share:.0f} % of it, which few hulls have; {twice if share > _MOST else lost}"
        yield Finding("Munk moment", Grade.WARN, f"{text}: {why}")
    if usual and not odd:
        yield Finding("Munk moment", Grade.PASS, "; ".join(text for text, _ in usual))
