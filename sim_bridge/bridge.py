"""The boat as a whole: its plant, its instruments and its devices, moved on one tick at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Protocol

from firmware_py.params import ParamError
from firmware_py.schedule import Tick
from sim_bridge.faults import Fault, Faults
from sim_bridge.plant.plant import Plant
from sim_bridge.truth_sample import TruthSample


class Devices(Protocol):
    """Whatever is between the boat and its vehicle; times are in s."""

    def settle(self, plant: Plant, /) -> None:
        """Begins where the boat is."""

    def hear(self, t: float, /) -> None:
        """Takes what the vehicle has said."""

    def commands(self, t: float, fins: Sequence[float], /) -> tuple[Sequence[float], float]:
        """Fin angles (rad) and shaft speed (rev/s) that act from t on; `fins` is where they are."""

    def speak(self, k: int, t: float, plant: Plant, /) -> None:
        """Says what is measured at tick k."""

    def switch_off(self, device: str, /) -> None:
        """Takes a device's power away."""


class Bridge:
    """All beyond the wires. What was commanded in tick k acts from k to k + 1; what is true at k is sent at k."""

    def __init__(self, plant: Plant, devices: Devices, faults: Iterable[Fault] = ()) -> None:
        """Raises ParamError if a fault strikes a fin that the boat does not have."""
        self._plant = plant
        self._devices = devices
        self._faults = Faults(faults)
        self._names = [fin.name for fin in plant.truth.fins]
        for fin in self._faults.fins:
            if fin not in self._names:
                raise ParamError(f"fault fin-jam:{fin}: there is no such fin; known: {', '.join(self._names)}")
        devices.settle(plant)

    def step(self, k: int) -> None:
        """Brings the boat from tick k - 1 to tick k (k = 0 is the start) and says what it measures there."""
        plant, devices = self._plant, self._devices
        t = k * plant.dt
        if t >= self._faults.next_t:
            self._faults.strike(t, self)
        if k > 0:
            devices.hear(t - plant.dt)
            plant.step(*devices.commands(t - plant.dt, plant.fins))
        devices.speak(k, t, plant)

    def truth(self) -> TruthSample:
        """What is really the case at the tick that was last stepped to."""
        plant = self._plant
        return TruthSample(plant.eta, plant.nu, plant.current_ned, plant.fins, plant.n)

    def switch_off(self, device: str) -> None:
        """Takes a device's power away: it is never heard again."""
        self._devices.switch_off(device)

    def jam(self, fin: str) -> None:
        """Blocks a fin where it is."""
        self._plant.jam(self._names.index(fin))


class Lockstep:
    """The schedule that waits for nothing: it moves the boat to each tick before it yields it; a `ports.Schedule`.

    `advance` alone is what `adapters.clock.RealTime` wants to be handed for the same run in real time.
    """

    def __init__(self, bridge: Bridge, dt_ns: int, ticks: int, stop: Callable[[], bool] = lambda: False) -> None:
        self._bridge = bridge
        self._dt_ns = dt_ns
        self._ticks = ticks
        self._stop = stop

    def advance(self, k: int) -> bool:
        """Moves the boat to tick k; False if the run is over instead."""
        if k >= self._ticks or self._stop():
            return False
        self._bridge.step(k)
        return True

    def __iter__(self) -> Iterator[Tick]:
        """Ticks 0, 1, ... until the time is over or `stop` says so."""
        k = 0
        while self.advance(k):
            yield Tick(k, self._dt_ns)
            k += 1
