"""What sensor integrity remembers, and what it puts right."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.estimation.integrity.altitude_check import EchoMemory
from firmware_py.estimation.integrity.attitude_check import AttitudeCheckMemory
from firmware_py.estimation.integrity.fix_check import FixCheckMemory
from firmware_py.estimation.integrity.model_check import ModelCheckMemory
from firmware_py.estimation.integrity.source_watch import SourceMemory
from firmware_py.estimation.integrity.velocity_check import VelocityCheckMemory
from firmware_py.estimation.integrity.vertical_memory import VerticalCheckMemory
from firmware_py.records.health import SensorHealth
from firmware_py.records.sensing import Ahrs, Heard


class Correction(NamedTuple):
    """What navigation has to put right in this tick, for it took in what is now known to be wrong.

    Depth, m, and heading, rad, as they are; the time since which fixes were wrong, s; NaN: nothing.
    """

    depth: float
    heading: float
    fixes: float = math.nan


NO_CORRECTION = Correction(math.nan, math.nan)


class IntegrityMemory(NamedTuple):
    """Everything that is remembered."""

    sources: tuple[tuple[SourceMemory, ...], int, SensorHealth]
    vertical: VerticalCheckMemory
    attitude: AttitudeCheckMemory
    velocity: VelocityCheckMemory
    model: ModelCheckMemory
    echoes: tuple[EchoMemory, EchoMemory]
    fix: FixCheckMemory
    ahrs: Heard[Ahrs] | None
    ping: tuple[float, float, float, float]
