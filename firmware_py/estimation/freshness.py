"""Whether a value is new: asked by the filters of `navigation`. `fixed_lag_buffer` has a rule of its own."""

from __future__ import annotations

from typing import Any

from firmware_py.records.sensing import Heard

_SLACK = 1e-6
"""Times that went through another unit may be rounded past now, s."""


def is_fresh(heard: Heard[Any], since: float, t: float) -> bool:
    """True if the value came this tick, its sensor vouches for it, and it is valid after `since` and not after t, s.

    So what is told twice or out of order is not counted again, and what claims to be from the future not at all.
    """
    return heard.fresh and heard.ok and since < heard.t_valid <= t + _SLACK
