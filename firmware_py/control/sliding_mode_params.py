"""Gains of the sliding-mode laws: those of the configuration, and those of the paper."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from firmware_py.params import param

S_LAST_DEPTH = -1.0
"""Last entry of the depth surface s: sigma_z grows as the vehicle gets shallower, as in Eq. 28."""
S_LAST_HEADING = 1.0
"""Last entry of the heading surface s: sigma_psi grows as the vehicle turns to starboard, as in Eq. 32."""


class GainSet(enum.Enum):
    """Gains of the sliding-mode laws."""

    CONFIGURED = enum.auto()
    """Those of control.depth and control.heading."""
    PAPER = enum.auto()
    """The poles, switching angles and boundary layers of the paper.

    The laws are designed with them from the coefficients of the vehicle file, at each speed. So s and k are not the
    printed ones: these follow only from the printed A and b (Eq. 27, 31), which tests/laws/test_paper.py shows.
    """


@dataclass(frozen=True, slots=True)
class SlidingGains:
    """Specification of a sliding-mode design.

    Inside the boundary layer the closed loop has the poles -bandwidth and `poles`. With `scaled` these are the poles at
    the trim speed, and are proportional to u, as the hull's own poles are: the loop then answers over the same distance
    travelled at every speed, and uses about the same fin angles.
    """

    poles: tuple[float, float] = param(
        unit="1/s",
        low=-5.0,
        high=-0.01,
        doc="Poles of the motion on the sliding surface (Eq. 24). Further from 0: faster, with larger fin angles.",
        mav="POLE",
    )
    delta_sw: float = param(
        unit="rad",
        low=0.01,
        high=5.0,
        doc="Greatest fin angle of the switching term, eta / |s'b|. Larger: rejects larger disturbances.",
        mav="DELTA_SW",
    )
    bandwidth: float = param(
        1.0,
        unit="1/s",
        low=0.01,
        high=20.0,
        doc="Rate at which sigma decays inside the boundary layer. Larger: stiffer, with more fin activity.",
        mav="BANDW",
    )
    phi_b: float = param(
        0.0,
        low=0.0,
        high=100.0,
        doc="Boundary layer thickness, in units of sigma. Larger: smoother fins, larger errors. 0: eta / bandwidth.",
        mav="PHI_B",
    )
    scaled: bool = param(
        True,
        doc="true: poles and bandwidth are proportional to the speed. false: constant, as in the paper.",
        mav="SCALED",
    )
    integral_time: float = param(
        0.0,
        unit="s",
        low=0.0,
        high=1000.0,
        doc="Time constant of the integral that balances a steady disturbance. Shorter: faster, less damped. 0: off.",
        mav="INT_TIME",
    )
    trim_max: float = param(
        5.0, unit="deg", low=0.0, high=20.0, doc="Greatest fin angle of the integral.", mav="TRIM_MAX"
    )


@dataclass(frozen=True, slots=True)
class DepthSlidingGains(SlidingGains):
    """Depth by stern planes; x = (q, theta, z), sigma in m."""

    poles: tuple[float, float] = param(
        (-0.4, -0.45),
        unit="1/s",
        low=-5.0,
        high=-0.01,
        doc="Poles of the motion on the sliding surface. Further from 0: faster, with larger fin angles.",
        mav="POLE",
    )
    delta_sw: float = param(
        0.4,
        unit="rad",
        low=0.01,
        high=5.0,
        doc="Greatest stern plane angle of the switching term. Larger: rejects larger disturbances.",
        mav="DELTA_SW",
    )
    bandwidth: float = param(
        0.9,
        unit="1/s",
        low=0.01,
        high=20.0,
        doc="Rate at which sigma decays inside the boundary layer. Larger: stiffer, with more fin activity.",
        mav="BANDW",
    )
    integral_time: float = param(
        8.0,
        unit="s",
        low=0.0,
        high=1000.0,
        doc="Time constant of the integral that balances a steady pitch moment. Shorter: faster, less damped. 0: off.",
        mav="INT_TIME",
    )
    climb_bias_time: float = param(
        8.0,
        unit="s",
        low=0.0,
        high=100.0,
        doc="Time constant of the estimate of the vertical velocity beside -u theta (heave, current). 0: off.",
        mav="BIAS_TIME",
    )


@dataclass(frozen=True, slots=True)
class HeadingSlidingGains(SlidingGains):
    """Heading by rudders; x = (v, r, psi), sigma in rad."""

    poles: tuple[float, float] = param(
        (-0.45, -0.5),
        unit="1/s",
        low=-5.0,
        high=-0.01,
        doc="Poles of the motion on the sliding surface. Further from 0: faster, with larger fin angles.",
        mav="POLE",
    )
    delta_sw: float = param(
        0.4,
        unit="rad",
        low=0.01,
        high=5.0,
        doc="Greatest rudder angle of the switching term. Larger: rejects larger disturbances.",
        mav="DELTA_SW",
    )
    bandwidth: float = param(
        1.0,
        unit="1/s",
        low=0.01,
        high=20.0,
        doc="Rate at which sigma decays inside the boundary layer. Larger: stiffer, with more fin activity.",
        mav="BANDW",
    )
    integral_time: float = param(
        15.0,
        unit="s",
        low=0.0,
        high=1000.0,
        doc="Time constant of the integral that balances a steady yaw moment. Shorter: faster, less damped. 0: off.",
        mav="INT_TIME",
    )


# From the paper: the poles, phi_b, and the factors 2.3 and 1.5 of the tanh terms, eta / |s'b| (Eq. 28, 29, 32, 33).
PAPER_DEPTH_GAINS = DepthSlidingGains(
    poles=(-0.25, -0.26), delta_sw=2.3, phi_b=4.0, scaled=False, integral_time=0.0, climb_bias_time=0.0
)
PAPER_HEADING_GAINS = HeadingSlidingGains(
    poles=(-0.41, -0.42), delta_sw=1.5, phi_b=0.05, scaled=False, integral_time=0.0
)
