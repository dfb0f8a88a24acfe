"""The gate: the last word before the actuators. It knows no law, and needs none to be right.

Whatever it is given, it lets through finite angles within the travel and the rate of each fin, and a propeller speed
within its own; centred and stopped while disarmed, and going there when the AHRS is silent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.params import param
from firmware_py.records.command import Applied, FinCommand, ModeState
from firmware_py.records.order import Mode
from firmware_py.records.sensing import SensorFrame
from firmware_py.schedule import Tick

_SLACK = 1e-6
"""Times that went through another unit may be rounded past now, s."""


@dataclass(frozen=True)
class GateParams:
    """What is not a property of the fins."""

    n_rate: float = param(500.0, unit="rpm/s", low=1.0, high=1e5, doc="Slew of the propeller's speed.", mav="N_RATE")
    ahrs_timeout: float = param(
        0.5,
        unit="s",
        low=0.02,
        high=5.0,
        doc="Attitude silent for so long: fins go to centre, the propeller stops.",
        mav="AHRS_T",
    )
    hold: int = param(
        5,
        low=0,
        high=1000,
        doc="Ticks for which the last command is kept when a command is not finite; then centre.",
        mav="HOLD",
    )


class GateMemory(NamedTuple):
    """For how many ticks the command has not been finite, and when the last good attitude was valid, s."""

    broken: int
    t_attitude: float


class Gate:
    """Limits one command per tick.

    A command is taken or left whole: when one number of it is not finite (or a fin is missing), what made the others is
    not to be trusted either. The last one is held for a few ticks, as a glitch would have it, then all goes to centre.
    """

    def __init__(
        self, params: GateParams, delta_max: tuple[float, ...], rate_max: tuple[float, ...], n_max: float
    ) -> None:
        """Limits per fin: travel (rad) and rate (rad/s), both > 0; propeller speed n_max (rev/s).

        Raises:
            ValueError: unless there are as many rates as travels, and all of them are positive and finite.
        """
        if len(delta_max) != len(rate_max):
            raise ValueError(f"the gate has {len(delta_max)} fin travels and {len(rate_max)} fin rates; need as many")
        if not all(0.0 < limit < math.inf for limit in (*delta_max, *rate_max, n_max)):
            raise ValueError(f"limits of the gate must be > 0 and finite: {delta_max}, {rate_max}, {n_max}")
        self._params = params
        self._limits = tuple(zip(delta_max, rate_max, strict=True))
        self._n_limit = (n_max, params.n_rate)
        self._centre = (0.0,) * len(delta_max)
        self._memory = GateMemory(0, -math.inf)

    def limit(self, tick: Tick, mode: ModeState, frame: SensorFrame, fins: FinCommand, previous: Applied) -> Applied:
        """What goes to the actuators in this tick, from what is asked and what went there one tick ago."""
        dt, asked, n = tick.dt, fins.fins, fins.n
        finite = len(asked) == len(self._centre) and math.isfinite(n) and all(map(math.isfinite, asked))
        broken = 0 if finite else self._memory.broken + 1
        t_attitude = self._heard(tick, frame)
        self._memory = GateMemory(broken, t_attitude)

        if mode.mode == Mode.DISARMED:
            return Applied(self._centre, 0.0, False, limited=asked != self._centre or n != 0.0)

        last = previous.fins if len(previous.fins) == len(self._centre) else self._centre
        n_last = previous.n
        target, n_target = asked, n
        if tick.t - t_attitude > self._params.ahrs_timeout or broken > self._params.hold:
            target, n_target = self._centre, 0.0
        elif broken:
            target, n_target = last, n_last
        passed = tuple([_towards(x, was, limit, dt) for x, was, limit in zip(target, last, self._limits, strict=True)])
        n_passed = _towards(n_target, n_last, self._n_limit, dt)
        return Applied(passed, n_passed, True, limited=passed != asked or n_passed != n)

    def freeze(self) -> GateMemory:
        """All that is remembered."""
        return self._memory

    def thaw(self, memory: GateMemory) -> None:
        """Goes on from there."""
        self._memory = memory

    def _heard(self, tick: Tick, frame: SensorFrame) -> float:
        """When the last attitude was valid that is a number, vouched for and not from the future, s."""
        ahrs, since = frame.ahrs, self._memory.t_attitude
        if ahrs.fresh and ahrs.ok and since < ahrs.t_valid <= tick.t + _SLACK and math.isfinite(sum(ahrs.value)):
            return ahrs.t_valid
        return since


def _towards(target: float, last: float, limit: tuple[float, float], dt: float) -> float:
    """From `last` towards `target`, by at most rate x dt and never beyond the amplitude; limit is (amplitude, rate)."""
    amplitude, rate = limit
    last = min(max(last, -amplitude), amplitude) if math.isfinite(last) else 0.0
    target = min(max(target, -amplitude), amplitude) if math.isfinite(target) else 0.0
    return min(max(target, last - rate * dt), last + rate * dt)
