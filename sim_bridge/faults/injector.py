"""The faults of one run: each begins at the first tick that is not before its time, and ends when its time is over."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from sim_bridge.devices.sensors import Sensor
from sim_bridge.faults.checks import refuse_absent
from sim_bridge.faults.effects import EFFECTS
from sim_bridge.faults.fault import Fault
from sim_bridge.faults.overlap import Overlap
from sim_bridge.faults.target import DeviceFaults, End, NodeFaults, Strike
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.plant_error import PlantError

_SLACK = 1e-9
"""Times of ticks are products that may be rounded under a fault's time, s."""


class FaultInjector:
    """The faults of a run in order of time, and the `target.FaultTarget` that they act on.

    Args:
        faults: of the run; those aboard the vehicle are left to it.
        plant: the vehicle in the water.
        devices: what is on its wires.
        sensors: the instruments, by name.
        seed: of the run.
        nodes: the devices where they are on a CAN bus.

    Attributes:
        next_t: when something happens next, s.

    Raises:
        ParamError: a fault of a fin or of a sensor that is not there.
    """

    def __init__(
        self,
        faults: Iterable[Fault],
        plant: Plant,
        devices: DeviceFaults,
        sensors: Mapping[str, Sensor[Any, Any]],
        seed: int,
        nodes: NodeFaults | None = None,
    ) -> None:
        self.plant = plant
        self.devices = devices
        self.sensors = sensors
        self.fin_overrides: dict[int, float] = {}
        self.shaft_override = math.nan
        self.weight_stuck = False
        self.t = 0.0
        self._nodes = nodes
        self._fins = tuple(fin.name for fin in plant.truth.fins)
        self._seed = seed
        plant_s = [fault for fault in faults if not fault.kind.aboard]
        refuse_absent(plant_s, self._fins, sensors, None if nodes is None else nodes.nodes)
        self._pending = sorted(plant_s, key=lambda fault: fault.t)[::-1]  # of one time, the first written is the first
        self._ends: list[tuple[float, End]] = []
        self._overlaps: defaultdict[tuple[str, str], Overlap] = defaultdict(Overlap)
        self.next_t = self._next()

    @property
    def nodes(self) -> NodeFaults:
        """Return the devices as nodes on a CAN bus."""
        if self._nodes is None:
            raise PlantError("the devices of this vehicle are on no bus")
        return self._nodes

    def fin(self, name: str) -> int:
        """Return the place of a fin."""
        return self._fins.index(name)

    def update(self, t: float) -> None:
        """End what is over at time t, s, then begin what is due."""
        self.t = t
        over = [end for due, end in self._ends if due <= t + _SLACK]
        self._ends = [(due, end) for due, end in self._ends if due > t + _SLACK]
        for end in over:
            end()
        while self._pending and self._pending[-1].t <= t + _SLACK:
            fault = self._pending.pop()
            random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([self._seed, *fault.text.encode()])))
            effect = EFFECTS[fault.kind.name, fault.kind.group]
            strike = Strike(fault.target, fault.value, math.isinf(fault.duration), random)
            begin = partial(effect.begin, self, strike)
            end = self._overlaps[effect.replaces, fault.target].add(begin) if effect.replaces else begin()
            if math.isfinite(fault.duration):
                self._ends.append((fault.t + fault.duration, end))
        self.next_t = self._next()

    def override(self, fins: Sequence[float], n: float) -> tuple[Sequence[float], float]:
        """Return what fins (rad) and shaft (rev/s) do in place of what is commanded."""
        if self.fin_overrides:
            fins = [self.fin_overrides.get(i, angle) for i, angle in enumerate(fins)]
        return fins, n if math.isnan(self.shaft_override) else self.shaft_override

    def _next(self) -> float:
        times = [due for due, _ in self._ends] + [fault.t for fault in self._pending[-1:]]
        return min(times, default=math.inf) - _SLACK
