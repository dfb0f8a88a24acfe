"""Whether the vehicle gets nearer to its waypoint, and what charge its way home needs; looked at once a second."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.fence import NOWHERE, Place
from firmware_py.records.order import Mode
from firmware_py.safety.safety_params import SafetyParams

_LEAST_WAY, _LEAST_CHARGE = 200.0, 0.02
"""Before so much way, m, is made with so much charge, nothing is known of the charge that a metre needs. Gauges that
report whole percents are wrong by half of it at the most."""
_STEP = 0.025
"""No charge is used so fast in a second: the gauge has stepped, or is another one."""
_LEGS = (Mode.MISSION, Mode.RETURN)
"""Modes that fly legs; in GUIDED a station watches the way."""


class Progress(NamedTuple):
    """What is remembered of the way.

    Attributes:
        target: the waypoint of the leg that is flown.
        mark: distance to it when it was last nearer by `leg_way`, m; NaN off a leg.
        since: for how long it has not been so, s.
        charge: the charge a second ago, in [0, 1]; NaN if it was not known.
        way: the way made through the water since the vehicle was armed, while the charge was known, m.
        used: the charge used on this way, without steps of the gauge.
        charge_home: the charge that the way home needs, `battery_min` included; NaN as long as too little is known of
            the charge that a metre needs.
    """

    target: Place = NOWHERE
    mark: float = math.nan
    since: float = 0.0
    charge: float = math.nan
    way: float = 0.0
    used: float = 0.0
    charge_home: float = math.nan

    def after_a_second(
        self,
        mode: Mode,
        reference: Reference,
        state: StateEstimate,
        charge: float,
        home: Iterable[Place],
        params: SafetyParams,
    ) -> Progress:
        """Return what is remembered a second later.

        Args:
            mode: the mode in force.
            reference: of the last tick.
            state: position, and speed through the water.
            charge: what is left, in [0, 1]; NaN if it is not known.
            home: the places that count as home; the nearest is meant.
            params: `leg_way`, `energy_margin` and `battery_min`.
        """
        if mode is Mode.DISARMED:
            return NO_PROGRESS
        x, y, u = state.eta.x, state.eta.y, state.through_water
        way, used, needed = self.way, self.used, math.nan
        fell = self.charge - charge
        if abs(fell) <= _STEP and math.isfinite(u):
            way, used = way + abs(u), used + fell
        if way > _LEAST_WAY and used > _LEAST_CHARGE:
            far = min(math.hypot(place.x - x, place.y - y) for place in home)
            needed = params.battery_min + used / way * far * params.energy_margin
        if mode not in _LEGS or math.isnan(reference.cross_track + reference.target.x):
            return Progress(NOWHERE, math.nan, 0.0, charge, way, used, needed)
        left = reference.target_distance
        if reference.target != self.target or math.isnan(self.mark) or left <= self.mark - params.leg_way:
            return Progress(reference.target, left, 0.0, charge, way, used, needed)
        return Progress(self.target, self.mark, self.since + 1.0, charge, way, used, needed)

    def leg_left(self, params: SafetyParams) -> float:
        """Return the distance to a waypoint that does not come nearer, m; NaN if it does."""
        return self.mark if self.since > params.leg_time else math.nan


NO_PROGRESS = Progress()
