"""What guidance remembers from one tick to the next."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.guidance.circle import Circle
from firmware_py.guidance.manoeuvre import ManoeuvreProgress
from firmware_py.guidance.reference_model import Lags
from firmware_py.guidance.route import RouteProgress
from firmware_py.records.command import Reference
from firmware_py.records.fence import Place
from firmware_py.records.order import Mode, Setpoint


class GuidanceMemory(NamedTuple):
    """Everything guidance remembers: `wanted` is what the mode asks for, `last` the reference that became of it.

    `circle` is what is flown in LOITER and GUIDED, `place` its centre where a station gave one.
    """

    mode: Mode
    wanted: Setpoint
    last: Reference
    depth: Lags
    heading: Lags
    crab: float
    route: RouteProgress
    learning: ManoeuvreProgress | None
    circle: Circle | None
    place: Place | None
    pace: float
    bottom: float
    home: RouteProgress


AT_REST = Reference(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, math.nan)
