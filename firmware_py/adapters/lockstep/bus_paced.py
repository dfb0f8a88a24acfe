"""The schedule that the bus paces: the vehicle's side of the lockstep with a plant in another process."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from firmware_py.adapters.lockstep.lockstep import BYE, HELLO, PATIENCE, VERSION, LockstepError, LockstepLink
from firmware_py.ports import Hardware
from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame
from firmware_py.schedule import Tick
from firmware_py.wire.dronecan.messages import TICK, TICK_DONE
from firmware_py.wire.dronecan.protocol import LockstepTickDone


def join(turns: LockstepLink, dt_ns: int, seconds: float, stop: Callable[[], bool] = lambda: False) -> bool:
    """Waits until a plant says hello, and checks that it is of our kind; `answer` lets it begin.

    Returns:
        False if `stop` said so before.

    Raises:
        LockstepError: no plant within `seconds`, or one of another version or rate.
    """
    hello = turns.listen(TICK, seconds, stop)
    if hello is None:
        if stop():
            return False
        raise LockstepError(f"no plant was heard on the bus for {seconds:g} s; start one: sternplane plant")
    if hello.k != HELLO:
        raise LockstepError("the plant is already flying with somebody; start it anew, or take another bus")
    if hello.version == VERSION and hello.t_ns == dt_ns:
        return True
    turns.say(TICK_DONE, LockstepTickDone(BYE, 0))
    if hello.version != VERSION:
        raise LockstepError(f"the plant speaks version {hello.version} of the lockstep, the vehicle version {VERSION}")
    raise LockstepError(f"the plant steps {hello.t_ns / 1e6:g} ms, the vehicle {dt_ns / 1e6:g} ms: set one rate_hz")


def answer(turns: LockstepLink) -> None:
    """Tells the plant that said hello to begin."""
    turns.forget()
    turns.say(TICK_DONE, LockstepTickDone(HELLO, 0))


class BusPaced:
    """A `ports.Schedule` that waits for the plant's ticks, and the `ports.Hardware` that answers them.

    Args:
        hardware: whose bus is `turns`.
        turns: on which `join` has succeeded.
        dt_ns: the step.
        stop: asked at every tick and while waiting.
    """

    def __init__(self, hardware: Hardware, turns: LockstepLink, dt_ns: int, stop: Callable[[], bool]) -> None:
        self._hardware = hardware
        self._turns = turns
        self._dt_ns = dt_ns
        self._stop = stop

    def __iter__(self) -> Iterator[Tick]:
        """Ticks, each when the plant has sent all of it, until either side has had enough.

        Raises:
            LockstepError: the plant is silent, or a frame was lost.
        """
        turns, k = self._turns, 0
        answer(turns)
        while True:
            word = turns.listen(TICK, PATIENCE, self._stop)
            if self._stop():
                break
            if word is None:
                raise LockstepError(f"the plant has been silent for {PATIENCE:g} s, at tick {k}: was it ended?")
            if word.k == HELLO and k == 0:
                continue
            if word.k == BYE:
                return
            if word.k != k:
                raise LockstepError(f"tick {word.k} came when tick {k} was due: a frame was lost")
            if turns.heard & 0xFFFF != word.frames:
                raise LockstepError(f"{turns.heard} frames came for tick {k}, the plant sent {word.frames}")
            turns.heard = 0
            yield Tick(k, self._dt_ns)
            k += 1
        turns.say(TICK_DONE, LockstepTickDone(BYE, 0))

    def read(self, tick: Tick) -> SensorFrame:
        """What was heard in this turn."""
        return self._hardware.read(tick)

    def write(self, tick: Tick, applied: Applied) -> None:
        """Sends the commands, and that they were all."""
        self._hardware.write(tick, applied)
        self._turns.say(TICK_DONE, LockstepTickDone(tick.k, self._turns.said & 0xFFFF))
