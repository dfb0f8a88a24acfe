"""The autopilot: one pure step from what was heard and ordered to what the fins are told."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from firmware_py.allocation import Allocator
from firmware_py.guidance.guidance import Guidance
from firmware_py.records.command import Applied, Demand, ModeState, Reference
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.order import Order
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.gate import Gate
from firmware_py.safety.supervisor import Supervisor
from firmware_py.schedule import Tick


class Estimator(Protocol):
    """Whoever turns measurements into a state; the configuration chooses."""

    def update(self, tick: Tick, frame: SensorFrame, applied: Applied) -> StateEstimate:
        """The state at `tick`; `applied` is what the actuators were told in the tick before."""

    def keep(self) -> Any:
        """What a later run may start from."""

    def freeze(self) -> Any:
        """All it remembers."""

    def thaw(self, memory: Any) -> None:
        """Takes up again what `freeze` gave."""


class Law(Protocol):
    """Whoever makes a demand of a reference; the configuration chooses."""

    def update(self, tick: Tick, mode: ModeState, order: Order, reference: Reference, state: StateEstimate) -> Demand:
        """Stern planes, rudder and propeller for this tick."""

    def freeze(self) -> Any:
        """All it remembers."""

    def thaw(self, memory: Any) -> None:
        """Takes up again what `freeze` gave."""


class Reconfigurator(Protocol):
    """Whoever makes of an order's changes other parts for an autopilot: the composition root."""

    def adopt(self, autopilot: Autopilot, changes: tuple[str, ...]) -> tuple[str, ...]:
        """Changes the parts in place, which remember what the old ones did; returns sentences for people."""

    def freeze(self) -> Any:
        """All that was adopted."""

    def thaw(self, autopilot: Autopilot, memory: Any) -> None:
        """Makes the parts that `freeze` was asked about, fresh."""


class Memory(NamedTuple):
    """Everything the autopilot remembers from one tick to the next, and the changes that were adopted."""

    adopted: Any
    estimator: Any
    supervisor: Any
    guidance: Any
    control: Any
    gate: Any
    applied: Applied


class Autopilot:
    """The whole vehicle's mind, one part per line of `step`."""

    def __init__(
        self,
        estimator: Estimator,
        supervisor: Supervisor,
        guidance: Guidance,
        control: Law,
        allocator: Allocator,
        gate: Gate,
        adopter: Reconfigurator,
    ) -> None:
        self.estimator = estimator
        self.supervisor = supervisor
        self.guidance = guidance
        self.control = control
        self.allocator = allocator
        self.gate = gate
        self.adopter = adopter
        self.applied = Applied(fins=(0.0,) * allocator.size, n=0.0, armed=False, limited=False)

    def step(self, tick: Tick, frame: SensorFrame, order: Order) -> Cycle:
        """One cycle: adopt what was changed, estimate, supervise, guide, control, allocate, limit."""
        adopted = self.adopter.adopt(self, order.changes) if order.changes else ()
        state = self.estimator.update(tick, frame, self.applied)
        mode = self.supervisor.update(tick, frame, state, order, self.guidance.finished)  # may only make it safer
        reference = self.guidance.update(tick, mode, order, state)
        demand = self.control.update(tick, mode, order, reference, state)
        fins = self.allocator.allocate(demand)
        self.applied = self.gate.limit(tick, mode, frame, fins, self.applied)  # last word; knows no law
        events = adopted + self.supervisor.events + self.guidance.events
        return Cycle(tick, frame, order, state, mode, reference, demand, fins, self.applied, events)

    def freeze(self) -> Memory:
        """All it remembers, so that a log can be entered in the middle."""
        return Memory(
            self.adopter.freeze(),
            self.estimator.freeze(),
            self.supervisor.freeze(),
            self.guidance.freeze(),
            self.control.freeze(),
            self.gate.freeze(),
            self.applied,
        )

    def thaw(self, memory: Memory) -> None:
        """Takes up again what `freeze` gave."""
        self.adopter.thaw(self, memory.adopted)
        self.estimator.thaw(memory.estimator)
        self.supervisor.thaw(memory.supervisor)
        self.guidance.thaw(memory.guidance)
        self.control.thaw(memory.control)
        self.gate.thaw(memory.gate)
        self.applied = memory.applied
