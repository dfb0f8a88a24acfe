"""The vehicle's side of the lockstep with a plant in another process; `sim_bridge.lockstep_server` is the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from firmware_py.adapters.lockstep.lockstep_link import BYE, HELLO, TIMEOUT, VERSION, LockstepError, LockstepLink
from firmware_py.ports import Hardware
from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Tick
from firmware_py.wire.dronecan.message_table import TICK, TICK_DONE
from firmware_py.wire.dronecan.node_messages import LockstepTickDone


def wait_for_plant(link: LockstepLink, dt_ns: int, seconds: float, stop: Callable[[], bool] = lambda: False) -> bool:
    """Wait for a plant's hello, and check its version and step; `acknowledge_hello` lets it begin.

    Returns:
        False if `stop` returned True before.

    Raises:
        LockstepError: no plant within `seconds`, or one of another version or rate.
    """
    hello = link.receive_message(TICK, seconds, stop)
    if hello is None:
        if stop():
            return False
        raise LockstepError(f"no plant was heard on the bus for {seconds:g} s; start one: sternplane plant")
    if hello.k != HELLO:
        raise LockstepError("the plant is already flying with another vehicle; start it anew, or take another bus")
    if hello.version == VERSION and hello.t_ns == dt_ns:
        return True
    link.send_message(TICK_DONE, LockstepTickDone(BYE, 0))
    if hello.version != VERSION:
        raise LockstepError(f"the plant has version {hello.version} of the lockstep, the vehicle version {VERSION}")
    raise LockstepError(f"the plant steps {hello.t_ns / 1e6:g} ms, the vehicle {dt_ns / 1e6:g} ms: set one rate_hz")


def acknowledge_hello(link: LockstepLink) -> None:
    """Tell the plant that said hello to begin."""
    link.discard()
    link.send_message(TICK_DONE, LockstepTickDone(HELLO, 0))


class LockstepClient:
    """A `ports.Schedule` that waits for the plant's ticks, and the `ports.Hardware` that acknowledges them.

    Args:
        hardware: whose bus is `link`.
        link: on which `wait_for_plant` has returned True.
        dt_ns: the step.
        stop: asked at every tick and while waiting.
    """

    def __init__(self, hardware: Hardware, link: LockstepLink, dt_ns: int, stop: Callable[[], bool]) -> None:
        self._hardware = hardware
        self._link = link
        self._dt_ns = dt_ns
        self._stop = stop

    def __iter__(self) -> Iterator[Tick]:
        """Yield ticks, each when the plant has sent all of it, until either side ends the run.

        Raises:
            LockstepError: the plant is silent, or a frame was lost.
        """
        link, k = self._link, 0
        acknowledge_hello(link)
        while True:
            message = link.receive_message(TICK, TIMEOUT, self._stop)
            if self._stop():
                break
            if message is None:
                raise LockstepError(f"the plant has been silent for {TIMEOUT:g} s, at tick {k}: was it ended?")
            if message.k == HELLO and k == 0:
                continue
            if message.k == BYE:
                return
            if message.k != k:
                raise LockstepError(f"tick {message.k} came when tick {k} was due: a frame was lost")
            if link.frames_received & 0xFFFF != message.frames:
                raise LockstepError(f"{link.frames_received} frames came for tick {k}, the plant sent {message.frames}")
            link.frames_received = 0
            yield Tick(k, self._dt_ns)
            k += 1
        link.send_message(TICK_DONE, LockstepTickDone(BYE, 0))

    def read(self, tick: Tick) -> SensorFrame:
        """Return what was received in this step."""
        return self._hardware.read(tick)

    def write(self, tick: Tick, applied: Applied) -> None:
        """Send the commands, and after them that the step is done."""
        self._hardware.write(tick, applied)
        self._link.send_message(TICK_DONE, LockstepTickDone(tick.k, self._link.frames_sent & 0xFFFF))
