"""What the autopilot knows of one drive: how far its start-up is, whether it lives, in which state it is."""

from __future__ import annotations

import math

from firmware_py.marine import clip
from firmware_py.wire.canopen import cia402, sdo
from firmware_py.wire.canopen.cia402 import Command, Feedback, Mode, State, Wanted
from firmware_py.wire.canopen.configuration import ERROR_REGISTER, Configuration, Wish, drive
from firmware_py.wire.canopen.fin_drive import CanOpenParams, FinDrive
from firmware_py.wire.canopen.frames import Emergency, Frame, Heartbeat, NmtState, SdoAnswer, encode
from firmware_py.wire.fin_positions import AtRest

_AGAIN_S = 1.0
"""Pause before a start-up that has failed is tried again, and between two orders to reset a fault or lose power, s."""
_ERRORS = sdo.Read(ERROR_REGISTER, 0)
_LOSE_POWER = Wish(cia402.CONTROLWORD, 0, bytes(2))
"""The first step of a start-up while no power is wanted: process data do not reach a drive that is not operational."""
_MOST_CODES = 16
"""So many codes of emergencies are counted each by itself; a drive that tells ever other ones tells nothing by them."""
_TWICE = 3
"""So many times in succession two answers to one SYNC are two drives under one id; once is a frame that came twice."""


class DriveLink:
    """One drive. It is configured when it boots, is first heard, or was lost; then it is led to what is wanted.

    Attributes:
        counts: what went wrong, by cause.
        restarted: whether it has booted since this was last asked for.
        doubled: whether two drives answer under its id.
    """

    def __init__(self, fin: FinDrive, params: CanOpenParams) -> None:
        self.fin, self.node, self._params = fin, fin.params.node, params
        self._steps = drive(
            self.node, fin.params.mode, 1.0 / params.rate, params.heartbeat, params.node_id, params.patience
        )
        self.counts: dict[str, int] = {}
        self.restarted = self.doubled = False
        self._configuration = Configuration(self.node, self._steps)
        self._t_again = math.inf
        """When a start-up that has failed, and was counted, is tried again."""
        self._t_heard = self._t_beat = self._t_started = self._t_reset = 0.0
        self._t_told = -math.inf
        """When it was told to lose its power though it is lost."""
        self._known = self._alive = False
        self._led = self._off = False
        """Whether it was ready once, so that it is known to be a drive; whether it is to have no power."""
        self._emergency = self._asked = False
        """Whether it is in an emergency; whether it was asked for its errors after the last word of one."""
        self._t_asked = 0.0
        self._codes: set[int] = set()
        self._feedback: Feedback | None = None
        self._word, self._target = 0, 0.0
        self._answers = self._twice = 0

    @property
    def ready(self) -> bool:
        """Return whether it is configured and lives."""
        return self._configuration.done and self._alive

    @property
    def ok(self) -> bool:
        """Return whether what it reports is to be believed."""
        return self.ready and not self._emergency and self._feedback is not None and self._feedback.usable

    @property
    def faulty(self) -> bool:
        """Return whether it says itself that it does not work."""
        return self._alive and (self._emergency or (self._feedback is not None and not self._feedback.usable))

    def start_up(self, t: float) -> Frame | None:
        """Return what its start-up sends at t, s, if anything; notice that it has fallen silent."""
        if self._alive and t - self._t_heard > self._params.timeout:
            self._count("timeouts")
            self._emergency = False  # it may have no power; if its error lasts, its statusword says so
            self._begin()
        elif self._alive and t - self._t_beat > self._params.timeout:
            # A busy bus starves heartbeats and SDO first: to configure a drive that obeys could only stop its fin.
            self._count("heartbeats_missed")
            self._t_beat = t
        if t >= self._t_again:
            self._configure()
        configuration = self._configuration
        frame = configuration.poll(t)
        if configuration.failure and self._t_again == math.inf:
            self._count(f"start_ups_failed{configuration.cause}")
            self._t_again = t + _AGAIN_S
        elif configuration.done and frame is not None:
            self._t_heard = self._t_beat = self._t_started = t  # from now on its heartbeat is due
            self._alive = self._led = True
            self._answers = 1
        elif self.ready and self._emergency and t - self._t_asked >= _AGAIN_S:
            self._asked, self._t_asked = True, t
            return encode(sdo.request(self.node, _ERRORS))
        return frame

    def hear_heartbeat(self, message: Heartbeat, t: float) -> None:
        """Take a heartbeat; if it says that it has booted, or another has stopped it, configure it anew."""
        self._t_heard = self._t_beat = t
        self._known, known = True, self._known
        if message.state is NmtState.BOOT_UP:
            if known:
                self.restarted = True
                self._count("restarts")
            self._emergency = False
            self._begin()
        elif message.state is not NmtState.OPERATIONAL and self.ready and t - self._t_started > self._params.timeout:
            self._count("stopped_by_others")
            self._begin()

    def hear_answer(self, message: SdoAnswer) -> None:
        """Take an answer of its object dictionary; an emergency whose end was not heard is over without errors."""
        self._configuration.accept(message)
        if self.ready and self._emergency and self._asked:
            answer = sdo.decode_answer(message)
            if isinstance(answer, sdo.ReadDone) and answer[:2] == _ERRORS and not answer.data[0]:
                self._emergency = False
                self._count("emergency_ends_missed")

    def hear_emergency(self, message: Emergency, t: float) -> None:
        """Take an emergency, or the end of one, at t, s; the last has ended once the error register is empty."""
        self._asked, self._t_asked = False, t  # it overtakes the answer to what was asked before
        self._emergency = not message.over or message.register != 0
        if not message.over:
            if len(self._codes) < _MOST_CODES:
                self._codes.add(message.code)
            self._count(f"emergency_0x{message.code:04X}" if message.code in self._codes else "emergency_others")

    def hear_feedback(self, feedback: Feedback, t: float) -> float:
        """Take where it is, heard at t, s; return the angle of its fin, rad. It lives, if it is in a state at all."""
        if feedback.state is not None:
            self._t_heard = t
        was, self._feedback = self._feedback, feedback
        if was is not None and was.state is State.FAULT and feedback.usable:
            self._emergency = False  # it took our reset; not every drive tells
        self._answers += 1
        return self.fin.angle(feedback.position)

    def command(self, angle: float | None, t: float) -> Command | None:
        """Return what it is sent in a cycle, at t, s, if anything.

        One that is lost may still hear, and our heartbeat keeps it from stopping: it can lose its power, and does not
        get it.

        The target goes from where the fin is, not faster than the file says: a drive that gets power far from the
        command would jump, or fail for its following error.

        Args:
            angle: of the fin, rad; None: no power.
            t: now, s.
        """
        off, self._off = self._off, angle is None
        if not self.ready:
            return self._lose_power(self._off and not off, t)
        self._watch_answers()
        feedback, params = self._feedback, self.fin.params
        now = None if feedback is None else feedback.state
        wanted = Wanted.OFF if angle is None else Wanted.ENABLED
        reset = now is State.FAULT and t - self._t_reset >= _AGAIN_S
        word = cia402.controlword(now, wanted, self._word, reset)
        if word == cia402.FAULT_RESET:
            self._t_reset = t
            self._count("fault_resets")
        if now is not State.ENABLED or angle is None:
            travel, where = self.fin.travel, 0.0 if feedback is None else self.fin.angle(feedback.position)
            self._target = clip(where, -travel, travel)  # beyond it, nothing would move for seconds
        else:
            step = params.speed / self._params.rate
            self._target += clip(angle - self._target, -step, step)
        self._word = word
        if feedback is not None and params.mode is Mode.PROFILE_POSITION:
            word = cia402.with_set_point(word, feedback.statusword)
        return self._with(word)

    def last_frames(self) -> list[Frame]:
        """Return what it is sent last: to go to the middle, if it is to rest there and can by itself; else to stop."""
        if self.ready:
            return [encode(cia402.command(last)) for last in self._last_commands()]
        if not self._led:
            return []
        word = cia402.DISABLE_VOLTAGE if self._off else cia402.QUICK_STOP
        by_sdo = sdo.Write(cia402.CONTROLWORD, 0, sdo.unsigned(word, 2))
        return [encode(cia402.command(self._with(word))), encode(sdo.request(self.node, by_sdo))]

    def _last_commands(self) -> tuple[Command, ...]:
        state = None if self._feedback is None else self._feedback.state
        params = self.fin.params
        if state is State.ENABLED and params.at_rest is AtRest.CENTRE and params.mode is Mode.PROFILE_POSITION:
            middle, without = self.fin.counts(0.0), cia402.ENABLE | cia402.AT_ONCE  # it is taken where the bit rises
            return Command(self.node, without, middle), Command(self.node, without | cia402.NEW_SET_POINT, middle)
        return (self._with(cia402.controlword(state, Wanted.QUICK_STOP)),)

    def _lose_power(self, begins: bool, t: float) -> Command | None:
        """Have a drive that is not ready lose its power, by SDO and as process data; before, it must have been led."""
        if begins and self._led:
            self._configure()
        if not self._led or not self._off or t - self._t_told < _AGAIN_S:
            return None
        self._t_told = t
        return self._with(cia402.DISABLE_VOLTAGE)

    def _with(self, word: int) -> Command:
        return Command(self.node, word, self.fin.counts(self._target))

    def _watch_answers(self) -> None:
        """Judge the answers to the last SYNC; in profile position mode a drive sends when it likes."""
        if self.fin.params.mode is Mode.CYCLIC_SYNCHRONOUS_POSITION and self.ready:
            self._twice = self._twice + 1 if self._answers > 1 else 0
            self.doubled = self._twice >= _TWICE
            if not self._answers:
                self._count("answers_missed")
        self._answers = 0

    def _begin(self) -> None:
        """Configure it anew, and know nothing of it."""
        self._configure()
        self._alive, self._feedback, self._word = False, None, 0
        self._answers = self._twice = 0

    def _configure(self) -> None:
        steps = [_LOSE_POWER, *self._steps] if self._led and self._off else self._steps
        self._configuration, self._t_again = Configuration(self.node, steps), math.inf

    def _count(self, cause: str) -> None:
        self.counts[cause] = self.counts.get(cause, 0) + 1
