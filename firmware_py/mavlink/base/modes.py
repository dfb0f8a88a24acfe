"""The modes as stations know them: custom mode numbers, names and standard modes.

On a link with ArduSub's identity, custom modes have ArduSub's numbers. On a generic link they have PX4's numbers, which
MAVSDK uses for every autopilot but ArduPilot: 2 is ALTCTL there, and 3 POSCTL, where ArduSub has ALT_HOLD and AUTO.
"""

from __future__ import annotations

import enum
import math
from typing import NamedTuple

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.records.command import ModeState
from firmware_py.records.order import Mode

_NON_STANDARD: int = dialect.MAV_STANDARD_MODE_NON_STANDARD
_ADVANCED = dialect.MAV_MODE_PROPERTY_ADVANCED
_AUTOMATIC = 4
"""MAV_MODE_PROPERTY_AUTO_MODE, which the dialect does not name."""


class Identity(enum.Enum):
    """The autopilot that the vehicle presents itself as on a link."""

    ARDUSUB = enum.auto()
    GENERIC = enum.auto()


class ModeEntry(NamedTuple):
    """A mode that may be ordered: ArduSub's number, PX4's main and sub mode, names and the standard mode.

    `shown` is the name that stations show for ArduSub, `name` the one in AVAILABLE_MODES.
    """

    mode: Mode
    ardusub: int
    px4: tuple[int, int]
    name: str
    shown: str
    standard: int = _NON_STANDARD
    properties: int = 0

    def custom(self, identity: Identity) -> int:
        """Return the custom mode number on a link of that identity."""
        main, sub = self.px4
        return self.ardusub if identity is Identity.ARDUSUB else sub << 24 | main << 16

    def number(self, identity: Identity) -> str:
        """Return what DO_SET_MODE asks for it with: ArduSub's number, or PX4's main and sub mode."""
        return str(self.ardusub) if identity is Identity.ARDUSUB else "{}/{}".format(*self.px4)


MODES = (
    ModeEntry(Mode.MANUAL, 19, (1, 0), "Manual", "MANUAL", properties=_ADVANCED),
    ModeEntry(Mode.HOLD, 2, (2, 0), "Depth hold", "ALT_HOLD"),
    ModeEntry(Mode.LOITER, 16, (4, 3), "Position hold", "POSHOLD", properties=_AUTOMATIC),
    ModeEntry(Mode.GUIDED, 4, (6, 0), "Guided", "GUIDED", properties=_AUTOMATIC),
    ModeEntry(Mode.MISSION, 3, (4, 4), "Auto", "AUTO", dialect.MAV_STANDARD_MODE_MISSION, _AUTOMATIC),
    ModeEntry(Mode.SURFACE, 9, (4, 6), "Surface", "SURFACE", dialect.MAV_STANDARD_MODE_LAND, _AUTOMATIC),
)
_RETURN = ModeEntry(Mode.RETURN, 4, (4, 5), "Return", "RETURN", dialect.MAV_STANDARD_MODE_SAFE_RECOVERY, _AUTOMATIC)
"""ArduSub has no such mode: its stations order it by command and show Guided."""
_AVAILABLE = {Identity.ARDUSUB: MODES, Identity.GENERIC: (*MODES, _RETURN)}
_SHOWN = {
    Identity.ARDUSUB: {entry.mode: entry.shown for entry in (*MODES, _RETURN)},
    Identity.GENERIC: {entry.mode: entry.name for entry in (*MODES, _RETURN)} | {Mode.DISARMED: "Disarmed"},
}
_BY_MODE = {entry.mode: entry for entry in (*MODES, _RETURN)}
_BY_MODE[Mode.DISARMED] = _BY_MODE[Mode.MANUAL]
_POSCTL = (3, 0)
"""PX4's mode in which sticks move the vehicle, and without them it holds its position: it circles, as in POSHOLD."""
_PX4: dict[tuple[float, float], Mode] = {
    **{entry.px4: entry.mode for entry in (*MODES, _RETURN)},
    _POSCTL: Mode.LOITER,
}
"""By PX4's main and sub mode, as MAVSDK sends them. AUTO alone, which PX4 takes for its mission, is not there."""
_JOINED = 1 << 16
"""The least number that has PX4's main and sub mode in one."""
_BY_CUSTOM: dict[float, Mode] = {
    6: Mode.GUIDED,  # PX4's main mode alone; the other main modes are also ArduSub numbers
    **{entry.ardusub: entry.mode for entry in MODES},
    **{int(sub) << 24 | int(main) << 16: mode for (main, sub), mode in _PX4.items()},
}
_BY_STANDARD: dict[float, Mode] = {
    dialect.MAV_STANDARD_MODE_MISSION: Mode.MISSION,
    dialect.MAV_STANDARD_MODE_LAND: Mode.SURFACE,
    dialect.MAV_STANDARD_MODE_SAFE_RECOVERY: Mode.RETURN,
}


def shown_mode(decided: ModeState) -> Mode:
    """Return the mode that stations are shown: while disarmed the one that arming leads to."""
    return decided.chosen if decided.mode is Mode.DISARMED else decided.mode


def custom_mode(identity: Identity, mode: Mode) -> int:
    """Return the custom mode of a mode; DISARMED has none and gets that of MANUAL."""
    return _BY_MODE[mode].custom(identity)


def mode_name(identity: Identity, mode: Mode) -> str:
    """Return what a link's stations call a mode."""
    return _SHOWN[identity].get(mode, mode.name)


def mode_of(identity: Identity, custom: float, sub: float) -> Mode | None:
    """Return the mode that DO_SET_MODE's param2 and param3 ask for on a link; None if there is none.

    With `sub`, and below 65536 on a generic link, they are PX4's main and sub mode; else `custom` is a custom mode,
    ArduSub's or PX4's. NaN counts as 0.
    """
    custom, sub = (0.0 if math.isnan(value) else value for value in (custom, sub))
    pair = sub or (identity is Identity.GENERIC and custom < _JOINED)
    return _PX4.get((custom, sub)) if pair else _BY_CUSTOM.get(custom)


def known_modes(identity: Identity) -> str:
    """Return the names of the modes that may be set on a link, each with its number."""
    return ", ".join(f"{mode_name(identity, entry.mode)} {entry.number(identity)}" for entry in _AVAILABLE[identity])


def standard_mode(number: float) -> Mode | None:
    """Return the mode that DO_SET_STANDARD_MODE's param1 asks for; None if there is none."""
    return _BY_STANDARD.get(number)


def available_modes(identity: Identity, index: int) -> list[Message]:
    """Return AVAILABLE_MODES of one mode, counted from 1, or of all with 0; empty if there is no such mode."""
    return [
        dialect.MAVLink_available_modes_message(
            len(_AVAILABLE[identity]), i, entry.standard, entry.custom(identity), entry.properties, entry.name.encode()
        )
        for i, entry in enumerate(_AVAILABLE[identity], 1)
        if index in (0, i)
    ]


def current_mode(identity: Identity, mode: Mode, intended: Mode) -> Message:
    """Return CURRENT_MODE; `intended` is the mode ordered before a failsafe changed it."""
    return dialect.MAVLink_current_mode_message(
        _BY_MODE[mode].standard, custom_mode(identity, mode), custom_mode(identity, intended)
    )


def modes_monitor() -> Message:
    """Return AVAILABLE_MODES_MONITOR; the modes never change."""
    return dialect.MAVLink_available_modes_monitor_message(0)
