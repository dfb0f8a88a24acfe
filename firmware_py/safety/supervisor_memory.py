"""What the supervisor remembers from one tick to the next, and what it knows of the vehicle."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.event import Cause
from firmware_py.records.health import ALL_GOOD, ActuatorHealth, Candidate, SensorHealth
from firmware_py.records.order import Mode
from firmware_py.records.sensing import NodeBits
from firmware_py.safety.ascent_memory import AscentMemory
from firmware_py.safety.bottom_track import BottomTrack
from firmware_py.safety.enforcement import NOTHING_HELD, Held
from firmware_py.safety.progress import NO_PROGRESS, Progress
from firmware_py.safety.start import Start


class VehicleFin(NamedTuple):
    """What the supervisor knows of a fin: name; what its angle adds to delta_s and to delta_r; limit, rad."""

    name: str
    s: float = 0.0
    r: float = 0.0
    limit: float = 0.0

    @property
    def is_plane(self) -> bool:
        """Whether it acts on pitch; so does, as far as rules go, a bow plane that makes no moment."""
        return self.s != 0.0 or self.r == 0.0


class SupervisorMemory(NamedTuple):
    """What is remembered from tick to tick.

    Attributes:
        mode: the mode, and
        cause: why it was entered, and
        failsafe: whether a rule did so that nobody asked for.
        chosen: the mode that arming leads to.
        drop: whether the drop weight is released.
        returning: whether it was armed beyond the fence, to be steered back.
        held: what the rules have held.
        late: a bit per late tick of the last second.
        surfacing: for how many ticks the mode has been SURFACE.
        charge_known: whether the charge was known at any time.
        progress: of the way.
        sensors: their health, and
        candidates: the devices of the roles that have several, and
        actuators: theirs, and
        nodes: what is wrong with the nodes of the bus.
        ascent: how the vehicle comes up.
        start: whether it began under water, and how the earlier run ended.
        weight_gone: whether the drop weight was released in an earlier run.
        watched: whether it surfaced and disarmed itself, and nobody has it in hand since: it may sink again.
        brought_up: whether a failure brought it up when it surfaced last.
        depth: a good depth, m; where there is none, and no fix, no less than the last one.
        altitude_up: the altitude when a fix was last heard, or since then it began to be `watched`; or the first that
            was known after that, m.
        bottom: how it has come nearer.
        t_manual: when it was steered by hand last, s.
    """

    mode: Mode
    cause: Cause
    failsafe: bool
    chosen: Mode
    drop: bool
    returning: bool
    held: Held
    late: int
    surfacing: int
    charge_known: bool
    progress: Progress
    sensors: SensorHealth
    actuators: ActuatorHealth
    nodes: NodeBits = NodeBits()
    ascent: AscentMemory = AscentMemory()
    weight_gone: bool = False
    watched: bool = False
    brought_up: bool = False
    depth: float = 0.0
    altitude_up: float = math.nan
    start: Start = Start()
    candidates: tuple[Candidate, ...] = ()
    bottom: BottomTrack = BottomTrack()
    t_manual: float = -math.inf


def beginning(actuators: ActuatorHealth) -> SupervisorMemory:
    """Return the memory before the first tick, of a vehicle with these actuators, all sound."""
    return SupervisorMemory(
        mode=Mode.DISARMED,
        cause=Cause.NONE,
        failsafe=False,
        chosen=Mode.MANUAL,
        drop=False,
        returning=False,
        held=NOTHING_HELD,
        late=0,
        surfacing=0,
        charge_known=False,
        progress=NO_PROGRESS,
        sensors=ALL_GOOD,
        actuators=actuators,
    )
