"""PID laws, the baseline: they get the same errors and the same feed-forward as the sliding-mode laws.

The gains are those at the trim speed. At `speed_ratio` times that speed the rate gain is divided by the ratio and the
integral gain multiplied by it, so that the loop answers over the same distance travelled, as that of the sliding-mode
laws does: the fins' forces go with u^2, and poles in proportion to u ask for accelerations that go with u^2 per angle,
u per rate and u^3 per integrated angle.
"""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.vehicle.linear_models import LinearModel, Vector3

_NO_SIGMA = 0.0
"""A PID has no sliding variable."""


@dataclass(frozen=True, slots=True)
class PidGains:
    """Gains of heading by rudders: rad of rudder per rad of heading error, and so on. All chosen here."""

    k_rate: float = param(
        5.0, low=0.0, high=100.0, doc="Rudder angle per yaw rate error, s. Larger: more damping.", mav="K_RATE"
    )
    k_angle: float = param(
        4.0, low=0.0, high=100.0, doc="Rudder angle per heading error. Larger: faster, less damped.", mav="K_ANGLE"
    )
    k_integral: float = param(
        0.05,
        unit="1/s",
        low=0.0,
        high=100.0,
        doc="Rudder angle per heading error and second. Larger: faster trim, less damped. 0: off.",
        mav="K_INT",
    )
    trim_max: float = param(
        5.0, unit="deg", low=0.0, high=20.0, doc="Greatest rudder angle of the integral.", mav="TRIM"
    )


@dataclass(frozen=True, slots=True)
class DepthPidGains(PidGains):
    """Gains of depth by stern planes, a cascade: depth error to pitch, pitch error to stern plane."""

    k_rate: float = param(
        3.5, low=0.0, high=100.0, doc="Stern plane angle per pitch rate error, s. Larger: more damping.", mav="K_RATE"
    )
    k_angle: float = param(
        5.5, low=0.0, high=100.0, doc="Stern plane angle per pitch error. Larger: faster, less damped.", mav="K_ANGLE"
    )
    k_depth: float = param(
        0.13,
        low=0.0,
        high=10.0,
        doc="Commanded pitch per depth error, rad/m. Larger: faster, less damped.",
        mav="K_DEPTH",
    )
    k_integral: float = param(
        0.001,
        low=0.0,
        high=10.0,
        doc="Commanded pitch per depth error and second, rad/(m s). Larger: faster trim, less damped. 0: off.",
        mav="K_INT",
    )
    pitch_max: float = param(
        15.0, unit="deg", low=0.0, high=45.0, doc="Greatest pitch that a depth error commands.", mav="PITCH"
    )
    trim_max: float = param(8.0, unit="deg", low=0.0, high=20.0, doc="Greatest pitch of the integral.", mav="TRIM")


class HeadingPidLaw:
    """An `AxisLaw` for x = (v, r, psi). Its memory is the integral, rad of rudder."""

    def __init__(self, gains: PidGains) -> None:
        self._gains = gains
        self._speed_ratio = 1.0
        self._integral = 0.0

    def schedule(self, model: LinearModel, speed_ratio: float, caution: float) -> None:  # noqa: ARG002
        """Scale the gains for `speed_ratio` times the trim speed."""
        self._speed_ratio = speed_ratio

    def update(self, error: Vector3, delta_ff: float, limit: float, dt: float) -> tuple[float, float]:
        """Return the rudder angle (rad, within +-`limit`) and 0 for sigma.

        delta_r = delta_ff + k_rate e_r + k_angle e_psi + integral. A positive rudder turns to port (N_dr < 0), so the
        gains are positive. Anti-windup: the integral is held while the rudder is at its limit.
        """
        gains = self._gains
        _, e_r, e_psi = error
        delta = delta_ff + gains.k_rate / self._speed_ratio * e_r + gains.k_angle * e_psi + self._integral
        if -limit < delta < limit:
            step = dt * gains.k_integral * self._speed_ratio * e_psi
            self._integral = clip(self._integral + step, -gains.trim_max, gains.trim_max)
        return clip(delta, -limit, limit), _NO_SIGMA

    def reset(self) -> None:
        """Clear the integral."""
        self._integral = 0.0

    def freeze(self) -> float:
        """Return the whole memory."""
        return self._integral

    def thaw(self, memory: float) -> None:
        """Restore the memory that `freeze` returned."""
        self._integral = memory


class DepthPidLaw:
    """An `AxisLaw` for x = (q, theta, z), a cascade. Its memory is the integral, rad of pitch."""

    def __init__(self, gains: DepthPidGains) -> None:
        self._gains = gains
        self._speed_ratio = 1.0
        self._integral = 0.0

    def schedule(self, model: LinearModel, speed_ratio: float, caution: float) -> None:  # noqa: ARG002
        """Scale the gains for `speed_ratio` times the trim speed."""
        self._speed_ratio = speed_ratio

    def update(self, error: Vector3, delta_ff: float, limit: float, dt: float) -> tuple[float, float]:
        """Return the stern plane angle (rad, within +-`limit`) and 0 for sigma.

        theta_c = k_depth e_z + integral, within +-pitch_max; delta_s = delta_ff + k_rate e_q + k_angle (e_theta -
        theta_c). Too deep (e_z > 0) gives theta_c > 0, bow up; a positive stern plane pitches the bow down (M_ds < 0).
        Anti-windup: the integral is held while stern plane or theta_c is at its limit.
        """
        gains = self._gains
        e_q, e_theta, e_z = error
        unlimited = gains.k_depth * e_z + self._integral
        theta_c = clip(unlimited, -gains.pitch_max, gains.pitch_max)
        delta = delta_ff + gains.k_rate / self._speed_ratio * e_q + gains.k_angle * (e_theta - theta_c)
        if -limit < delta < limit and theta_c == unlimited:
            step = dt * gains.k_integral * self._speed_ratio * e_z
            self._integral = clip(self._integral + step, -gains.trim_max, gains.trim_max)
        return clip(delta, -limit, limit), _NO_SIGMA

    def reset(self) -> None:
        """Clear the integral."""
        self._integral = 0.0

    def freeze(self) -> float:
        """Return the whole memory."""
        return self._integral

    def thaw(self, memory: float) -> None:
        """Restore the memory that `freeze` returned."""
        self._integral = memory
