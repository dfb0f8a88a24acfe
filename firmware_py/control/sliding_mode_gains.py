"""The gains of the sliding-mode laws: ours, and those of the paper."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from firmware_py.params import param


class Preset(enum.Enum):
    """Whose gains the sliding-mode laws take: those of the configuration, or the paper's."""

    OWN = enum.auto()
    PAPER = enum.auto()


@dataclass(frozen=True, slots=True)
class SlidingGains:
    """What the design is asked for. Inside the boundary layer the closed loop has the poles -bandwidth and `poles`.

    With `scaled` these are the poles at the trim speed, and go with u: the loop then answers over the same way at any
    speed, as the hull's own poles do, and asks no more of the fins when they have less to give.
    """

    poles: tuple[float, float] = param(
        unit="1/s",
        low=-5.0,
        high=-0.01,
        doc="Poles of the motion on the sliding surface; the third is at 0 (Eq. 24).",
        mav="POLE",
    )
    delta_sw: float = param(
        unit="rad",
        low=0.01,
        high=5.0,
        doc="Fin angle the switching term may take: eta = |s'b| delta_sw.",
        mav="DELTA_SW",
    )
    bandwidth: float = param(
        1.0, unit="1/s", low=0.01, high=20.0, doc="How fast sigma decays in the boundary layer.", mav="BANDW"
    )
    phi_b: float = param(
        0.0,
        low=0.0,
        high=100.0,
        doc="Boundary layer in units of sigma; 0: eta / bandwidth, so that poles stay put.",
        mav="PHI_B",
    )
    scaled: bool = param(True, doc="Whether poles and bandwidth go with the speed; the paper's do not.", mav="SCALED")
    integral_time: float = param(
        0.0,
        unit="s",
        low=0.0,
        high=1000.0,
        doc="Time to learn a steady disturbance, s'delta_f of Eq. 25; 0: never.",
        mav="INT_TIME",
    )
    trim_max: float = param(
        5.0,
        unit="deg",
        low=0.0,
        high=20.0,
        doc="Fin angle that may be spent on the steady disturbance.",
        mav="TRIM_MAX",
    )


@dataclass(frozen=True, slots=True)
class DepthGains(SlidingGains):
    """Depth by stern planes; sigma in m."""

    poles: tuple[float, float] = param(
        (-0.4, -0.45), unit="1/s", low=-5.0, high=-0.01, doc="Poles of the motion on the sliding surface.", mav="POLE"
    )
    delta_sw: float = param(
        0.4, unit="rad", low=0.01, high=5.0, doc="Stern plane the switching term may take.", mav="DELTA_SW"
    )
    bandwidth: float = param(
        0.9, unit="1/s", low=0.01, high=20.0, doc="How fast sigma decays in the boundary layer.", mav="BANDW"
    )
    integral_time: float = param(
        8.0, unit="s", low=0.0, high=1000.0, doc="Time to learn a steady moment; 0: never.", mav="INT_TIME"
    )
    drift_time: float = param(
        8.0,
        unit="s",
        low=0.0,
        high=100.0,
        doc="Time to learn the climb that z_dot = -u theta leaves out; 0: never.",
        mav="DRIFT_T",
    )


@dataclass(frozen=True, slots=True)
class HeadingGains(SlidingGains):
    """Heading by rudders; sigma in rad."""

    poles: tuple[float, float] = param(
        (-0.45, -0.5), unit="1/s", low=-5.0, high=-0.01, doc="Poles of the motion on the sliding surface.", mav="POLE"
    )
    delta_sw: float = param(
        0.4, unit="rad", low=0.01, high=5.0, doc="Rudder the switching term may take.", mav="DELTA_SW"
    )
    bandwidth: float = param(
        1.0, unit="1/s", low=0.01, high=20.0, doc="How fast sigma decays in the boundary layer.", mav="BANDW"
    )
    integral_time: float = param(
        15.0, unit="s", low=0.0, high=1000.0, doc="Time to learn a steady moment; 0: never.", mav="INT_TIME"
    )


# In the paper: the poles, phi_b, and the factors 2.3 and 1.5 of the tanh, which are eta / |s'b| (Eq. 28, 29, 32, 33).
PAPER_DEPTH = DepthGains(poles=(-0.25, -0.26), delta_sw=2.3, phi_b=4.0, scaled=False, integral_time=0.0, drift_time=0.0)
PAPER_HEADING = HeadingGains(poles=(-0.41, -0.42), delta_sw=1.5, phi_b=0.05, scaled=False, integral_time=0.0)
