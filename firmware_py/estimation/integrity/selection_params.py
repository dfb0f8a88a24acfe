"""When another of several devices of a role is believed: `[estimation.selection]`."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.params import param


@dataclass(frozen=True)
class SelectionParams:
    """How long, and how clearly, one device has to be better than another of its role."""

    suspect_time: float = param(
        0.5,
        unit="s",
        low=0.0,
        high=60.0,
        doc="A suspect device is left when another one has been good for so long meanwhile; a lost one at once.",
        mav="SUSPECT",
    )
    other_time: float = param(
        2.0,
        unit="s",
        low=0.0,
        high=60.0,
        doc="A device is left when for so long fewer sensors contradict each other with another of its role.",
        mav="OTHER",
    )
    return_time: float = param(
        10.0,
        unit="s",
        low=0.5,
        high=3600.0,
        doc="A device of higher priority is believed again when it has been good for so long.",
        mav="RETURN",
    )
    attitude_differs: float = param(
        5.0,
        unit="deg",
        low=0.5,
        high=180.0,
        doc="An AHRS whose angles differ by more from the one that is believed is not believed again.",
        mav="ANGLE",
    )
    velocity_differs: float = param(
        0.25,
        unit="m/s",
        low=0.05,
        high=10.0,
        doc="A DVL whose velocities differ by more from the one that is believed is not believed again.",
        mav="SPEED",
    )
    depth_differs: float = param(
        0.5,
        unit="m",
        low=0.05,
        high=100.0,
        doc="Of two pressures that differ by more, and nothing tells which is wrong, the deeper one is believed.",
        mav="DEPTH",
    )
    altitude_differs: float = param(
        1.5,
        unit="m",
        low=0.1,
        high=100.0,
        doc="Of two altimeters that differ by more, and nothing tells which is wrong, the nearer bottom is believed.",
        mav="ALT",
    )
