"""What the autopilot knows of one drive: how far its start-up is, whether it lives, in which state it is."""

from __future__ import annotations

import math

from firmware_py.marine import clip
from firmware_py.wire.canopen import cia402
from firmware_py.wire.canopen.cia402 import Command, Feedback, Mode, State, Wanted
from firmware_py.wire.canopen.configuration import Configuration, drive
from firmware_py.wire.canopen.fin_drive import CanOpenParams, FinDrive
from firmware_py.wire.canopen.frames import Emergency, Frame, Heartbeat, NmtState, SdoAnswer
from firmware_py.wire.fin_positions import AtRest

_AGAIN_S = 1.0
"""Pause before a start-up that has failed is tried again, and between two resets of a fault, s."""
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
        self._t_heard = self._t_started = self._t_reset = 0.0
        self._known = self._alive = False
        self._emergency = False
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
        if t >= self._t_again:
            self._configure()
        configuration = self._configuration
        frame = configuration.poll(t)
        if configuration.failure and self._t_again == math.inf:
            self._count(f"start_ups_failed{configuration.cause}")
            self._t_again = t + _AGAIN_S
        elif configuration.done and frame is not None:
            self._t_heard = self._t_started = t  # from now on its heartbeat is due
            self._alive, self._answers = True, 1
        return frame

    def hear_heartbeat(self, message: Heartbeat, t: float) -> None:
        """Take a heartbeat; if it says that it has booted, or another has stopped it, configure it anew."""
        self._t_heard = t
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
        """Take an answer of its object dictionary."""
        self._configuration.accept(message)

    def hear_emergency(self, message: Emergency) -> None:
        """Take an emergency, or the end of one; the last has ended once the error register is empty."""
        self._emergency = not message.over or message.register != 0
        if not message.over:
            if len(self._codes) < _MOST_CODES:
                self._codes.add(message.code)
            self._count(f"emergency_0x{message.code:04X}" if message.code in self._codes else "emergency_others")

    def hear_feedback(self, feedback: Feedback) -> float:
        """Take where it is; return the angle of its fin, rad."""
        was, self._feedback = self._feedback, feedback
        if was is not None and was.state is State.FAULT and feedback.usable:
            self._emergency = False  # it took our reset; not every drive tells
        self._answers += 1
        return self.fin.angle(feedback.position)

    def command(self, angle: float | None, t: float) -> Command:
        """Return what it is sent in a cycle, at t, s.

        The target goes from where the fin is, not faster than the file says: a drive that gets power far from the
        command would jump, or fail for its following error.

        Args:
            angle: of the fin, rad; None: no power.
            t: now, s.
        """
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
        return Command(self.node, word, self.fin.counts(self._target))

    def last_commands(self) -> tuple[Command, ...]:
        """Return what it is sent last: to go to the middle, if it is to rest there and can by itself; else to stop."""
        state = None if self._feedback is None else self._feedback.state
        params, target = self.fin.params, self._target
        if state is State.ENABLED and params.at_rest is AtRest.CENTRE and params.mode is Mode.PROFILE_POSITION:
            middle, without = self.fin.counts(0.0), cia402.ENABLE | cia402.AT_ONCE  # it is taken where the bit rises
            return Command(self.node, without, middle), Command(self.node, without | cia402.NEW_SET_POINT, middle)
        stop = cia402.controlword(state, Wanted.QUICK_STOP)
        return (Command(self.node, stop, self.fin.counts(target)),)

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
        self._configuration, self._t_again = Configuration(self.node, self._steps), math.inf

    def _count(self, cause: str) -> None:
        self.counts[cause] = self.counts.get(cause, 0) + 1
