"""MANUAL_CONTROL: a joystick's axes as stern plane, rudder and propeller."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.mavlink.base.codec import Message
from firmware_py.params import param
from firmware_py.records.order import Sticks

_FULL = 1000.0
_NO_AXIS = 32767


@dataclass(frozen=True, slots=True)
class ManualControlParams:
    """The demand of a fully deflected stick."""

    delta_s_full: float = param(15.0, unit="deg", low=0.0, high=45.0, doc="Stern planes.", mav="JS_DELTA_S")
    delta_r_full: float = param(20.0, unit="deg", low=0.0, high=45.0, doc="Rudder.", mav="JS_DELTA_R")
    n_full: float = param(500.0, unit="rpm", low=0.0, high=1e4, doc="Propeller.", mav="JS_RPM")
    z_centre: float = param(
        500.0,
        low=0.0,
        high=500.0,
        doc="Axis z at rest: 500 as for ArduSub (0 to 1000), 0 if it goes from -1000.",
        mav="JS_Z_CENTRE",
    )


def sticks(params: ManualControlParams, message: Message) -> Sticks:
    """Return the demand of the axes; values are clipped to their range, and a missing axis counts as centred.

    The axes are ArduSub's: x forward turns the propeller ahead; r to the right, or y if there is no r, gives starboard
    rudder; z up (the throttle) climbs. A positive fin angle dives or turns to port, so both angles have the opposite
    sign. (The message's definition has r positive to the left; ground stations send it positive to the right.)
    """
    r = message.r if message.r != _NO_AXIS else message.y
    z = 0.0 if message.z == _NO_AXIS else (message.z - params.z_centre) / (_FULL - params.z_centre)
    return Sticks(
        delta_s=-clip(z, -1.0, 1.0) * params.delta_s_full,
        delta_r=-_fraction(r) * params.delta_r_full,
        n=_fraction(message.x) * params.n_full,
    )


def _fraction(axis: int) -> float:
    return 0.0 if axis == _NO_AXIS else clip(axis / _FULL, -1.0, 1.0)
