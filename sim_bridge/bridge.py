"""The simulated vehicle as a whole: its plant and its devices, stepped one tick at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from firmware_py.tick import Tick
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.plant_error import PlantError
from sim_bridge.truth_sample import TruthSample


class DevicePort(Protocol):
    """The devices between the plant and the autopilot; times are in s."""

    @property
    def released(self) -> bool:
        """Return whether the drop weight was let go."""

    @property
    def babbled(self) -> int:
        """Return how many frames of no use a babbling node has sent."""

    def initialise(self, plant: Plant, /) -> None:
        """Take the initial state of the plant."""

    def receive(self, t: float, /) -> None:
        """Take what the autopilot has sent."""

    def commands(self, t: float, fins: Sequence[float], /) -> tuple[Sequence[float], float]:
        """Return the fin angles (rad) and shaft speed (rev/s) commanded from t on; `fins` are the true angles."""

    def publish(self, k: int, t: float, plant: Plant, /) -> None:
        """Send what is measured at tick k."""


class FaultPort(Protocol):
    """The faults of a run; `next_t` is when something happens next, s; `weight_stuck`: the drop weight stays."""

    next_t: float
    weight_stuck: bool

    def update(self, t: float, /) -> None:
        """End and begin what is due at time t, s."""

    def override(self, fins: Sequence[float], n: float, /) -> tuple[Sequence[float], float]:
        """Return what fins (rad) and shaft (rev/s) do in place of what is commanded."""


class Bridge:
    """Plant, devices and faults. What is commanded in tick k acts from k to k + 1; what is true at k is sent at k."""

    def __init__(self, plant: Plant, devices: DevicePort, faults: FaultPort) -> None:
        self._plant = plant
        self._devices = devices
        self._faults = faults
        devices.initialise(plant)

    def step(self, k: int) -> None:
        """Step the plant from tick k - 1 to tick k (k = 0 is the start) and send what is measured there.

        Raises:
            PlantError: the state is no longer finite, or the vehicle ran aground.
        """
        plant, devices = self._plant, self._devices
        t = k * plant.dt
        if t >= self._faults.next_t:
            self._faults.update(t)
        if k > 0:
            devices.receive(t - plant.dt)
            if devices.released and not self._faults.weight_stuck:
                plant.release_weight()
            plant.step(*self._faults.override(*devices.commands(t - plant.dt, plant.fins)))
            if plant.aground:
                depth = plant.eta.z + plant.altitude
                raise PlantError(f"ran aground at t = {t:.2f} s, where the bottom is {depth:.1f} m deep")
        devices.publish(k, t, plant)

    @property
    def depth(self) -> float:
        """Return the true depth at the last tick, m."""
        return self._plant.eta.z

    @property
    def babbled(self) -> int:
        """Return how many frames of no use a babbling node has sent."""
        return self._devices.babbled

    def truth(self) -> TruthSample:
        """Return the true state at the last tick."""
        plant = self._plant
        return TruthSample(plant.eta, plant.nu, plant.current_ned, plant.fins, plant.n, plant.drop_weight)


class PlantSchedule:
    """A `ports.Schedule` that never waits: it steps the plant to each tick before it yields it.

    For a run in real time, `advance` is passed to `adapters.realtime_schedule.RealTimeSchedule`.
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
