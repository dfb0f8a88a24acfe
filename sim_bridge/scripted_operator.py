"""The operator of a scenario: gives its orders in time, and steers the zigzag by the measured heading."""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware_py.marine import wrap
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import CENTRED_STICKS, NO_ORDER, Arming, Order, Setpoint, Sticks
from firmware_py.tick import Tick
from sim_bridge.completion import Completion
from sim_bridge.scenarios import Scenario, ScenarioOrder, Zigzag


class ScriptedOperator:
    """Gives the orders of a scenario (a `ports.Ground` by shape); its `completion` watches the flight.

    Args:
        scenario: whose orders.
        true_depth: as in `Completion`.
    """

    def __init__(self, scenario: Scenario, true_depth: Callable[[], float] | None = None) -> None:
        self.completion = Completion(scenario.completes, true_depth, scenario.watch, scenario.duration)
        self._orders = scenario.orders[::-1]
        self._remaining = len(scenario.orders)
        self._zigzag = _ZigzagRudder(scenario.zigzag) if scenario.zigzag else None
        self._sticks: Sticks | None = None

    def read(self, tick: Tick) -> Order:
        """Return the order of this tick: at most one order of the scenario, and the sticks as they are held."""
        t = tick.t
        scheduled = None
        if self._remaining and t >= self._orders[self._remaining - 1].t:
            self._remaining -= 1
            scheduled = self._orders[self._remaining]
            self._sticks = _moved(self._sticks, scheduled)
        if self._zigzag is not None:
            self._sticks = self._zigzag.steer(t, self._sticks)
        if scheduled is None and self._sticks is None:
            return NO_ORDER
        return Order(
            arming=Arming.KEEP if scheduled is None else scheduled.arming,
            mode=None if scheduled is None else scheduled.mode,
            setpoint=NO_ORDER.setpoint
            if scheduled is None
            else Setpoint(scheduled.depth, scheduled.heading, scheduled.speed),
            sticks=CENTRED_STICKS if self._sticks is None else self._sticks,
            t_sticks=-math.inf if self._sticks is None else t,
        )

    def write(self, cycle: Cycle) -> None:
        """Pass the cycle to `completion`, and its heading to the zigzag."""
        self.completion.see(cycle)
        if self._zigzag is not None:
            self._zigzag.observe(cycle.state.eta.psi)


class _ZigzagRudder:
    """The rudder of a zigzag; it does not assume to which side a rudder turns the vehicle."""

    def __init__(self, zigzag: Zigzag) -> None:
        self._zigzag = zigzag
        self._psi = math.nan
        self._base: float | None = None
        self._delta_r = zigzag.delta_r
        self._side = 0.0

    def observe(self, psi: float) -> None:
        self._psi = psi

    def steer(self, t: float, sticks: Sticks | None) -> Sticks | None:
        if t < self._zigzag.t or math.isnan(self._psi):
            return sticks
        if self._base is None:
            self._base = self._psi
        deviation = wrap(self._psi - self._base)
        if abs(deviation) >= self._zigzag.heading and math.copysign(1.0, deviation) != self._side:
            self._side = math.copysign(1.0, deviation)
            self._delta_r = -self._delta_r
        return (sticks or CENTRED_STICKS)._replace(delta_r=self._delta_r)


def _moved(sticks: Sticks | None, scheduled: ScenarioOrder) -> Sticks | None:
    """Return the sticks after an order; None as long as no order has moved them."""
    wanted = (scheduled.delta_s, scheduled.delta_r, scheduled.n)
    if all(math.isnan(value) for value in wanted):
        return sticks
    held = sticks or CENTRED_STICKS
    return Sticks(*(old if math.isnan(new) else new for old, new in zip(held, wanted, strict=True)))
