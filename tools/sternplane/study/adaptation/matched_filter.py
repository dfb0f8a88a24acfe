"""The matched filter that damage is measured against: it knows the truth but for the fault.

It is the vehicle's own test with all that it has to find out given: the true coefficients, still water, and the moment
from which a fault can be.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from firmware_py.records.command import Applied
from firmware_py.records.cycle import Cycle
from firmware_py.safety.actuator_watch import ActuatorParams, ActuatorWatch
from firmware_py.safety.actuators.share_watch import Change, ShareWatch
from firmware_py.vehicle.linear_models import diving_coefficients, steering_coefficients
from firmware_py.vehicle.vehicle import Vehicle

_STILL = (0.1,)
"""The one filter, for the quietest water."""
_N_RATE = 8.0
"""The propeller is not judged, rev/s^2."""


class _Matched(ShareWatch):
    """A test that takes no evidence before `open`, and knows that there are no gusts."""

    open = False
    gust_time = 0.0

    def __init__(self, evidence: float, eddies: float, dt: float, members: Sequence[float] = _STILL) -> None:
        super().__init__(evidence, eddies, dt, members)

    def update(
        self, rate: float, damping: float, hull: float, fins: float, steady: bool = True, heals: bool = True
    ) -> bool:
        found = super().update(rate, damping, hull, fins, steady, heals)
        if not _Matched.open:
            members = [m._replace(changes=(Change(m.follower, 0.0),) * len(m.changes)) for m in self._memory.members]
            self._memory = self._memory._replace(left=0, members=tuple(members))
        return found


class MatchedFilter:
    """Judges the fins of one axis from `onset`, s, on; the vehicle is the true one."""

    def __init__(self, params: ActuatorParams, vehicle: Vehicle, fin: int, onset: float) -> None:
        self._watch, self._fin, self._onset = ActuatorWatch(params, vehicle, _N_RATE, _Matched), fin, onset
        self._diving, self._steering = tuple(diving_coefficients(vehicle)), tuple(steering_coefficients(vehicle))
        self._applied: Applied | None = None

    def update(self, cycle: Cycle) -> bool:
        """Return whether the fin's axis has lost something, after a cycle."""
        _Matched.open = cycle.tick.t >= self._onset
        before, self._applied = self._applied, cycle.applied
        if before is None:
            return False
        known = dataclasses.replace(
            cycle.adopted, caution=0.0, held_diving=self._diving, held_steering=self._steering, halved=(False, False)
        )
        health = self._watch.update(cycle.tick, cycle.frame, before, cycle.state, known)
        return health.left[self._fin].effect < 1.0
