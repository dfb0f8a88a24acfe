"""Why a request is refused, as a value, and the sentence of each refusal: the one place where it is made."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from firmware_py.mavlink.base.modes import Identity, known_modes, mode_name
from firmware_py.records.order import Mode


class ModeReason(enum.Enum):
    """Why the mode in force, or the mode asked for, does not allow a request."""

    UNKNOWN_MODE = enum.auto()
    """There is no such mode; numbers: custom mode and sub mode."""
    DISARMED = enum.auto()
    NO_SETPOINT = enum.auto()
    """The mode takes no setpoint at all."""
    NO_POSITION = enum.auto()
    DEPTH_AND_SPEED_ONLY = enum.auto()
    SPEED_ONLY = enum.auto()
    OTHER_ORDER = enum.auto()
    """The order of another station was obeyed."""


class ModeRefusal(NamedTuple):
    """A refusal that depends on the mode.

    Attributes:
        reason: what does not fit.
        mode: the mode in force, where the reason is about it.
        instead: the modes that allow the request.
        numbers: as `ModeReason` says.
    """

    reason: ModeReason
    mode: Mode | None = None
    instead: tuple[Mode, ...] = ()
    numbers: tuple[float, ...] = ()


Refusal = str | ModeRefusal
"""Why a request is refused: a sentence where no mode is named; "" if it is not refused."""

_TEXTS: Mapping[ModeReason, str] = {
    ModeReason.UNKNOWN_MODE: "mode {0:g}/{1:g} is unknown; {known}",
    ModeReason.DISARMED: "disarmed; arm first, then set {instead}",
    ModeReason.NO_SETPOINT: "{mode} takes no setpoint; set {instead}",
    ModeReason.NO_POSITION: "{mode} takes no position; set {instead}",
    ModeReason.DEPTH_AND_SPEED_ONLY: "{mode} takes depth and speed only; set {instead}",
    ModeReason.SPEED_ONLY: "{mode} takes a speed only; set {instead}",
    ModeReason.OTHER_ORDER: "another order was obeyed, and the mode is {mode}",
}


def refusal_text(refusal: Refusal, identity: Identity) -> str:
    """Return the sentence of a refusal, with the mode names that stations show on a link of that identity."""
    if isinstance(refusal, str):
        return refusal
    return _TEXTS[refusal.reason].format(
        *refusal.numbers,
        mode="" if refusal.mode is None else mode_name(identity, refusal.mode),
        instead=_alternatives([mode_name(identity, mode) for mode in refusal.instead]),
        known=known_modes(identity),
    )


def _alternatives(names: Sequence[str]) -> str:
    """Return the names with commas, and "or" before the last."""
    return " or ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
