"""One cycle, whole: what the log keeps and a replay compares."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from firmware_py.records.adoption import Adopted
from firmware_py.records.command import Applied, Demand, FinCommand, ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import Event
from firmware_py.records.health import ActuatorHealth
from firmware_py.records.manoeuvrability import Manoeuvrability
from firmware_py.records.order import ANY_LENGTH, Order
from firmware_py.records.sensing import ROLES, SensorFrame
from firmware_py.tick import Tick


@dataclass(frozen=True, slots=True)
class Cycle:
    """Inputs (tick, frame, order) and outputs of one step; `events` are what happened in it, mostly nothing."""

    tick: Tick
    frame: SensorFrame
    order: Order
    state: StateEstimate
    actuators: ActuatorHealth
    adopted: Adopted
    left: Manoeuvrability
    mode: ModeState
    reference: Reference
    demand: Demand
    fins: FinCommand
    applied: Applied
    events: tuple[Event, ...] = field(metadata={ANY_LENGTH: True})

    @property
    def heard(self) -> SensorFrame:
        """Return the frame with those of several devices in the fields of their roles that are believed."""
        frame, others = self.frame, dict[str, Any]()
        for one in self.state.candidates:
            if one.believed and one.number:
                role = ROLES[one.role]
                others[role] = getattr(frame, f"spare_{role}")[one.number - 1]
        return replace(frame, **others) if others else frame
