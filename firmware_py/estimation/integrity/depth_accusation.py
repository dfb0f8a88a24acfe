"""Who is told to be suspect when pressure and carried depth contradict each other."""

from __future__ import annotations

from firmware_py.estimation.integrity.depth_arbitration import Accused, accuse_carried, came_back
from firmware_py.estimation.integrity.sources import Sources
from firmware_py.estimation.integrity.vertical_check import VerticalCheck
from firmware_py.records.health import SourceFault

_MOMENT = 0.5
"""What is not decided for a shorter time, s, speaks against the pressure alone, which the depth rests on."""


def accuse_depth(
    accused: Accused, t: float, sources: Sources, vertical: VerticalCheck, slip: float, pinged: bool
) -> None:
    """Note what pressure and carried depth say against each other.

    Args:
        accused: what `vertical` says, at the time
        t: s.
        sources: the watches.
        vertical: the check.
        slip: what the DVL's u leaves model and current by, m/s.
        pinged: whether the DVL carries the depth.
    """
    pressure, dvl = sources.pressure, sources.dvl
    if sources.repeats(pressure, t):
        pressure.accuse(SourceFault.FROZEN, t)
        dvl.acquit()
    elif accused is Accused.CARRIED:
        if vertical.stands_in:
            vertical.trust()
        pressure.acquit()
        accuse_carried(t, vertical.judge_raw()[1], slip, sources.ahrs, dvl)
    elif accused in (Accused.PRESSURE_STEP, Accused.PRESSURE_DRIFT):
        pressure.accuse(SourceFault.STEP if accused is Accused.PRESSURE_STEP else SourceFault.DRIFT, t)
        dvl.acquit()
    else:
        pressure.accuse(SourceFault.UNDECIDED, t)
        if dvl.believed and pinged and t - pressure.memory.t_fault >= _MOMENT:
            (sources.ahrs if came_back(sources.ahrs, dvl, t) else dvl).accuse(SourceFault.UNDECIDED, t)
        if accused is Accused.SHALLOW_CARRIED and vertical.stands_in:
            vertical.trust()
