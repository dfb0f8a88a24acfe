"""A simulated CiA 402 drive: frames in, frames out. It follows the profile's table of transitions, not our commands."""

from __future__ import annotations

import math

from firmware_py.wire.canopen import cia402, frames, sdo
from firmware_py.wire.canopen.cia402 import State
from firmware_py.wire.canopen.configuration import COMMAND, FEEDBACK, Mapped
from firmware_py.wire.canopen.frames import Frame, NmtCommand, NmtState

NOT_NOW = 0x0800_0022
_OFF = 1 << 31
_LENGTHS = {
    (0x1000, 0): 4,
    (0x1001, 0): 1,
    (0x1016, 1): 4,
    (0x1017, 0): 2,
    (0x6007, 0): 2,
    (0x6040, 0): 2,
    (0x6041, 0): 2,
    (0x6060, 0): 1,
    (0x6061, 0): 1,
    (0x6064, 0): 4,
    (0x607A, 0): 4,
    (0x60C2, 1): 1,
    (0x60C2, 2): 1,
    (0x6502, 0): 4,
    **{
        (parameters, sub): length
        for parameters in (0x1400, 0x1800)
        for sub, length in ((0, 1), (1, 4), (2, 1), (3, 2), (5, 2))
    },
    **{(mapping, sub): 4 if sub else 1 for mapping in (0x1600, 0x1A00) for sub in range(9)},
}
_READ_ONLY = {0x1000, 0x1001, 0x6041, 0x6061, 0x6064, 0x6502}


class Drive:
    """A node.

    Attributes:
        objects: its object dictionary.
        nmt: what it is.
        state: of the drive.
        position: where it is, counts: set by whoever turns it; `target` is where it shall be.
        broken: True while a fault cannot be reset.
    """

    def __init__(self, node: int) -> None:
        self.node = node
        self.objects = {place: bytes(length) for place, length in _LENGTHS.items()}
        self.objects[0x1000, 0] = (402 | 2 << 16).to_bytes(4, "little")  # servo drive
        self.objects[0x6007, 0] = b"\1\0"  # a fault
        self.objects[0x6502, 0] = (1 << 0 | 1 << 7).to_bytes(4, "little")  # both position modes
        for parameters, identifier in ((0x1400, 0x200), (0x1800, 0x180)):
            self.objects[parameters, 1] = (_OFF | identifier + node).to_bytes(4, "little")
            self.objects[parameters, 2] = b"\xff"
        self.nmt, self.state = NmtState.BOOT_UP, State.DISABLED
        self.position, self.target, self.broken = 0, 0, False
        self._word = 0
        self._t_beat = self._t_master = -math.inf

    @property
    def enabled(self) -> bool:
        """Return whether it follows its target."""
        return self.state is State.ENABLED and self.nmt is NmtState.OPERATIONAL

    def boot(self) -> Frame:
        """Return what it says once it is up."""
        self.nmt = NmtState.PRE_OPERATIONAL
        return frames.encode(frames.Heartbeat(self.node, NmtState.BOOT_UP))

    def heartbeat(self) -> Frame:
        """Return what it says of itself."""
        return frames.encode(frames.Heartbeat(self.node, self.nmt))

    def live(self, t: float) -> list[Frame]:
        """Return the heartbeat that is due at t, s; stop quickly if the master's is missing."""
        watched = int.from_bytes(self.objects[0x1016, 1], "little")
        if self.state is State.ENABLED and watched >> 16 and t - self._t_master > 1e-3 * (watched & 0xFFFF):
            self._abort_connection()
        period = 1e-3 * int.from_bytes(self.objects[0x1017, 0], "little")
        if not period or t - self._t_beat < period - 1e-9:
            return []
        self._t_beat = t
        return [self.heartbeat()]

    def fail(self, code: int) -> Frame:
        """Fall into a fault, and return the emergency."""
        self.state = State.FAULT
        return frames.encode(frames.Emergency(self.node, code, 1))

    def feedback(self) -> list[Frame]:
        """Return the process data, if they are on."""
        if self.nmt is not NmtState.OPERATIONAL or self._mapped(0x1800) != FEEDBACK:
            return []
        word = cia402.statusword(self.state, self._flags())
        return [frames.encode(cia402.feedback(cia402.Feedback(self.node, word, self.position)))]

    def handle(self, identifier: int, data: bytes, t: float = 0.0) -> list[Frame]:
        """Take a frame at t, s, and return what it says to it."""
        message = frames.decode(identifier, data)
        if isinstance(message, frames.Heartbeat):
            if message.node == self.objects[0x1016, 1][2]:
                self._t_master = t
            return []
        if isinstance(message, frames.Nmt) and message.node in (0, self.node):
            states = {NmtCommand.START: NmtState.OPERATIONAL, NmtCommand.STOP: NmtState.STOPPED}
            self.nmt = states.get(message.command, NmtState.PRE_OPERATIONAL)
            if self.nmt is NmtState.STOPPED and self.state is State.ENABLED:
                self._abort_connection()
        elif self.nmt is NmtState.STOPPED:
            return []
        elif isinstance(message, frames.SdoRequest) and message.node == self.node:
            return [frames.encode(sdo.answer(self.node, answer)) for answer in self._serve(sdo.decode_request(message))]
        elif isinstance(message, frames.Rpdo) and message.node == self.node and self.nmt is NmtState.OPERATIONAL:
            if self._mapped(0x1400) == COMMAND:
                _, word, target = cia402.decode_command(message)
                self._obey(word, target)
        elif isinstance(message, frames.Sync) and self.objects[0x1800, 2] == b"\1":
            return self.feedback()
        return []

    def _abort_connection(self) -> None:
        """Do what object 0x6007 says of a lost master and of NMT stop: nothing, no power, a quick stop or a fault."""
        reactions = {0: self.state, 2: State.DISABLED, 3: State.QUICK_STOP}
        self.state = reactions.get(int.from_bytes(self.objects[0x6007, 0], "little"), State.FAULT)

    def _obey(self, word: int, target: int) -> None:
        rising = word & ~self._word
        self._word = word
        self.state = self._next(word, rising)
        profile = self.objects[0x6060, 0] == b"\1"
        if self.state is State.ENABLED and (not profile or rising & cia402.NEW_SET_POINT):
            self.target = target

    def _next(self, word: int, rising: int) -> State:
        now = self.state
        if now is State.FAULT:
            return State.DISABLED if rising & 0x80 and not self.broken else now
        powered = now in (State.READY, State.SWITCHED_ON, State.ENABLED, State.QUICK_STOP)
        if not word & 2:  # 7, 9, 10, 12
            return State.DISABLED if powered else now
        if not word & 4:  # 7, 10, 11
            return {
                State.ENABLED: State.QUICK_STOP,
                State.READY: State.DISABLED,
                State.SWITCHED_ON: State.DISABLED,
            }.get(now, now)
        if word & 0x0F == 0x0F:  # 3, 4, 16
            enabled = {
                State.READY: State.SWITCHED_ON,
                State.SWITCHED_ON: State.ENABLED,
                State.QUICK_STOP: State.ENABLED,
            }
            return enabled.get(now, now)
        if word & 1:  # 3, 5
            return State.SWITCHED_ON if now in (State.READY, State.ENABLED) else now
        return State.READY if now in (State.DISABLED, State.SWITCHED_ON, State.ENABLED) else now  # 2, 6, 8

    def _flags(self) -> int:
        profile = self.objects[0x6060, 0] == b"\1"
        taken = self._word & cia402.NEW_SET_POINT if profile else self.state is State.ENABLED
        return cia402.ACKNOWLEDGE if taken else 0

    def _mapped(self, parameters: int) -> tuple[Mapped, ...] | None:
        """Return what is in a PDO; None if it is off."""
        if int.from_bytes(self.objects[parameters, 1], "little") & _OFF:
            return None
        mapping = parameters + 0x200
        places = [int.from_bytes(self.objects[mapping, k + 1], "little") for k in range(self.objects[mapping, 0][0])]
        return tuple(Mapped(place >> 16, place >> 8 & 0xFF, place & 0xFF) for place in places)

    def _serve(self, asked: sdo.Request) -> list[sdo.Answer]:
        if isinstance(asked, sdo.Abort):
            return []
        place = asked.object, asked.subindex
        if place not in self.objects:
            known = any(index == asked.object for index, _ in self.objects)
            return [sdo.Abort(*place, sdo.NO_SUBINDEX if known else sdo.NO_OBJECT)]
        if isinstance(asked, sdo.Read):
            current = {
                (0x1001, 0): bytes([self.objects[0x1001, 0][0] | (self.state is State.FAULT)]),
                (0x6041, 0): cia402.statusword(self.state, self._flags()).to_bytes(2, "little"),
                (0x6061, 0): self.objects[0x6060, 0],
                (0x6064, 0): self.position.to_bytes(4, "little", signed=True),
            }
            return [sdo.ReadDone(*place, current.get(place, self.objects[place]))]
        code = self._refusal(asked)
        if code:
            return [sdo.Abort(*place, code)]
        self.objects[place] = asked.data
        if asked.object == 0x6040:
            self._obey(int.from_bytes(asked.data, "little"), self.target)
        return [sdo.WriteDone(*place)]

    def _refusal(self, asked: sdo.Write) -> int:
        if asked.object in _READ_ONLY:
            return sdo.READ_ONLY
        if len(asked.data) != _LENGTHS[asked.object, asked.subindex]:
            return sdo.WRONG_LENGTH
        if asked.object in (0x1600, 0x1A00):
            off = int.from_bytes(self.objects[asked.object - 0x200, 1], "little") & _OFF
            if not off or (asked.subindex and self.objects[asked.object, 0] != b"\0"):
                return NOT_NOW
        if 0x1400 <= asked.object < 0x1B00 and self.nmt is NmtState.OPERATIONAL:
            return NOT_NOW
        return 0
