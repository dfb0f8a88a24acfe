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

    manual_time: float = param(
        20.0,
        unit="s",
        low=1.0,
        high=36000.0,
        doc="In MANUAL the station is lost after so long without it.",
        mav="MAN_T",
    )
    manual_action: Action = param(Action.HOLD, doc="Action when the station is lost in MANUAL.", mav="MAN_ACT")
    hold_time: float = param(
        60.0, unit="s", low=1.0, high=36000.0, doc="In HOLD the station is lost after so long without it.", mav="HOLD_T"
    )
    hold_action: Action = param(
        Action.SURFACE,
        doc="Action when the station is lost in HOLD.",
        mav="HOLD_ACT",
        refused=(Action.HOLD,),
        why="it holds already, and would never come up",
    )
    loiter_time: float = param(
        20.0,
        unit="s",
        low=1.0,
        high=36000.0,
        doc="In LOITER the station is lost after so long without it.",
        mav="LOIT_T",
    )
    loiter_action: Action = param(Action.HOLD, doc="Action when the station is lost in LOITER.", mav="LOIT_ACT")
    guided_time: float = param(
        20.0,
        unit="s",
        low=1.0,
        high=36000.0,
        doc="In GUIDED the station is lost after so long without it.",
        mav="GUID_T",
    )
    guided_action: Action = param(Action.HOLD, doc="Action when the station is lost in GUIDED.", mav="GUID_ACT")
    mission_time: float = param(
        60.0,
        unit="s",
        low=1.0,
        high=36000.0,
        doc="In MISSION the station is lost after so long without it.",
        mav="MISS_T",
    )
    mission_action: Action = param(Action.NONE, doc="Action when the station is lost in MISSION.", mav="MISS_ACT")
    sticks_time: float = param(
        10.0,
        unit="s",
        low=1.0,
        high=3600.0,
        doc="Under water the sticks are lost after so long without them.",
        mav="JS_T",
    )
    sticks_action: Action = param(Action.SURFACE, doc="Action when the sticks are lost under water.", mav="JS_ACT")
