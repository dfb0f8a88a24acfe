"""The modes as stations know them: by number, by name, by the standard's names.

Custom modes have ArduSub's numbers on a link that takes the vehicle for ArduSub. On a generic one they have PX4's,
which MAVSDK reads and writes wherever it does not see ArduPilot; both codings are understood on every link.
"""

from __future__ import annotations

import enum
import math
import re
from typing import NamedTuple

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.records.order import Mode

_NON_STANDARD: int = dialect.MAV_STANDARD_MODE_NON_STANDARD
_ADVANCED = dialect.MAV_MODE_PROPERTY_ADVANCED
_AUTOMATIC = 4
"""MAV_MODE_PROPERTY_AUTO_MODE, which the dialect does not name."""


class Identity(enum.Enum):
    """What a link takes the vehicle for."""

    ARDUSUB = enum.auto()
    GENERIC = enum.auto()


class Name(NamedTuple):
    """A mode that may be ordered: ArduSub's number, PX4's main and sub mode, its name, the standard mode that it is.

    `shown` is what ArduSub's stations call it, and `name` what AVAILABLE_MODES does.
    """

    mode: Mode
    ardusub: int
    px4: tuple[int, int]
    name: str
    shown: str
    standard: int = _NON_STANDARD
    properties: int = 0

    def custom(self, identity: Identity) -> int:
        """The custom mode on a link."""
        main, sub = self.px4
        return self.ardusub if identity is Identity.ARDUSUB else sub << 24 | main << 16


NAMES = (
    Name(Mode.MANUAL, 19, (1, 0), "Manual", "MANUAL", properties=_ADVANCED),
    Name(Mode.HOLD, 2, (2, 0), "Depth hold", "ALT_HOLD"),
    Name(Mode.LOITER, 16, (4, 3), "Position hold", "POSHOLD", properties=_AUTOMATIC),
    Name(Mode.GUIDED, 4, (6, 0), "Guided", "GUIDED", properties=_AUTOMATIC),
    Name(Mode.MISSION, 3, (4, 4), "Auto", "AUTO", dialect.MAV_STANDARD_MODE_MISSION, _AUTOMATIC),
    Name(Mode.SURFACE, 9, (4, 6), "Surface", "SURFACE", dialect.MAV_STANDARD_MODE_LAND, _AUTOMATIC),
)
_RETURN = Name(Mode.RETURN, 4, (4, 5), "Return", "RETURN", dialect.MAV_STANDARD_MODE_SAFE_RECOVERY, _AUTOMATIC)
"""ArduSub has no such mode: its stations order it by command, and see Guided."""
_AVAILABLE = {Identity.ARDUSUB: NAMES, Identity.GENERIC: (*NAMES, _RETURN)}
MODE_LIST = ", ".join(f"{name.mode.name} {name.ardusub}" for name in NAMES)
"""The modes that may be ordered, for people, once they are `worded`."""
_SHOWN = {
    Identity.ARDUSUB: {name.mode.name: name.shown for name in (*NAMES, _RETURN)},
    Identity.GENERIC: {name.mode.name: name.name for name in (*NAMES, _RETURN)} | {Mode.DISARMED.name: "Disarmed"},
}
_MODE = re.compile(rf"\b({'|'.join(mode.name for mode in Mode)})\b")
_BY_MODE = {name.mode: name for name in (*NAMES, _RETURN)}
_BY_MODE[Mode.DISARMED] = _BY_MODE[Mode.MANUAL]
_BY_CUSTOM: dict[float, Mode] = {
    6: Mode.GUIDED,  # PX4's main mode alone; the others mean something else, or the same, as ArduSub's numbers
    **{name.custom(identity): name.mode for identity in Identity for name in NAMES},
    _RETURN.custom(Identity.GENERIC): Mode.RETURN,
}
_PX4: dict[tuple[float, float], Mode] = {name.px4: name.mode for name in (*NAMES, _RETURN)}
"""PX4's pairs, as MAVSDK sends them."""
_BY_STANDARD: dict[float, Mode] = {
    dialect.MAV_STANDARD_MODE_MISSION: Mode.MISSION,
    dialect.MAV_STANDARD_MODE_LAND: Mode.SURFACE,
    dialect.MAV_STANDARD_MODE_SAFE_RECOVERY: Mode.RETURN,
}


def custom_mode(identity: Identity, mode: Mode) -> int:
    """The custom mode of each mode; disarmed it is manual, for the sticks would be heard next."""
    return _BY_MODE[mode].custom(identity)


def mode_name(identity: Identity, mode: Mode) -> str:
    """Return what a link's stations call a mode."""
    return _SHOWN[identity].get(mode.name, mode.name)


def with_mode_names(identity: Identity, sentence: str) -> str:
    """A sentence that names modes as `Mode` does, with the names that a link's stations show."""
    shown = _SHOWN[identity]
    return _MODE.sub(lambda found: shown.get(found[0], found[0]), sentence)


def mode_of(custom: float, sub: float = 0.0) -> Mode | None:
    """The mode that DO_SET_MODE's param2 and param3 ask for, None if there is none.

    With `sub` it is PX4's main and sub mode, without it is a custom mode of ours; NaN is 0.
    """
    custom, sub = (0.0 if math.isnan(value) else value for value in (custom, sub))
    return _PX4.get((custom, sub)) if sub else _BY_CUSTOM.get(custom)


def standard_mode(number: float) -> Mode | None:
    """The mode that DO_SET_STANDARD_MODE's param1 asks for, None if there is none."""
    return _BY_STANDARD.get(number)


def available_modes(identity: Identity, index: int) -> list[Message]:
    """AVAILABLE_MODES of one mode, counted from 1, or with 0 of all; empty if there is no such mode."""
    return [
        dialect.MAVLink_available_modes_message(
            len(_AVAILABLE[identity]), i, name.standard, name.custom(identity), name.properties, name.name.encode()
        )
        for i, name in enumerate(_AVAILABLE[identity], 1)
        if index in (0, i)
    ]


def current_mode(identity: Identity, mode: Mode, intended: Mode) -> Message:
    """CURRENT_MODE; `intended` is what was ordered before a failsafe changed it."""
    return dialect.MAVLink_current_mode_message(
        _BY_MODE[mode].standard, custom_mode(identity, mode), custom_mode(identity, intended)
    )


def modes_monitor() -> Message:
    """AVAILABLE_MODES_MONITOR: the modes never change."""
    return dialect.MAVLink_available_modes_monitor_message(0)
