"""The plant's side of the lockstep with a vehicle in another process: it moves on when the vehicle has answered."""

from __future__ import annotations

from collections.abc import Callable

from firmware_py.adapters.lockstep.lockstep import BYE, HELLO, PATIENCE, VERSION, LockstepError, LockstepLink
from firmware_py.wire.dronecan.messages import TICK, TICK_DONE
from firmware_py.wire.dronecan.protocol import LockstepTick

_KNOCK = 0.2
"""How often a vehicle that has not answered yet is greeted, s."""


def meet(turns: LockstepLink, dt_ns: int, seconds: float, stop: Callable[[], bool]) -> bool:
    """Greets until a vehicle answers; False if `stop` said so before.

    Raises:
        LockstepError: no vehicle answered within `seconds`.
    """
    for _ in range(max(1, round(seconds / _KNOCK))):
        turns.say(TICK, LockstepTick(HELLO, dt_ns, 0, VERSION))
        done = turns.listen(TICK_DONE, _KNOCK, stop)
        if stop():
            return False
        if done is not None and done.k == HELLO:
            turns.forget()
            return True
        if done is not None and done.k == BYE:
            raise LockstepError("the vehicle refused: it has another rate, or another version of the lockstep")
    raise LockstepError(f"no vehicle answered for {seconds:g} s; start one: sternplane fly --pace bus")


class LockstepServer:
    """Runs a boat in lockstep. `step(k)` moves it to tick k and sends what it measures there."""

    def __init__(self, step: Callable[[int], None], turns: LockstepLink, dt_ns: int) -> None:
        self._step = step
        self._turns = turns
        self._dt_ns = dt_ns

    def advance(self, k: int, stop: Callable[[], bool]) -> bool:
        """Plays tick k with the vehicle; False if either side has had enough.

        Raises:
            LockstepError: the vehicle is silent, or a frame was lost.
        """
        turns = self._turns
        self._step(k)
        turns.say(TICK, LockstepTick(k, k * self._dt_ns, turns.said & 0xFFFF, VERSION))
        while True:
            done = turns.listen(TICK_DONE, PATIENCE, stop)
            if stop():
                return False
            if done is None:
                raise LockstepError(f"the vehicle has been silent for {PATIENCE:g} s, at tick {k}: was it ended?")
            if done.k == BYE:
                return False
            if done.k != HELLO:  # an answer to a greeting that came late
                break
        if done.k != k:
            raise LockstepError(f"the vehicle answered tick {done.k} when it was tick {k}: a frame was lost")
        if turns.heard & 0xFFFF != done.frames:
            raise LockstepError(f"{turns.heard} frames came after tick {k}, the vehicle sent {done.frames}")
        turns.heard = 0
        return True

    def bye(self) -> None:
        """Tells the vehicle that there are no more ticks."""
        self._turns.say(TICK, LockstepTick(BYE, 0, 0, VERSION))
