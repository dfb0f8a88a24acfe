"""Table [safety.station]: what a station's silence means, mode by mode."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.params import param
from firmware_py.safety.action import Action


@dataclass(frozen=True)
class StationParams:
    """What is done when no station is heard any more, once one was; and when the sticks fall silent under water.

    A mode that ends in HOLD is then judged as HOLD: together they hold first, and surface later.
    """

    manual_time: float = param(20.0, unit="s", low=1.0, high=36000.0, doc="No station, in MANUAL.", mav="MAN_T")
    manual_action: Action = param(Action.HOLD, doc="No station for manual_time.", mav="MAN_ACT")
    hold_time: float = param(60.0, unit="s", low=1.0, high=36000.0, doc="No station, in HOLD.", mav="HOLD_T")
    hold_action: Action = param(
        Action.SURFACE,
        doc="No station for hold_time.",
        mav="HOLD_ACT",
        refused=(Action.HOLD,),
        why="it holds already, and would never come up",
    )
    loiter_time: float = param(20.0, unit="s", low=1.0, high=36000.0, doc="No station, in LOITER.", mav="LOIT_T")
    loiter_action: Action = param(Action.HOLD, doc="No station for loiter_time.", mav="LOIT_ACT")
    guided_time: float = param(20.0, unit="s", low=1.0, high=36000.0, doc="No station, in GUIDED.", mav="GUID_T")
    guided_action: Action = param(Action.HOLD, doc="No station for guided_time.", mav="GUID_ACT")
    mission_time: float = param(60.0, unit="s", low=1.0, high=36000.0, doc="No station, in MISSION.", mav="MISS_T")
    mission_action: Action = param(Action.NONE, doc="No station for mission_time.", mav="MISS_ACT")
    sticks_time: float = param(10.0, unit="s", low=1.0, high=3600.0, doc="No sticks, under water.", mav="JS_T")
    sticks_action: Action = param(Action.SURFACE, doc="No sticks for sticks_time.", mav="JS_ACT")
