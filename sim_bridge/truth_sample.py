"""The true state of the plant, as the log keeps it beside the estimate."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.marine import Eta, Nu


@dataclass(frozen=True, slots=True)
class TruthSample:
    """The plant at one tick: `current` is the water's velocity in NED, m/s; `fins` true angles, rad; `n` rev/s.

    `drop_weight` is what of it is aboard, N.
    """

    eta: Eta
    nu: Nu
    current: tuple[float, float, float]
    fins: tuple[float, ...]
    n: float
    drop_weight: float = 0.0
