"""The simulated vehicle as a whole: its plant and its devices, stepped one tick at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Protocol

from firmware_py.params import ParamError
from firmware_py.tick import Tick
from sim_bridge.faults import Fault, Faults
from sim_bridge.plant.plant import Plant
from sim_bridge.truth_sample import TruthSample


class DevicePort(Protocol):
    """The devices between the plant and the autopilot; times are in s."""

    def initialise(self, plant: Plant, /) -> None:
        """Take the initial state of the plant."""

    def receive(self, t: float, /) -> None:
        """Take what the autopilot has sent."""

    def commands(self, t: float, fins: Sequence[float], /) -> tuple[Sequence[float], float]:
        """Return the fin angles (rad) and shaft speed (rev/s) commanded from t on; `fins` are the true angles."""

    def publish(self, k: int, t: float, plant: Plant, /) -> None:
        """Send what is measured at tick k."""

    def switch_off(self, device: str, /) -> None:
        """Switch a device off."""


class Bridge:
    """Plant, devices and faults. What is commanded in tick k acts from k to k + 1; what is true at k is sent at k."""

    def __init__(self, plant: Plant, devices: DevicePort, faults: Iterable[Fault] = ()) -> None:
        """Raise ParamError if a fault names a fin that the plant does not have."""
        self._plant = plant
        self._devices = devices
        self._faults = Faults(faults)
        self._names = [fin.name for fin in plant.truth.fins]
        for fin in self._faults.fins:
            if fin not in self._names:
                raise ParamError(f"fault fin-jam:{fin}: there is no such fin; known: {', '.join(self._names)}")
        devices.initialise(plant)

    def step(self, k: int) -> None:
        """Step the plant from tick k - 1 to tick k (k = 0 is the start) and send what is measured there."""
        plant, devices = self._plant, self._devices
        t = k * plant.dt
        if t >= self._faults.next_t:
            self._faults.inject(t, self)
        if k > 0:
            devices.receive(t - plant.dt)
            plant.step(*devices.commands(t - plant.dt, plant.fins))
        devices.publish(k, t, plant)

    def truth(self) -> TruthSample:
        """Return the true state at the last tick."""
        plant = self._plant
        return TruthSample(plant.eta, plant.nu, plant.current_ned, plant.fins, plant.n)

    def switch_off(self, device: str) -> None:
        """Switch a device off for the rest of the run."""
        self._devices.switch_off(device)

    def jam(self, fin: str) -> None:
        """Jam a fin at its present angle."""
        self._plant.jam(self._names.index(fin))


class PlantSchedule:
    """A `ports.Schedule` that never waits: it steps the plant to each tick before it yields it.

    For a run in real time, `advance` is passed to `adapters.clock.RealTime`.
    """

    def __init__(self, bridge: Bridge, dt_ns: int, ticks: int, stop: Callable[[], bool] = lambda: False) -> None:
        self._bridge = bridge
        self._dt_ns = dt_ns
        self._ticks = ticks
        self._stop = stop

    def advance(self, k: int) -> bool:
        """Step the plant to tick k; return False if the run is over instead."""
        if k >= self._ticks or self._stop():
            return False
        self._bridge.step(k)
        return True

    def __iter__(self) -> Iterator[Tick]:
        """Yield ticks 0, 1, ... until the time is over or `stop` returns True."""
        k = 0
        while self.advance(k):
            yield Tick(k, self._dt_ns)
            k += 1
