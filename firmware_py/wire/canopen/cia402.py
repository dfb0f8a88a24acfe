"""The drive profile: states of a drive, the words that change and tell them, modes, process data of a position drive.

Statusword (object 0x6041) -> state; state and what is wanted -> controlword (0x6040). All of it is pure: the caller
sends a controlword each cycle, and the drive goes one transition at a time. Positions are in the drive's own counts.
Source: CiA 402-2 (IEC 61800-7-201), "Generic interface and use of profiles for power drive systems": state machine,
bits of both words, modes "profile position" and "cyclic synchronous position".
"""

from __future__ import annotations

import enum
import struct
from typing import NamedTuple

from firmware_py.wire.canopen.frames import FrameError, Rpdo, Tpdo

CONTROLWORD, STATUSWORD = 0x6040, 0x6041
MODE, MODE_DISPLAY = 0x6060, 0x6061
POSITION, TARGET = 0x6064, 0x607A


class State(enum.Enum):
    """States of a drive. Only in `ENABLED` it follows targets; in `QUICK_STOP` it brakes or holds."""

    NOT_READY = "not ready to switch on"
    DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    FAULT_REACTION = "fault reaction active"
    FAULT = "fault"


class Wanted(enum.Enum):
    """What a drive shall come to."""

    OFF = "no power at the motor"
    STANDBY = "power, no motion"
    ENABLED = "follow the target"
    QUICK_STOP = "stop now"


class Mode(enum.IntEnum):
    """Modes of operation that take a target position."""

    PROFILE_POSITION = 1
    CYCLIC_SYNCHRONOUS_POSITION = 8


DISABLE_VOLTAGE, QUICK_STOP, SHUTDOWN, SWITCH_ON, ENABLE, FAULT_RESET = 0x00, 0x02, 0x06, 0x07, 0x0F, 0x80
"""The commands of a controlword."""
NEW_SET_POINT, AT_ONCE = 0x10, 0x20
"""Bits of a controlword in profile position mode: take the target (when it rises); without finishing the last one."""
WARNING, TARGET_REACHED, INTERNAL_LIMIT, ACKNOWLEDGE, FOLLOWING_ERROR = 0x0080, 0x0400, 0x0800, 0x1000, 0x2000
"""Bits of a statusword. `ACKNOWLEDGE`: the target was taken, in profile position mode; obeyed, in the cyclic mode."""

_PATTERNS = (
    (0x4F, 0x00, State.NOT_READY),
    (0x4F, 0x40, State.DISABLED),
    (0x6F, 0x21, State.READY),
    (0x6F, 0x23, State.SWITCHED_ON),
    (0x6F, 0x27, State.ENABLED),
    (0x6F, 0x07, State.QUICK_STOP),
    (0x4F, 0x0F, State.FAULT_REACTION),
    (0x4F, 0x08, State.FAULT),
)
_STATES = tuple([next((state for mask, bits, state in _PATTERNS if word & mask == bits), None) for word in range(128)])
_STATUSWORDS = {state: bits for _, bits, state in _PATTERNS}
_UPWARDS = {State.DISABLED: SHUTDOWN, State.READY: SWITCH_ON}
"""Commands on the way from rest to power."""

_COMMAND = struct.Struct("<Hi")


class Feedback(NamedTuple):
    """What a drive sends: statusword, and actual position in counts."""

    node: int
    statusword: int
    position: int

    @property
    def state(self) -> State | None:
        """Return the state of the drive; None if the statusword belongs to none."""
        return state(self.statusword)

    @property
    def usable(self) -> bool:
        """Return True if the drive is in a state, and not in one of fault."""
        return self.state not in (None, State.FAULT, State.FAULT_REACTION)


class Command(NamedTuple):
    """What a drive is sent: controlword, and target position in counts."""

    node: int
    controlword: int
    target: int


def state(statusword: int) -> State | None:
    """Return the state that a statusword tells; None if it belongs to none."""
    return _STATES[statusword & 0x7F]


def statusword(state: State, flags: int = 0) -> int:
    """Return the statusword of a state (with voltage, remotely controlled) and more flags; for simulated drives."""
    return _STATUSWORDS[state] | 0x0210 | flags


def controlword(now: State | None, wanted: Wanted, last: int = 0, reset: bool = False) -> int:
    """Return the next controlword on the way to what is wanted.

    A fault is left only if `reset` is set: by a rising edge of the fault reset bit, which is why the last controlword
    is asked for; the cause must have gone. From `QUICK_STOP` the way up leads through `DISABLED`.

    Args:
        now: state of the drive; None if it is unknown: then the motor gets no power.
        wanted: where to.
        last: the controlword that was sent before.
        reset: leave a fault.
    """
    if now is State.FAULT:
        return FAULT_RESET if reset and not last & FAULT_RESET else DISABLE_VOLTAGE
    if now in (None, State.NOT_READY, State.FAULT_REACTION) or wanted is Wanted.OFF:
        return DISABLE_VOLTAGE
    if wanted is Wanted.QUICK_STOP:
        return QUICK_STOP if now in (State.ENABLED, State.QUICK_STOP) else DISABLE_VOLTAGE
    if now is State.QUICK_STOP:
        return DISABLE_VOLTAGE
    if now in (State.SWITCHED_ON, State.ENABLED):
        return ENABLE if wanted is Wanted.ENABLED else SWITCH_ON
    return _UPWARDS[now]


def with_set_point(controlword: int, statusword: int) -> int:
    """Return a controlword with which a drive in profile position mode takes the target that comes with it.

    The drive takes a target at a rising edge, and acknowledges it; the bit falls until the acknowledgement has fallen.
    So a new target goes in every other answer of the drive.
    """
    if controlword != ENABLE or state(statusword) is not State.ENABLED:
        return controlword
    return controlword | AT_ONCE | (0 if statusword & ACKNOWLEDGE else NEW_SET_POINT)


def command(content: Command, number: int = 1) -> Rpdo:
    """Return the process data of controlword and target.

    Raises:
        ValueError: if a number does not fit.
    """
    return Rpdo(content.node, number, _packed(content.controlword, content.target))


def decode_command(message: Rpdo) -> Command:
    """Return controlword and target; simulated drives read these.

    Raises:
        FrameError: if they are not 6 bytes.
    """
    return Command(message.node, *_unpacked(message))


def feedback(content: Feedback, number: int = 1) -> Tpdo:
    """Return the process data of statusword and position; simulated drives send these.

    Raises:
        ValueError: if a number does not fit.
    """
    return Tpdo(content.node, number, _packed(content.statusword, content.position))


def decode_feedback(message: Tpdo) -> Feedback:
    """Return statusword and position.

    Raises:
        FrameError: if they are not 6 bytes: the node is mapped otherwise.
    """
    return Feedback(message.node, *_unpacked(message))


def _packed(word: int, position: int) -> bytes:
    try:
        return _COMMAND.pack(word, position)
    except struct.error as error:
        raise ValueError(f"{word}, {position}: {error}") from None


def _unpacked(message: Rpdo | Tpdo) -> tuple[int, int]:
    if len(message.data) != _COMMAND.size:
        raise FrameError(f"PDO of node {message.node} with {len(message.data)} bytes: must be {_COMMAND.size}")
    word, position = _COMMAND.unpack(message.data)
    return word, position
