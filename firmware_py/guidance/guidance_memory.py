"""What guidance remembers from one tick to the next."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.guidance.circle import Circle
from firmware_py.guidance.manoeuvre import ManoeuvreMemory
from firmware_py.guidance.reference_model import Lags
from firmware_py.guidance.route import RouteProgress
from firmware_py.records.command import Reference
from firmware_py.records.fence import Place
from firmware_py.records.order import Mode, Setpoint


class GuidanceMemory(NamedTuple):
    """The memory of guidance: `wanted` is the setpoint of the mode, `last` the last reference.

    `circle` is that of LOITER and GUIDED, `place` its centre if a station gave one; `pace` is an ordered speed, m/s,
    that overrides those of the mission; `bottom` the depth of the bottom, m; `home` the ways of RETURN and SURFACE.
    """

    mode: Mode
    wanted: Setpoint
    last: Reference
    depth: Lags
    heading: Lags
    crab: float
    route: RouteProgress
    learning: ManoeuvreMemory
    circle: Circle | None
    place: Place | None
    pace: float
    bottom: float
    home: tuple[RouteProgress, ...]


AT_REST = Reference(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, math.nan)
