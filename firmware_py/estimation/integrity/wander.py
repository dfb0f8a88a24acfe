"""How far eddies may carry a hull that nothing sees: by how unsteady its drift is from what propeller and pitch make.

Flights in eddies of 0.1 m/s drift by 0.6, 2.0 and 4.9 m (1 sigma) in 5, 20 and 60 s. The change of the drift in 5 s
differs from that in the 5 s before by 0.26 m (median), in the least steady minute of some by 0.4 m. In eddies twice as
strong all of it is twice as much.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from firmware_py.estimation.integrity.depth_arbitration import Accused, Entry, bottom_says

_WANDER_5S, _WANDERS = 5.0, (18.0, 42.0)
"""3.5 sigma of the drift in 5 s, and in 20 and 60 s, by the least steady minute."""
_UNKNOWN = 0.5
"""Assumed before 15 s of a flight have shown how unsteady it is, m: eddies of 0.15 to 0.2 m/s."""
_SHARE = 0.98
"""The least steady minute counts, and by this share less at each look, every 5 s: half after 3 minutes."""
_WINDOWS = (80, 240)
"""Entries of the history over which pressure is compared with pitch and speed alone: 20 and 60 s."""
_LAG, _EVERY = 20, 4
"""Entries of the history in 5 s; of so many one is looked at."""


def wander_5s(unsteady: float) -> float:
    """Return how far eddies may carry a hull in 5 s, m."""
    return _WANDER_5S * (unsteady if unsteady == unsteady else _UNKNOWN)


def wanders(unsteady: float) -> tuple[float, float]:
    """Return how far eddies may carry a hull in 20 and in 60 s, m."""
    known = unsteady if unsteady == unsteady else _UNKNOWN
    return _WANDERS[0] * known, _WANDERS[1] * known


def wandered(
    now: Entry,
    history: Sequence[Entry],
    size: int,
    limits: tuple[float, float],
    unsteady: float,
    decide: Callable[[Entry, Entry, int], Accused],
) -> tuple[Accused, int]:
    """Compare pressure with pitch and speed over 20 and 60 s without DVL; return who is accused, over how many entries.

    Where over 20 s a bottom spoke for a pressure that became less deep, it is in doubt beyond what holds for 60 s.

    Args:
        now: the newest entry.
        history: those before;
        size: so many of them are comparable.
        limits: what pitch and speed may be off by in 20 and in 60 s of still water, m.
        unsteady: as in `VerticalCheckMemory`.
        decide: tells who is wrong now, if nobody was then, so many entries ago.
    """
    cleared = False
    for window, floor, wander in zip(_WINDOWS, limits, wanders(unsteady), strict=True):
        if size < window and not cleared:
            break
        entries = min(window, size)
        then = history[-entries]
        change = now.residual - then.residual
        if not now.blind_since(then) or abs(change) <= floor:
            continue
        if abs(change) > floor + wander:
            if cleared:
                return Accused.SHALLOW_PRESSURE, entries
            accused = decide(now, then, entries)
            if accused is not Accused.NOBODY or change > 0.0:
                return accused, entries
            cleared = True
        elif bottom_says(now, then, history, entries) is Accused.PRESSURE_DRIFT:
            return Accused.PRESSURE_DRIFT, entries
    return Accused.NOBODY, 0


def look(history: Sequence[Entry], before: float) -> float:
    """Return how unsteady the drift from propeller and pitch is, m; NaN if that is not known yet.

    A DVL, while there is one, does not make it less: what eddies do shows before they have to be reckoned with. The
    median passes over a pressure that steps, or begins to drift.

    Args:
        history: of depth by pressure and by the model.
        before: what it was at the last look.
    """
    if len(history) < 3 * _LAG:
        return before
    lag = _LAG // _EVERY
    drift = [entry.depth - entry.model for entry in history[::_EVERY]]
    changes = sorted(abs(drift[i] - 2.0 * drift[i + lag] + drift[i + 2 * lag]) for i in range(len(drift) - 2 * lag))
    now, before = changes[len(changes) // 2], _SHARE * before
    return before if before > now and math.isfinite(before) else now
