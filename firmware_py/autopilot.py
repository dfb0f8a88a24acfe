"""The autopilot: one pure step from measurements and orders to fin angles and propeller speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol

from firmware_py.allocation import Allocator
from firmware_py.control.adoption import Adoption
from firmware_py.guidance.guidance import Guidance
from firmware_py.own_parts import OwnParts
from firmware_py.records.adoption import Adopted
from firmware_py.records.command import Applied, Demand, ModeState, Reference
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import Event
from firmware_py.records.health import AxisDoubt
from firmware_py.records.order import Arming, Change, Mode, Order
from firmware_py.records.passport import LearnedModel, Restored
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.actuator_watch import ActuatorWatch
from firmware_py.safety.gate import Gate
from firmware_py.safety.supervisor import Supervisor
from firmware_py.tick import Tick
from firmware_py.vehicle.manoeuvrability import ManoeuvrabilityModel

_TO_ARM = (Arming.CHECK, Arming.ARM)


class StateEstimator(Protocol):
    """Interface of the estimator: measurements to state."""

    @property
    def heard(self) -> SensorFrame:
        """Return the frame of the last update with the devices in front that are believed."""

    @property
    def believed(self) -> SensorFrame:
        """Return the frame of the last update without the measurements that are not believed."""

    @property
    def placed(self) -> SensorFrame:
        """Return the frame of the last update as sensors at the body's origin would have measured it."""

    @property
    def held(self) -> tuple[bool, ...]:
        """Return whether what planes and rudders do is held, since nobody knows where one of them is."""

    def update(
        self, tick: Tick, frame: SensorFrame, applied: Applied, doubts: Sequence[AxisDoubt], adopted: Adopted
    ) -> StateEstimate:
        """Return the state at `tick`; `applied` is what was commanded in the tick before.

        `doubts` is what the motion said of planes and rudders then, `adopted` what the laws were designed from.
        """

    def flown_by(self, mode: Mode, state: StateEstimate, /) -> StateEstimate:
        """Return the state that guidance and laws fly by in a mode, of the one that the supervisor goes by."""

    def told(self) -> tuple[Event, ...]:
        """Return what happened since the last call."""

    def keep(self) -> Any:
        """Return what a later run may start from."""

    def resume(self, kept: Any) -> None:
        """Start from what an earlier run kept."""

    def learned_model(self) -> LearnedModel | None:
        """Return what is known of the vehicle, for a later run; None where nothing is learned."""

    def restore(self, restored: Restored) -> None:
        """Begin with what an earlier run learned of the vehicle."""

    def freeze(self) -> Any:
        """Return the whole memory."""

    def thaw(self, memory: Any) -> None:
        """Restore the memory that `freeze` returned."""


class ControlLaw(Protocol):
    """Interface of the control laws: reference to demand."""

    def update(
        self, tick: Tick, mode: ModeState, order: Order, reference: Reference, state: StateEstimate, adopted: Adopted
    ) -> Demand:
        """Return the demand of stern planes, rudder and propeller for this tick."""

    def told(self) -> tuple[Event, ...]:
        """Return what happened since the last call."""

    def freeze(self) -> Any:
        """Return the whole memory."""

    def thaw(self, memory: Any) -> None:
        """Restore the memory that `freeze` returned."""


class Parts(NamedTuple):
    """The parts that a station's changes may make anew."""

    estimator: StateEstimator
    actuator_watch: ActuatorWatch
    adoption: Adoption
    supervisor: Supervisor
    guidance: Guidance
    control: ControlLaw
    gate: Gate


class Reconfigurator(Protocol):
    """Interface of what makes an autopilot's parts anew for an order's changes; see `reconfiguration`."""

    @property
    def own(self) -> OwnParts:
        """Return the classes of the parts of one's own."""

    def apply(self, changes: tuple[Change, ...], parts: Parts) -> tuple[Parts, tuple[Event, ...]]:
        """Return the parts to go on with, which remember what the old ones did, and what is to be told of it."""

    def freeze(self) -> Any:
        """Return all that was changed."""

    def thaw(self, memory: Any, parts: Parts) -> Parts:
        """Return the parts that `freeze` was asked about, fresh."""


class Memory(NamedTuple):
    """Everything the autopilot remembers from one tick to the next, and the changes that were made."""

    changed: Any
    parts: tuple[Any, ...]
    """What each of `Parts` remembers."""
    applied: Applied


class Autopilot:
    """The whole vehicle's autopilot, one part per line of `step`."""

    def __init__(
        self, parts: Parts, allocator: Allocator, abilities: ManoeuvrabilityModel, reconfigurator: Reconfigurator
    ) -> None:
        self.parts = parts
        self.allocator = allocator
        self.abilities = abilities
        self.reconfigurator = reconfigurator
        self.applied = Applied(fins=(0.0,) * allocator.size, n=0.0, armed=False, limited=False)

    def step(self, tick: Tick, frame: SensorFrame, order: Order) -> Cycle:
        """Compute one cycle: make changes, estimate, watch, supervise, guide, control, allocate, limit."""
        self.parts, changed = self.reconfigurator.apply(order.changes, self.parts)  # parameters, mission, fence, rally
        estimator, actuator_watch, adoption, supervisor, guidance, control, gate = self.parts
        state = estimator.update(tick, frame, self.applied, actuator_watch.doubts, adoption.last)
        actuators = actuator_watch.update(tick, estimator.placed, self.applied, state, adoption.last)
        arms = order.arming in _TO_ARM
        adopted = adoption.update(tick, frame, state, self.applied, actuators.left, arms, estimator.held)
        left = self.abilities.of(adopted, actuators.left)
        finished, last = guidance.finished, guidance.last  # of the tick before
        mode = supervisor.update(tick, estimator.believed, state, actuators, order, finished, last, left)
        state = estimator.flown_by(mode.mode, state)
        if frame.payload:
            state = replace(state, payload=frame.payload)
        guidance.limit(left, adopted.caution)
        reference = guidance.update(tick, mode, order, state)
        demand = control.update(tick, mode, order, reference, state, adopted)
        fins = self.allocator.allocate(demand, actuators.left)
        self.applied = gate.limit(tick, mode, estimator.heard, fins, self.applied)  # last word; knows no law
        events = changed + adoption.events + supervisor.events + guidance.events + estimator.told() + control.told()
        return Cycle(
            tick, frame, order, state, actuators, adopted, left, mode, reference, demand, fins, self.applied, events
        )

    def freeze(self) -> Memory:
        """Return the whole memory, so that a replay can start in the middle of a log."""
        return Memory(self.reconfigurator.freeze(), tuple(part.freeze() for part in self.parts), self.applied)

    def thaw(self, memory: Memory) -> None:
        """Restore the memory that `freeze` returned."""
        self.parts = self.reconfigurator.thaw(memory.changed, self.parts)
        parts: tuple[Any, ...] = self.parts
        for part, remembered in zip(parts, memory.parts, strict=True):
            part.thaw(remembered)
        self.applied = memory.applied
