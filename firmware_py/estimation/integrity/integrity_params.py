"""Thresholds of sensor integrity: `[estimation.integrity]`."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.params import param


@dataclass(frozen=True)
class IntegrityParams:
    """What two witnesses may differ by before one of them is accused."""

    enabled: bool = param(True, doc="False: every sensor is believed, whatever it says.", mav="ENABLED")
    recovery: float = param(
        5.0,
        unit="s",
        low=0.5,
        high=600.0,
        doc="A suspect sensor is good again when nothing spoke against it for so long.",
        mav="RECOVER",
    )
    steady: float = param(
        5.0,
        unit="s",
        low=0.0,
        high=600.0,
        doc="A lost sensor is good again when heard for so long, without a gap of half its time-out.",
        mav="STEADY",
    )
    frozen: float = param(
        0.4,
        unit="s",
        low=0.1,
        high=60.0,
        doc="Exact repeats for so long are a frozen sensor, if it had noise before.",
        mav="FROZEN",
    )
    altimeter_frozen: float = param(
        2.5,
        unit="s",
        low=0.1,
        high=60.0,
        doc="The same for the altimeter, whose wire has steps as wide as its noise.",
        mav="FROZ_ALT",
    )
    slow_timeout: float = param(
        3.0,
        unit="s",
        low=0.5,
        high=600.0,
        doc="Fix, battery and leak sensor are lost when not heard for so long.",
        mav="SLOW_T",
    )
    start_time: float = param(
        5.0,
        unit="s",
        low=1.0,
        high=600.0,
        doc="A sensor that was never heard is lost so long after the start.",
        mav="START_T",
    )
    depth_step: float = param(
        0.3,
        unit="m",
        low=0.05,
        high=100.0,
        doc="A pressure reading farther from the depth carried on is not used.",
        mav="Z_STEP",
    )
    depth_5s: float = param(
        0.25,
        unit="m",
        low=0.05,
        high=100.0,
        doc="Pressure against DVL: most that they may differ by over 5 s.",
        mav="Z_5S",
    )
    depth_10s: float = param(0.38, unit="m", low=0.05, high=100.0, doc="The same over 10 s.", mav="Z_10S")
    depth_40s: float = param(0.9, unit="m", low=0.05, high=100.0, doc="The same over 40 s.", mav="Z_40S")
    depth_blind: float = param(
        1.9,
        unit="m",
        low=0.1,
        high=100.0,
        doc="Pressure against pitch times speed, without DVL, over 5 s.",
        mav="Z_BLIND",
    )
    depth_blind_20s: float = param(
        2.0,
        unit="m",
        low=0.1,
        high=100.0,
        doc="The same over 20 s in still water, with 3 deg of pitch bias, or a speed 15 % off in a dive of 20 deg.",
        mav="Z_BLD_20",
    )
    depth_blind_60s: float = param(
        4.0,
        unit="m",
        low=0.1,
        high=100.0,
        doc="The same over 60 s, with 2 deg of pitch bias; in eddies more, by how unsteady it is.",
        mav="Z_BLD_60",
    )
    surface: float = param(
        1.0,
        unit="m",
        low=0.1,
        high=10.0,
        doc="Above this depth, depth is not checked: the hull leaves the water.",
        mav="SURFACE",
    )
    tilt: float = param(2.5, unit="deg", low=0.5, high=90.0, doc="Roll and pitch against the gyros.", mav="TILT")
    heading: float = param(3.5, unit="deg", low=0.5, high=180.0, doc="Heading against the gyros.", mav="HEADING")
    gyro_time: float = param(
        30.0,
        unit="s",
        low=2.0,
        high=300.0,
        doc="Over so long gyros are compared with angles: longer sees slower drift, and more of the gyros' bias.",
        mav="GYRO_T",
    )
    gyro_drift: float = param(
        0.01, unit="deg/s", low=0.0, high=1.0, doc="How fast angles that gyros carry become wrong.", mav="GYRO_DRF"
    )
    angle_spike: float = param(
        6.0, unit="deg", low=1.0, high=180.0, doc="One AHRS report farther off than this is not used.", mav="A_SPIKE"
    )
    rate_spike: float = param(
        5.0,
        unit="deg/s",
        low=0.5,
        high=360.0,
        doc="The same of a body rate, from one report to the next.",
        mav="R_SPIKE",
    )
    speed_max: float = param(
        6.0,
        unit="m/s",
        low=0.5,
        high=50.0,
        doc="Greatest believable velocity along each axis, current included.",
        mav="V_MAX",
    )
    speed_step: float = param(
        0.35,
        unit="m/s",
        low=0.05,
        high=10.0,
        doc="Most that velocity changes from one DVL ping to the next.",
        mav="V_STEP",
    )
    speed: float = param(0.6, unit="m/s", low=0.1, high=10.0, doc="DVL against thrust and drag.", mav="V_MODEL")
    current_change: float = param(
        1.2,
        unit="m/s",
        low=0.1,
        high=10.0,
        doc="Most that the current along the hull changes by in ten minutes: a DVL that creeps farther is wrong.",
        mav="CURRENT",
    )
    turn_drift: float = param(
        0.4,
        unit="deg/s",
        low=0.05,
        high=20.0,
        doc="Heading and gyro against the rudder's model; a rudder 1 deg off its zero looks the same.",
        mav="TURN_DRF",
    )
    delay: float = param(
        1.0, unit="s", low=0.1, high=10.0, doc="A DVL ping that is older when it arrives is late.", mav="LATE"
    )
    altitude: float = param(0.5, unit="m", low=0.05, high=100.0, doc="Altimeter against the DVL's altitude.", mav="ALT")
    altitude_step: float = param(
        1.5,
        unit="m",
        low=0.1,
        high=100.0,
        doc="Most that the altitude changes in one reading, beside the motion.",
        mav="ALT_STEP",
    )
    altitude_hold: float = param(
        60.0,
        unit="s",
        low=0.0,
        high=3600.0,
        doc="A bottom that leaps away, seen by one sensor alone, must stay there for so long.",
        mav="ALT_HOLD",
    )
    fix_sigmas: float = param(
        6.0, low=2.0, high=100.0, doc="A fix so many of its sigmas from the one before is not used.", mav="FIX_SIG"
    )
    fix_deep: float = param(3.0, unit="m", low=0.5, high=100.0, doc="A fix deeper than this cannot be.", mav="FIX_DEEP")
