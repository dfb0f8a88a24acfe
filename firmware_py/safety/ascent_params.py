"""[safety.ascent]: how the vehicle comes up, and what tells of the surface."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.params import param


@dataclass(frozen=True)
class AscentParams:
    """Limits and times of the stages of SURFACE."""

    pitch: float = param(12.0, unit="deg", low=2.0, high=30.0, doc="Pitch on the way up.", mav="PITCH")
    level_pitch: float = param(
        3.0, unit="deg", low=0.5, high=12.0, doc="Pitch near the surface: steeper, the bow hangs out.", mav="LVL_PIT"
    )
    level_depth: float = param(
        1.5, unit="m", low=0.2, high=3.0, doc="Above this depth the surface is near: level_pitch.", mav="LVL_DEP"
    )
    pitch_rate: float = param(
        4.0, unit="deg/s", low=0.2, high=30.0, doc="Change of the desired pitch; as fast as the fins can.", mav="RATE"
    )
    deeper: float = param(
        2.0, unit="m", low=0.2, high=50.0, doc="If it gets deeper by so much, the propeller goes astern.", mav="DEEPER"
    )
    pitch_error: float = param(
        15.0,
        unit="deg",
        low=3.0,
        high=60.0,
        doc="If its pitch is off by so much, the propeller goes astern.",
        mav="OFF",
    )
    pitch_error_time: float = param(
        1.0, unit="s", low=0.1, high=10.0, doc="Time for which the pitch must be off by pitch_error.", mav="OFF_T"
    )
    roll: float = param(
        60.0, unit="deg", low=20.0, high=90.0, doc="Beyond this roll it stops and releases the weight.", mav="ROLL"
    )
    roll_time: float = param(
        10.0,
        unit="s",
        low=0.5,
        high=60.0,
        doc="Roll beyond the limit counts after so long; upside down at once.",
        mav="ROLL_T",
    )
    limit_margin: float = param(
        1.0, unit="m", low=0.0, high=50.0, doc="Below depth_max by so much it releases the weight.", mav="MARGIN"
    )
    progress: float = param(1.0, unit="m", low=0.1, high=10.0, doc="Rising by so much is progress.", mav="PROGRESS")
    climb_time: float = param(
        45.0, unit="s", low=5.0, high=300.0, doc="After so long without progress it releases the weight.", mav="CLIMB_T"
    )
    drop_time: float = param(
        10.0,
        unit="s",
        low=1.0,
        high=600.0,
        doc="Without propeller it releases the weight after so long without progress.",
        mav="DROP_T",
    )
    drop_margin: float = param(
        3.0,
        unit="m",
        low=0.0,
        high=50.0,
        doc="A vehicle that sinks so near to a limit releases the weight at once.",
        mav="DROP_M",
    )
    rest_speed: float = param(
        0.1, unit="m/s", low=0.02, high=1.0, doc="Slower than this the way is off.", mav="REST_SPD"
    )
    reverse_time: float = param(30.0, unit="s", low=1.0, high=120.0, doc="Propeller astern for no longer.", mav="REV_T")
    turn_time: float = param(
        20.0,
        unit="s",
        low=5.0,
        high=120.0,
        doc="Without depth it climbs for so long, then goes level for so long, in turns.",
        mav="TURN",
    )
    wait_time: float = param(
        60.0,
        unit="s",
        low=5.0,
        high=300.0,
        doc="After so long near the surface it goes on slowly, and says so.",
        mav="WAIT_T",
    )
    tell_period: float = param(
        30.0, unit="s", low=5.0, high=300.0, doc="How often it says that nothing tells of the surface.", mav="TELL"
    )
    up_time: float = param(
        120.0,
        unit="s",
        low=30.0,
        high=600.0,
        doc="So long after a good climb would have ended it releases the weight, if nothing tells that it is up.",
        mav="UP_T",
    )
    fix_time: float = param(
        30.0,
        unit="s",
        low=10.0,
        high=300.0,
        doc="A fix held for so long tells of the surface where the pressure says no more than submerged_depth.",
        mav="FIX_T",
    )
    fix_needed: bool = param(
        True, doc="False without a receiver: depth and a second witness tell of the surface.", mav="FIX_NEED"
    )
