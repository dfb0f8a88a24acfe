"""One cycle, whole: what the log keeps and a replay compares."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.records.command import Applied, Demand, FinCommand, ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.order import Order
from firmware_py.records.sensing import SensorFrame
from firmware_py.schedule import Tick


@dataclass(frozen=True, slots=True)
class Cycle:
    """Inputs (tick, frame, order) and outputs of one step; `events` are sentences for people, mostly none."""

    tick: Tick
    frame: SensorFrame
    order: Order
    state: StateEstimate
    mode: ModeState
    reference: Reference
    demand: Demand
    fins: FinCommand
    applied: Applied
    events: tuple[str, ...]
