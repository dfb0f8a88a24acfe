"""Whether a hull that the pressure puts near the surface has sunk without it, by the depth that is carried on."""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.estimation.integrity.depth_arbitration import Entry
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.wander import wanders

_AFLOAT, _AFLOAT_BLIND = 0.05, 0.07
"""Near the surface a carried depth may sink so fast beside the pressure, m/s, with DVL and without."""


class Sinking(NamedTuple):
    """Whether pressure and carried depth still agree, and whether they contradict each other."""

    agrees: bool
    contradicts: bool


def judge(now: Entry, then: Entry, params: IntegrityParams, unsteady: float, exact: bool) -> Sinking:
    """Compare two entries near the surface; `unsteady` is as in `VerticalCheckMemory`, `exact` as in its `check`."""
    sank, time = then.residual - now.residual, now.t - then.t
    slack, least = _AFLOAT * time, params.depth_step
    if now.blind_since(then):
        slack, least = _AFLOAT_BLIND * time, params.depth_blind_20s + (0.0 if exact else wanders(unsteady)[0])
    return Sinking(sank <= slack, sank > slack + least and now.depth + sank >= params.surface)
