"""The baseline: PID on the same errors and with the same feed-forward as the sliding-mode laws.

Its gains are those at the trim speed. With the speed the integrals go faster and less is made of rates, so that the
loop answers over the same way at any speed.
"""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.vehicle.linear_models import Linear, Row


@dataclass(frozen=True, slots=True)
class PidGains:
    """Rate and angle are rad of fin per rad/s and per rad. All ours."""

    k_rate: float = param(5.0, low=0.0, high=100.0, doc="Fin angle per yaw rate error, s.", mav="K_RATE")
    k_angle: float = param(4.0, low=0.0, high=100.0, doc="Fin angle per heading error.", mav="K_ANGLE")
    k_integral: float = param(
        0.05, unit="1/s", low=0.0, high=100.0, doc="Fin angle per second and heading error.", mav="K_INT"
    )
    trim_max: float = param(5.0, unit="deg", low=0.0, high=20.0, doc="Bound of the integral, in fin angle.", mav="TRIM")


@dataclass(frozen=True, slots=True)
class DepthPidGains(PidGains):
    """A cascade: depth asks for pitch, pitch for stern plane."""

    k_rate: float = param(3.5, low=0.0, high=100.0, doc="Stern plane per pitch rate error, s.", mav="K_RATE")
    k_angle: float = param(5.5, low=0.0, high=100.0, doc="Stern plane per pitch error.", mav="K_ANGLE")
    k_depth: float = param(0.13, low=0.0, high=10.0, doc="Pitch per depth error, rad/m.", mav="K_DEPTH")
    k_integral: float = param(
        0.001, low=0.0, high=10.0, doc="Pitch per depth error and second, rad/(m s).", mav="K_INT"
    )
    pitch_max: float = param(
        15.0, unit="deg", low=0.0, high=45.0, doc="Pitch that a depth error may ask for.", mav="PITCH"
    )
    trim_max: float = param(8.0, unit="deg", low=0.0, high=20.0, doc="Bound of the integral, in pitch.", mav="TRIM")


class PidAxis:
    """Rate, angle and the integral of the angle. Remembers the integral, rad of fin."""

    def __init__(self, gains: PidGains, rate: int, angle: int) -> None:
        self._gains, self._rate, self._angle = gains, rate, angle
        self._pace = 1.0
        self._memory = 0.0

    def schedule(self, model: Linear, pace: float) -> None:  # noqa: ARG002
        """Takes another speed, `pace` times the trim speed."""
        self._pace = pace

    def update(self, error: Row, delta_d: float, limit: float, dt: float) -> tuple[float, float]:
        """(fin angle, rad, within `limit`; 0 for want of a sigma). The integral rests at the limit."""
        gains = self._gains
        angle = error[self._angle]
        delta = delta_d + gains.k_rate / self._pace * error[self._rate] + gains.k_angle * angle + self._memory
        if -limit < delta < limit:
            step = dt * gains.k_integral * self._pace * angle
            self._memory = clip(self._memory + step, -gains.trim_max, gains.trim_max)
        return clip(delta, -limit, limit), 0.0

    def reset(self) -> None:
        """Forgets the integral."""
        self._memory = 0.0

    def freeze(self) -> float:
        """All it remembers."""
        return self._memory

    def thaw(self, memory: float) -> None:
        """Takes up again what `freeze` gave."""
        self._memory = memory


class DepthPidAxis:
    """The cascade on (q, theta, z). Remembers the integral, rad of pitch."""

    def __init__(self, gains: DepthPidGains) -> None:
        self._gains = gains
        self._pace = 1.0
        self._memory = 0.0

    def schedule(self, model: Linear, pace: float) -> None:  # noqa: ARG002
        """Takes another speed, `pace` times the trim speed."""
        self._pace = pace

    def update(self, error: Row, delta_d: float, limit: float, dt: float) -> tuple[float, float]:
        """(fin angle, rad, within `limit`; 0 for want of a sigma). The integral rests at either limit."""
        gains = self._gains
        e_q, e_theta, e_z = error
        asked = gains.k_depth * e_z + self._memory
        theta_c = clip(asked, -gains.pitch_max, gains.pitch_max)
        delta = delta_d + gains.k_rate / self._pace * e_q + gains.k_angle * (e_theta - theta_c)
        if -limit < delta < limit and theta_c == asked:
            step = dt * gains.k_integral * self._pace * e_z
            self._memory = clip(self._memory + step, -gains.trim_max, gains.trim_max)
        return clip(delta, -limit, limit), 0.0

    def reset(self) -> None:
        """Forgets the integral."""
        self._memory = 0.0

    def freeze(self) -> float:
        """All it remembers."""
        return self._memory

    def thaw(self, memory: float) -> None:
        """Takes up again what `freeze` gave."""
        self._memory = memory
