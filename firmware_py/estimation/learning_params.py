"""When the filter may learn: `[estimation.learning]`."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.estimation.fixed_lag_buffer import FixedLagBufferParams
from firmware_py.params import TakesEffect, param, table


@dataclass(frozen=True, slots=True)
class LearningParams:
    """When the filter may learn."""

    enabled: bool = param(
        True,
        doc="false: the coefficients of the vehicle file are all that is known.",
        mav="ENABLED",
        when=TakesEffect.RESTART,
    )
    depth_min: float = param(
        1.0,
        unit="m",
        low=0.0,
        high=100.0,
        doc="Nothing is learned where it may be nearer to the surface.",
        mav="DEPTH",
    )
    speed_min: float = param(
        0.3, unit="m/s", low=0.0, high=5.0, doc="Nothing is learned slower over ground.", mav="SPEED"
    )
    gap_max: float = param(
        600.0,
        unit="s",
        low=0.5,
        high=3600.0,
        doc="After so long without DVL nothing is learned, and the filter tells no velocity.",
        mav="GAP_MAX",
    )
    horizon: FixedLagBufferParams = table(FixedLagBufferParams)
