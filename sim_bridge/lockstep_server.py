"""The plant's side of the lockstep with a vehicle in another process: it steps when the vehicle has acknowledged."""

from __future__ import annotations

from collections.abc import Callable

from firmware_py.adapters.lockstep.lockstep_link import BYE, HELLO, TIMEOUT, VERSION, LockstepError, LockstepLink
from firmware_py.wire.dronecan.message_table import TICK, TICK_DONE
from firmware_py.wire.dronecan.node_messages import LockstepTick

_HELLO_PERIOD = 0.2
"""How often hello is sent to a vehicle that has not acknowledged yet, s."""


def accept_vehicle(link: LockstepLink, dt_ns: int, seconds: float, stop: Callable[[], bool]) -> bool:
    """Send hello until a vehicle acknowledges it; return False if `stop` returned True before.

    Raises:
        LockstepError: no vehicle acknowledged within `seconds`, or one refused.
    """
    for _ in range(max(1, round(seconds / _HELLO_PERIOD))):
        link.send_message(TICK, LockstepTick(HELLO, dt_ns, 0, VERSION))
        done = link.receive_message(TICK_DONE, _HELLO_PERIOD, stop)
        if stop():
            return False
        if done is not None and done.k == HELLO:
            link.discard()
            return True
        if done is not None and done.k == BYE:
            raise LockstepError("the vehicle refused: it has another rate, or another version of the lockstep")
    raise LockstepError(f"no vehicle answered for {seconds:g} s; start one: sternplane fly --pace bus")


class LockstepServer:
    """Runs a plant in lockstep. `step(k)` moves it to tick k and sends what its devices measure there."""

    def __init__(self, step: Callable[[int], None], link: LockstepLink, dt_ns: int) -> None:
        self._step = step
        self._link = link
        self._dt_ns = dt_ns

    def advance(self, k: int, stop: Callable[[], bool]) -> bool:
        """Step to tick k and wait for the vehicle's acknowledgement; return False if either side ends the run.

        Raises:
            LockstepError: the vehicle is silent, or a frame was lost.
        """
        link = self._link
        self._step(k)
        link.send_message(TICK, LockstepTick(k, k * self._dt_ns, link.frames_sent & 0xFFFF, VERSION))
        while True:
            done = link.receive_message(TICK_DONE, TIMEOUT, stop)
            if stop():
                return False
            if done is None:
                raise LockstepError(f"the vehicle has been silent for {TIMEOUT:g} s, at tick {k}: was it ended?")
            if done.k == BYE:
                return False
            if done.k != HELLO:  # an acknowledgement of hello that came late
                break
        if done.k != k:
            raise LockstepError(f"the vehicle answered tick {done.k} when it was tick {k}: a frame was lost")
        if link.frames_received & 0xFFFF != done.frames:
            raise LockstepError(f"{link.frames_received} frames came after tick {k}, the vehicle sent {done.frames}")
        link.frames_received = 0
        return True

    def bye(self) -> None:
        """Tell the vehicle that there are no more ticks."""
        self._link.send_message(TICK, LockstepTick(BYE, 0, 0, VERSION))
