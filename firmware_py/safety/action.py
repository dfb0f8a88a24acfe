"""What a rule does, and which modes are safer than others."""

from __future__ import annotations

import enum
from collections.abc import Mapping

from firmware_py.records.order import Mode


class Action(enum.IntEnum):
    """What a rule does while its condition holds; each is safer than those before it."""

    NONE = 0
    WARN = 1
    """Say so, once."""
    HOLD = 2
    """Mode HOLD: depth and heading as they are, slowly."""
    RETURN = 3
    """Mode RETURN: to the nearest rally point, home without one, then up."""
    SURFACE = 4
    SURFACE_AND_DROP = 5
    """Mode SURFACE, and release the drop weight."""


MODE_OF: Mapping[Action, Mode] = {
    Action.HOLD: Mode.HOLD,
    Action.RETURN: Mode.RETURN,
    Action.SURFACE: Mode.SURFACE,
    Action.SURFACE_AND_DROP: Mode.SURFACE,
}
"""The mode that an action leads to; NONE and WARN leave the mode as it is."""

_ASKS = {Mode.DISARMED: 0, Mode.SURFACE: 1, Mode.RETURN: 2, Mode.HOLD: 3}
"""How much a mode asks of the vehicle; all other modes ask for more, and each as much as the others."""


def safer(a: Mode, b: Mode) -> bool:
    """Return whether mode a asks strictly less of the vehicle than mode b."""
    return _ASKS.get(a, 4) < _ASKS.get(b, 4)
