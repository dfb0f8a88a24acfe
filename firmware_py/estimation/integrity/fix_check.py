"""Fixes: against each other, against the depth, and against the way that the vehicle makes."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.estimation.integrity.sources import Sources
from firmware_py.estimation.integrity.vertical_check import VerticalCheck
from firmware_py.estimation.integrity.way_arbitration import Wrong
from firmware_py.estimation.integrity.way_check import WayCheck
from firmware_py.marine import NULL_ISLAND, Origin, geodetic_to_local
from firmware_py.records.health import SourceFault
from firmware_py.records.sensing import Fix, Heard

_RECENT = 5.0
"""After longer than this, s, the first fix has to be confirmed."""
_SPEED = 3.0
"""Faster than this no vehicle is carried at the surface, m/s."""
_STEADY = 5
"""So many fixes in a row that agree before one jumps make the jump a step."""
_DRIFTS, _DRIFTS_BLIND, _DRIFTS_UNKNOWN = 0.15, 0.4, 2.0
"""How far a depth that is carried on without pressure may be off after a second, m: with DVL (a pitch that is 3 deg off
under way, three times navigation's sigma), without, and where nothing tells of the motion."""
_CARRIED_AGE = 0.3
"""What was carried on last longer ago, s, is not carried on."""


@dataclass(slots=True)
class FixCheckMemory:
    """The last fix, used or not, the last one that was used, and how many agreed in a row.

    `impossible` is whether the last one was heard from where none can be, or goes on from such a one without a silence;
    `drifted` how far the depth may be off since the last good pressure, m, as seen at `t_drifted`, s, when it had been
    carried on without DVL for `blind`, s.
    """

    t: float = -math.inf
    last: Origin = NULL_ISLAND
    t_used: float = -math.inf
    used: Origin = NULL_ISLAND
    agreed: int = 0
    impossible: bool = False
    drifted: float = 0.0
    t_drifted: float = 0.0
    blind: float = 0.0


class FixCheck:
    """Checks fixes against each other and against the depth.

    No fix is heard under water. A receiver that was heard there lies, and one that lies says nothing of the surface: it
    stays impossible, for as long as it goes on without a silence, until a depth says that the vehicle came up: a good
    pressure, or, when that is lost, what is carried on. Against other receivers what is carried on counts for no more
    than it is surely deep.
    """

    def __init__(self, sigmas: float, deepest: float, surface: float) -> None:
        """Take sigmas, and depths, m: where no fix can be heard, and above which the vehicle is at the surface."""
        self._sigmas, self._deepest, self._surface = sigmas, deepest, surface
        self.memory = FixCheckMemory()

    def hear(self, heard: Heard[Fix], t: float, sources: Sources, vertical: VerticalCheck, way: WayCheck) -> float:
        """Take a fix at t, s; return since when those before it were wrong, s, if `way` has just found it, else NaN."""
        watch, silent, dvl = sources.fix, t - self.memory.t > _RECENT, sources.dvl.health
        depth = vertical.depth if sources.pressure.health.believed else math.nan
        if not (watch.hear(heard, t) and self.check(heard, t, depth, vertical.depth, watch)):
            return math.nan
        watch.take(heard)
        if watch.health.believed:  # one that stands still, or walks off, may be below
            vertical.float_up()
        wrong, since = way.hear(heard.value, t, silent, dvl.believed or dvl.fault is SourceFault.CONTRADICTED)
        if wrong is Wrong.DVL:
            sources.dvl.accuse(SourceFault.CONTRADICTED, t)
        elif wrong is Wrong.FIXES:
            watch.accuse(SourceFault.CONTRADICTED, t)
        return since

    def drift(self, t: float, pressure: bool, vertical: VerticalCheck) -> bool:
        """Take note that it is t, s, with a good pressure or without; return whether `vertical` has the vehicle deep.

        There a receiver may be silent.
        """
        memory, carried = self.memory, vertical.memory
        rate = _DRIFTS if t - carried.t_carried <= _CARRIED_AGE else _DRIFTS_UNKNOWN
        memory.drifted += rate * (t - memory.t_drifted) + _DRIFTS_BLIND * (carried.blind - memory.blind)
        memory.t_drifted, memory.blind = t, carried.blind
        if pressure:
            memory.drifted = 0.0
        return vertical.depth > self._deepest

    def _is_impossible(self, depth: float, carried: float, silence: float) -> bool:
        """Return whether no fix can be heard where the vehicle is; see `check`."""
        memory = self.memory
        if depth == depth:
            memory.impossible = depth > self._deepest
        elif silence > _RECENT or carried < self._surface:
            memory.impossible = False
        return memory.impossible or carried - memory.drifted > self._deepest

    def check(self, heard: Heard[Fix], t: float, depth: float, carried: float, watch: SourceWatch) -> bool:
        """Return whether a fix may be used.

        Args:
            heard: it.
            t: now, s.
            depth: by a pressure that is believed, m, else NaN.
            carried: depth as it is carried on, m; NaN if none was ever known.
            watch: of the receiver.
        """
        memory = self.memory
        here, before = Origin(heard.value.latitude, heard.value.longitude), memory.t
        agrees = t - before <= _RECENT and self._near(heard.value, t - before, memory.last)
        memory.t, memory.last = t, here
        if self._is_impossible(depth, carried, t - before):
            watch.accuse(SourceFault.IMPOSSIBLE, t)
            return False
        if t - before > _RECENT:
            memory.agreed = 0
        if memory.agreed:
            near = self._near(heard.value, t - memory.t_used, memory.used)
            if not near and (memory.agreed >= _STEADY or not agrees):
                if watch.refuse(t) > 2:
                    watch.accuse(SourceFault.STEP, t)
                return False
            memory.agreed = memory.agreed + 1 if near else 1
        elif agrees:
            memory.agreed = 1
        else:
            watch.hold()
            return False
        memory.t_used, memory.used = t, here
        return True

    def _near(self, fix: Fix, age: float, before: Origin) -> bool:
        way = math.hypot(*geodetic_to_local(before, fix.latitude, fix.longitude))
        return way <= self._sigmas * math.sqrt(2.0) * fix.std + _SPEED * age

    def freeze(self) -> FixCheckMemory:
        """Return the whole memory."""
        return copy.copy(self.memory)

    def thaw(self, memory: FixCheckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)
