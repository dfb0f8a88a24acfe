"""What an axis keeps of its fins' effect, and what that makes of coefficients."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.records.health import FinHealth

_FIN_TERMS = ("M_ds", "Y_dr", "N_dr")
_PART = 0.7
"""Between what all fins do and what half of them do."""
_SIGMA = 3.0


class Effect(NamedTuple):
    """What the fins of an axis do, of what vehicle.toml says, and its 1 sigma."""

    share: float
    std: float


def surest(one: Effect, other: Effect) -> Effect:
    """Return the one that is surely greater than the other, or more likely so."""
    return max(one, other, key=lambda effect: effect.share - _SIGMA * effect.std)


def halved(whole: Effect, now: Effect) -> bool:
    """Return whether fins do about half, or less, of what they did: by 3 sigma of both."""
    return now.share < _PART * whole.share - _SIGMA * math.hypot(_PART * whole.std, now.std)


def beyond(proven: float, now: Effect) -> bool:
    """Return whether fins seem to do more than they can, beside the share that was proven: the filter errs."""
    return _PART * now.share > proven


def whole_again(whole: Effect, now: Effect) -> bool:
    """Return whether fins do surely more than half of what they did: by 3 sigma of both."""
    return now.share > _PART * whole.share + _SIGMA * math.hypot(_PART * whole.std, now.std)


def share_left(shares: Sequence[float], left: Sequence[FinHealth]) -> float:
    """Return the share of their effect that the fins of an axis have left.

    None left counts as all: no law flies then, and a rule brings the vehicle up.

    Args:
        shares: what each fin adds to the axis.
        left: what is left of each; empty: all are sound. One that stays counts: the allocator has others do its work.
    """
    fins = [(abs(share), 1.0 if fin.is_stuck else fin.effect) for share, fin in zip(shares, left, strict=False)]
    whole, part = sum([share for share, _ in fins]), sum([share * effect for share, effect in fins])
    return part / whole if part > 0.0 else 1.0


def with_share(names: Sequence[str], values: Sequence[float], share: float) -> tuple[float, ...]:
    """Return the values of the named coefficients with this share of the fins' effect."""
    return tuple([v * share if name in _FIN_TERMS else v for v, name in zip(values, names, strict=True)])
