"""What the watch of the hull's motion remembers."""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.records.health import ActuatorFault
from firmware_py.safety.actuators.cross_flow import CrossMemory
from firmware_py.safety.actuators.fin_angles import AnglesMemory
from firmware_py.safety.actuators.hull_response import AxisMemory
from firmware_py.safety.actuators.share_watch import ShareMemory
from firmware_py.safety.actuators.single_fin import SingleMemory
from firmware_py.safety.actuators.stuck_watch import StuckMemory

Values = tuple[float, ...]


class CrossedMemory(NamedTuple):
    """What is remembered of single fins.

    Attributes:
        single: the hypotheses.
        found: what was found, by fin.
        trial: the fin that rests, for it may be lost; -1: none.
        top: the greatest evidence for a loss, nats.
    """

    single: SingleMemory
    found: tuple[ActuatorFault, ...]
    trial: int
    top: float


class HullMemory(NamedTuple):
    """What is remembered.

    Attributes:
        references: the coefficients that each axis is judged by; empty is vehicle.toml.
        axes: of both axes.
        sums: of their gyros, with the numbers of samples.
        speeds: to which their fins were held in the last step, m/s; NaN if it was left out.
        angles: of the fins, by axis.
        left: of what is left of the fins' effect.
        cross: of the velocities across the hull.
        stuck: of fins that stay where they are, and do not report it.
        t_away: when the AHRS was away last, s.
        crossed: of what judges single fins, where they act on both axes.
    """

    references: tuple[Values, ...]
    axes: tuple[AxisMemory, ...]
    sums: tuple[tuple[float, int], ...]
    speeds: tuple[float, ...]
    angles: tuple[AnglesMemory, ...]
    left: tuple[ShareMemory, ...]
    cross: CrossMemory
    stuck: tuple[StuckMemory, ...]
    t_away: float
    crossed: CrossedMemory | None = None
