"""One axis under sliding mode: the design follows the speed, and a slow integral learns what the model leaves out."""

from __future__ import annotations

from firmware_py.control.sliding_mode_gains import SlidingGains
from firmware_py.control.sliding_mode_design import DesignError, Sliding, design, law
from firmware_py.marine import clip
from firmware_py.params import ParamError
from firmware_py.vehicle.linear_models import Linear, Row


class SlidingAxis:
    """Remembers one number: the fin angle, rad, that answers the steady disturbance."""

    def __init__(self, gains: SlidingGains, model: Linear, last: float) -> None:
        self._gains, self._last = gains, last
        try:
            self._sliding = self._design(model, 1.0)
        except DesignError as error:
            raise ParamError(f"coefficients: {error}") from None
        self._memory = 0.0

    def schedule(self, model: Linear, pace: float) -> None:
        """Designs anew for `pace` times the trim speed; a model that cannot be designed for changes nothing."""
        try:
            self._sliding = self._design(model, pace)
        except DesignError:
            return

    def update(self, error: Row, delta_d: float, limit: float, dt: float) -> tuple[float, float]:
        """(fin angle, rad, within `limit`; sigma). The integral rests outside the boundary layer and at the limit."""
        sliding, gains = self._sliding, self._gains
        delta, sigma = law(sliding, error, delta_d)
        delta -= self._memory
        if gains.integral_time > 0.0 and -limit < delta < limit and abs(sigma) < sliding.phi_b:
            rate = sliding.eta / (sliding.phi_b * sliding.s_b * gains.integral_time)
            self._memory = clip(self._memory + dt * rate * sigma, -gains.trim_max, gains.trim_max)
        return clip(delta, -limit, limit), sigma

    def _design(self, model: Linear, pace: float) -> Sliding:
        gains = self._gains
        scale = pace if gains.scaled else 1.0
        slow, fast = gains.poles
        sliding = design(model, (slow * scale, fast * scale), self._last, gains.delta_sw, gains.phi_b)
        if gains.phi_b > 0.0:
            return sliding
        return sliding._replace(phi_b=sliding.eta / (gains.bandwidth * scale))

    def reset(self) -> None:
        """Forgets the disturbance."""
        self._memory = 0.0

    def freeze(self) -> float:
        """All it remembers."""
        return self._memory

    def thaw(self, memory: float) -> None:
        """Takes up again what `freeze` gave."""
        self._memory = memory
