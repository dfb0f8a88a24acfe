"""Whoever gives the orders of a scenario: a script, and for the zigzag an eye on the compass."""

from __future__ import annotations

import math

from firmware_py.marine import wrap
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import CENTRED_STICKS, NO_ORDER, Arming, Order, Setpoint, Sticks
from firmware_py.schedule import Tick
from sim_bridge.completion import Completion
from sim_bridge.scenarios import Cue, Scenario, Zigzag


class ScriptedOperator:
    """Plays the orders of a scenario; a `ports.Ground` by shape. Its `referee` sees how the flight goes."""

    def __init__(self, scenario: Scenario) -> None:
        self.referee = Completion(scenario.completes)
        self._cues = scenario.orders[::-1]
        self._ahead = len(scenario.orders)
        self._zigzag = _Helmsman(scenario.zigzag) if scenario.zigzag else None
        self._sticks: Sticks | None = None

    def read(self, tick: Tick) -> Order:
        """The order of this tick: at most one cue, and the sticks as they are held."""
        t = tick.t
        cue = None
        if self._ahead and t >= self._cues[self._ahead - 1].t:
            self._ahead -= 1
            cue = self._cues[self._ahead]
            self._sticks = _moved(self._sticks, cue)
        if self._zigzag is not None:
            self._sticks = self._zigzag.steer(t, self._sticks)
        if cue is None and self._sticks is None:
            return NO_ORDER
        return Order(
            arming=Arming.KEEP if cue is None else cue.arming,
            mode=None if cue is None else cue.mode,
            setpoint=NO_ORDER.setpoint if cue is None else Setpoint(cue.depth, cue.heading, cue.speed),
            sticks=CENTRED_STICKS if self._sticks is None else self._sticks,
            t_sticks=-math.inf if self._sticks is None else t,
        )

    def write(self, cycle: Cycle) -> None:
        """Watches the heading, and lets the referee watch the rest."""
        self.referee.see(cycle)
        if self._zigzag is not None:
            self._zigzag.look(cycle.state.eta.psi)


class _Helmsman:
    """Steers a zigzag; knows nothing of which way a rudder turns the boat."""

    def __init__(self, zigzag: Zigzag) -> None:
        self._zigzag = zigzag
        self._psi = math.nan
        self._base: float | None = None
        self._delta_r = zigzag.delta_r
        self._side = 0.0

    def look(self, psi: float) -> None:
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


def _moved(sticks: Sticks | None, cue: Cue) -> Sticks | None:
    """The sticks after a cue; None as long as nobody touched them."""
    wanted = (cue.delta_s, cue.delta_r, cue.n)
    if all(math.isnan(value) for value in wanted):
        return sticks
    held = sticks or CENTRED_STICKS
    return Sticks(*(old if math.isnan(new) else new for old, new in zip(held, wanted, strict=True)))
