"""Sliding-mode law of one axis: scheduled with the speed, with an integral for the steady disturbance.

Poles grow with the speed, as what fins do does. The righting moment does not: poles that are slower than those that the
hull has by it have the planes hold against it, at low speed to the ends of their travel, where the vehicle dives on at
any error of depth. So poles are as fast as those are, but for their sake not faster than at the trim speed.
"""

from __future__ import annotations

import math

from firmware_py.control.sliding_mode_design import (
    DesignError,
    SlidingDesign,
    cautious_poles,
    control_law,
    design_sliding_mode,
)
from firmware_py.control.sliding_mode_params import SlidingGains
from firmware_py.marine import clip
from firmware_py.params import ParamError
from firmware_py.vehicle.linear_models import LinearModel, Vector3

_FAR = 2.0
"""In boundary layers: from there on the switching term is spent, tanh(2) = 0.96."""


class SlidingModeLaw:
    """An `AxisLaw`. Its memory is the fin angle (rad) that balances the steady disturbance, s'delta_f of Eq. 25.

    Raises:
        ParamError: no design exists for the model at the trim speed.
    """

    def __init__(self, gains: SlidingGains, model: LinearModel, s_last: float) -> None:
        """Design for `model`, the one at the trim speed; `s_last` is the last entry of s, which scales sigma."""
        self._gains, self._s_last = gains, s_last
        try:
            self._design = self._design_for(model, 1.0, 0.0)
        except DesignError as error:
            raise ParamError(f"coefficients: {error}") from None
        self._trim = 0.0

    def schedule(self, model: LinearModel, speed_ratio: float, caution: float) -> None:
        """Redesign for the model at `speed_ratio` times the trim speed; keep the old design if there is none for it."""
        try:
            self._design = self._design_for(model, speed_ratio, caution)
        except DesignError:
            return

    def update(self, error: Vector3, delta_ff: float, limit: float, dt: float) -> tuple[float, float]:
        """Return the fin angle (rad, within +-`limit`) and sigma: Eq. 25 (`control_law`) minus the trim angle.

        trim_dot = eta sigma / (phi_b s'b integral_time): the slope of the switching term at sigma = 0, over the
        integral's time. Anti-windup: outside the boundary layer, and at the fin's limit, the trim grows no further. Far
        outside, where the switching term can do no more, it becomes less, as fast as at the layer's edge: one that is
        wrong, as one that was found at the surface, outdoes that term, and the vehicle would never come back.
        """
        design, gains = self._design, self._gains
        delta, sigma = control_law(design, error, delta_ff)
        delta -= self._trim
        if gains.integral_time > 0.0:
            slope = design.eta / (design.phi_b * design.s_b * gains.integral_time)
            step = dt * slope * clip(sigma, -design.phi_b, design.phi_b)
            inside = -limit < delta < limit and abs(sigma) < design.phi_b
            if inside or (abs(sigma) > _FAR * design.phi_b and step * self._trim < 0.0):
                self._trim = clip(self._trim + step, -gains.trim_max, gains.trim_max)
        return clip(delta, -limit, limit), sigma

    def _design_for(self, model: LinearModel, speed_ratio: float, caution: float) -> SlidingDesign:
        gains = self._gains
        p1, p2 = gains.poles
        scale = 1.0
        if gains.scaled:
            scale = max(speed_ratio, min(1.0, math.sqrt(model.righting / (p1 * p2))))
        poles = cautious_poles(model, (p1 * scale, p2 * scale), caution)
        design = design_sliding_mode(model, poles, self._s_last, gains.delta_sw, gains.phi_b)
        if gains.phi_b > 0.0:
            return design
        return design._replace(phi_b=design.eta / (gains.bandwidth * scale))

    def reset(self) -> None:
        """Clear the trim angle."""
        self._trim = 0.0

    def freeze(self) -> float:
        """Return the whole memory."""
        return self._trim

    def thaw(self, memory: float) -> None:
        """Restore the memory that `freeze` returned."""
        self._trim = memory
