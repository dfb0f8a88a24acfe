"""The start-up of a drive, step by step: what it is, its mode, process data, heartbeat; then it is started.

A `Configuration` never waits: the caller asks it each cycle for the frame to send, and gives it the answers of the
node. A node that boots again has forgotten everything: it needs a new one.

Objects: CiA 301 (process data 0x14xx to 0x1Axx, heartbeat 0x1016 and 0x1017, device type 0x1000, errors 0x1001) and
CiA 402 (mode 0x6060, interpolation time 0x60C2, reaction to a lost master 0x6007).
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from firmware_py.wire.canopen import cia402, sdo
from firmware_py.wire.canopen.frames import (
    RPDO,
    TPDO,
    Frame,
    FrameError,
    Nmt,
    NmtCommand,
    SdoAnswer,
    encode,
)

DEVICE_TYPE, ERROR_REGISTER, CONSUMER_HEARTBEAT, PRODUCER_HEARTBEAT = 0x1000, 0x1001, 0x1016, 0x1017
REACTION_TO_LOST_MASTER, INTERPOLATION_TIME = 0x6007, 0x60C2
PROFILE = 402
"""The lower half of a drive's device type."""
ANSWER_TIME = 0.5
"""How long a node may take to answer, s."""
TRIES = 4
"""How often a request is sent before the configuration has failed."""
BOOT_TIME = 0.05
"""Pause after the node was ordered to be pre-operational, s."""
ON_SYNC, ON_EVENT = 1, 255
"""Transmission types: with each SYNC, or as soon as there is something."""

_NOT_VALID, _NO_REMOTE_REQUEST = 1 << 31, 1 << 30
_QUICK_STOP = 3
"""Reaction to a lost master: a quick stop."""


class Check(NamedTuple):
    """A step: read an object, and fail unless the bits of the mask are those of the value."""

    object: int
    subindex: int
    mask: int
    value: int


class Wish(NamedTuple):
    """A step: write an object that not every node has; one that refuses it does without."""

    object: int
    subindex: int
    data: bytes


Step: TypeAlias = sdo.Write | Check | Wish


class Mapped(NamedTuple):
    """An object in process data."""

    object: int
    subindex: int
    bits: int


COMMAND = (Mapped(cia402.CONTROLWORD, 0, 16), Mapped(cia402.TARGET, 0, 32))
FEEDBACK = (Mapped(cia402.STATUSWORD, 0, 16), Mapped(cia402.POSITION, 0, 32))


def process_data(
    node: int, received: bool, number: int, objects: Sequence[Mapped], kind: int, period: float = 0.0
) -> list[Step]:
    """Return the steps that map objects into a PDO and switch it on.

    Args:
        node: whose.
        received: an RPDO, which the node receives, or a TPDO, which it sends.
        number: which, 1 to 4.
        objects: at most 64 bits of them, in order.
        kind: transmission type, `ON_SYNC` or `ON_EVENT`.
        period: a TPDO is sent at least so often, s, besides, and at most twice as often; 0 for not.

    Raises:
        ValueError: if there is no such PDO, or it would be too long.
    """
    if not 1 <= number <= 4 or not 0 < sum(one.bits for one in objects) <= 64:
        raise ValueError(f"PDO {number} of {len(objects)} objects: must be 1 to 4, of 1 to 64 bits")
    parameters, mapping = (0x1400, 0x1600) if received else (0x1800, 0x1A00)
    parameters, mapping = parameters + number - 1, mapping + number - 1
    identifier = (RPDO if received else TPDO)[number - 1] + node | (0 if received else _NO_REMOTE_REQUEST)
    steps: list[Step] = [
        sdo.Write(parameters, 1, sdo.unsigned(identifier | _NOT_VALID, 4)),
        sdo.Write(mapping, 0, b"\0"),
    ]
    for place, one in enumerate(objects, 1):
        steps.append(sdo.Write(mapping, place, sdo.unsigned(one.object << 16 | one.subindex << 8 | one.bits, 4)))
    steps += [
        sdo.Write(mapping, 0, sdo.unsigned(len(objects), 1)),
        sdo.Write(parameters, 2, sdo.unsigned(kind, 1)),
    ]
    if period and not received:  # without the inhibit time a drive that moves may send with each of its own cycles
        steps.append(Wish(parameters, 3, sdo.unsigned(round(0.5 * period * 1e4), 2)))  # in units of 100 us
        steps.append(sdo.Write(parameters, 5, _milliseconds(period)))
    return [*steps, sdo.Write(parameters, 1, sdo.unsigned(identifier, 4))]


def drive(
    node: int,
    mode: cia402.Mode,
    period: float,
    heartbeat: float,
    master: int = 0,
    patience: float = 0.0,
) -> list[Step]:
    """Return the steps that make a node a position drive: RPDO 1 is its command, TPDO 1 its feedback.

    In the cyclic synchronous mode both go with each SYNC, which the caller sends each period; in profile position mode
    a command counts at once, and the feedback is sent each period.

    Args:
        node: whose.
        mode: how it takes targets.
        period: of process data, s, in steps of 1 ms.
        heartbeat: period of the node's heartbeat, s.
        master: node id of the caller, whose heartbeat the drive watches; 0 for none.
        patience: so long, s, the drive waits for that heartbeat before it makes a quick stop.

    Raises:
        ValueError: if a number is out of range.
    """
    cyclic = mode is cia402.Mode.CYCLIC_SYNCHRONOUS_POSITION
    kind = ON_SYNC if cyclic else ON_EVENT
    steps: list[Step] = [Check(DEVICE_TYPE, 0, 0xFFFF, PROFILE), sdo.Write(cia402.MODE, 0, sdo.unsigned(mode, 1))]
    if cyclic:
        steps += [
            sdo.Write(INTERPOLATION_TIME, 1, sdo.unsigned(round(period * 1e3), 1)),
            sdo.Write(INTERPOLATION_TIME, 2, struct.pack("<b", -3)),
        ]
    steps += process_data(node, True, 1, COMMAND, kind)
    steps += process_data(node, False, 1, FEEDBACK, kind, 0.0 if cyclic else period)
    if master:
        watched = sdo.unsigned(master << 16 | int.from_bytes(_milliseconds(patience), "little"), 4)
        steps.append(sdo.Write(CONSUMER_HEARTBEAT, 1, watched))
        steps.append(sdo.Write(REACTION_TO_LOST_MASTER, 0, struct.pack("<h", _QUICK_STOP)))
    return [*steps, sdo.Write(PRODUCER_HEARTBEAT, 0, _milliseconds(heartbeat))]


class Configuration:
    """The steps of one node, one after the other, each after the answer to the one before.

    Attributes:
        failure: why it has failed; the empty text if it has not.
        cause: of a failure that is no silence the object that was refused or is wrong, by which it is counted.
        done: True when the last frame, the start of the node, has been given out.
    """

    __slots__ = ("_at", "_deadline", "_node", "_steps", "_tries", "cause", "done", "failure")

    def __init__(self, node: int, steps: Sequence[Step]) -> None:
        self._node, self._steps = node, tuple(steps)
        self._at, self._tries, self._deadline = -1, 0, 0.0
        self.done, self.failure, self.cause = False, "", ""

    def poll(self, t: float) -> Frame | None:
        """Return the frame to send now, at t, s; None to wait."""
        if self.done or self.failure:
            return None
        if self._at < 0:
            self._at, self._deadline = 0, t + BOOT_TIME
            return encode(Nmt(NmtCommand.PRE_OPERATIONAL, self._node))
        if t < self._deadline:
            return None
        if self._at == len(self._steps):
            self.done = True
            return encode(Nmt(NmtCommand.START, self._node))
        step = self._steps[self._at]
        if self._tries == TRIES:
            self.failure = f"{self._named(step)}: no answer, asked {TRIES} times"
            return encode(sdo.request(self._node, sdo.Abort(step.object, step.subindex, sdo.TIMED_OUT)))
        self._tries, self._deadline = self._tries + 1, t + ANSWER_TIME
        content = sdo.Read(step.object, step.subindex) if isinstance(step, Check) else sdo.Write(*step)
        return encode(sdo.request(self._node, content))

    def accept(self, message: SdoAnswer) -> None:
        """Take an answer of any node; what does not answer the present step is left alone."""
        if message.node != self._node or self._at < 0 or not self._tries or self.done or self.failure:
            return
        step = self._steps[self._at]
        try:
            answer = sdo.decode_answer(message)
        except FrameError as error:
            self._fail(step, str(error))
            return
        if answer[:2] != step[:2]:
            return
        if isinstance(answer, sdo.Abort) and not isinstance(step, Wish):
            self._fail(step, f"refused, {answer.text}")
        elif isinstance(step, Check) and isinstance(answer, sdo.ReadDone):
            found = int.from_bytes(answer.data, "little") & step.mask
            if found != step.value:
                self._fail(step, f"{found}, must be {step.value}")
            self._go_on()
        elif not isinstance(step, Check) and not isinstance(answer, sdo.ReadDone):
            self._go_on()

    def _go_on(self) -> None:
        self._at, self._tries, self._deadline = self._at + 1, 0, 0.0

    def _fail(self, step: Step, why: str) -> None:
        self.failure, self.cause = f"{self._named(step)}: {why}", f"_0x{step.object:04X}"

    def _named(self, step: Step) -> str:
        return f"node {self._node}, object 0x{step.object:04X}:{step.subindex}"


def _milliseconds(time: float) -> bytes:
    return sdo.unsigned(round(time * 1e3), 2)
