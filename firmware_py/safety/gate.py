"""The gate: the last limits before the actuators. It knows no law and relies on none.

Whatever the command, the output is finite and within the angle and rate limit of each fin and of the propeller. While
disarmed fins are centred and the propeller is stopped; when the AHRS is silent they move there at their rate limits,
but in SURFACE: the vehicle comes up without attitude too. The release of the drop weight passes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.params import param
from firmware_py.records.command import Applied, FinCommand, ModeState
from firmware_py.records.order import Mode
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Tick

_TIME_ROUNDING = 1e-6
"""A time of validity may be rounded past the present by so much, s."""


@dataclass(frozen=True)
class GateParams:
    """Limits that are not properties of a fin."""

    n_rate: float = param(
        500.0,
        unit="rpm/s",
        low=1.0,
        high=1e5,
        doc="Rate limit of the propeller speed. Lower: gentler on shaft and battery, slower to stop.",
        mav="N_RATE",
    )
    ahrs_timeout: float = param(
        0.5,
        unit="s",
        low=0.02,
        high=5.0,
        doc="Without attitude for longer than this, fins go to centre and the propeller stops; not in SURFACE.",
        mav="AHRS_T",
    )
    hold_ticks: int = param(
        5,
        low=0,
        high=1000,
        doc="Ticks for which the last command is held while commands are not finite; then fins go to centre.",
        mav="HOLD",
    )


class GateMemory(NamedTuple):
    """Memory of the gate.

    Attributes:
        invalid_ticks: ticks in a row with a command that was not finite.
        t_attitude: time of validity of the last good attitude, s.
    """

    invalid_ticks: int
    t_attitude: float


class Gate:
    """Limits one command per tick.

    A command is rejected as a whole: when one number of it is not finite, or a fin is missing, the others are not
    trusted either. The last output is then held for `hold_ticks`, in case it is a glitch; after that fins go to centre
    and the propeller stops.
    """

    def __init__(
        self, params: GateParams, delta_max: tuple[float, ...], rate_max: tuple[float, ...], n_max: float
    ) -> None:
        """Set the limits of each fin: angle (rad) and rate (rad/s), both > 0; propeller speed n_max (rev/s).

        Raises:
            ValueError: not as many rates as angles, or a limit that is not positive and finite.
        """
        if len(delta_max) != len(rate_max):
            raise ValueError(
                f"the gate has {len(delta_max)} fin angle limits and {len(rate_max)} fin rate limits; need as many"
            )
        if not all(0.0 < limit < math.inf for limit in (*delta_max, *rate_max, n_max)):
            raise ValueError(f"limits of the gate must be > 0 and finite: {delta_max}, {rate_max}, {n_max}")
        self._params = params
        self._limits = tuple(zip(delta_max, rate_max, strict=True))
        self._n_limit = (n_max, params.n_rate)
        self._centre = (0.0,) * len(delta_max)
        self._memory = GateMemory(0, -math.inf)

    def limit(self, tick: Tick, mode: ModeState, frame: SensorFrame, fins: FinCommand, previous: Applied) -> Applied:
        """Return what the actuators get in this tick.

        Args:
            tick: this tick.
            mode: the supervisor's mode; DISARMED centres the fins and stops the propeller.
            frame: its AHRS tells whether attitude is still received, which SURFACE does not need.
            fins: the command: one angle per fin, rad, and the propeller speed, rev/s.
            previous: what the actuators got one tick ago; rates are limited from there.
        """
        dt, command, n = tick.dt, fins.fins, fins.n
        finite = len(command) == len(self._centre) and math.isfinite(n) and all(map(math.isfinite, command))
        invalid_ticks = 0 if finite else self._memory.invalid_ticks + 1
        t_attitude = self._latest_attitude(tick, frame)
        self._memory = GateMemory(invalid_ticks, t_attitude)

        if mode.mode == Mode.DISARMED:
            return Applied(self._centre, 0.0, False, limited=command != self._centre or n != 0.0, drop=mode.drop)

        last = previous.fins if len(previous.fins) == len(self._centre) else self._centre
        n_last = previous.n
        target, n_target = command, n
        blind = tick.t - t_attitude > self._params.ahrs_timeout and mode.mode != Mode.SURFACE
        if blind or invalid_ticks > self._params.hold_ticks:
            target, n_target = self._centre, 0.0
        elif invalid_ticks:
            target, n_target = last, n_last
        passed = tuple([_towards(x, was, limit, dt) for x, was, limit in zip(target, last, self._limits, strict=True)])
        n_passed = _towards(n_target, n_last, self._n_limit, dt)
        return Applied(passed, n_passed, True, limited=passed != command or n_passed != n, drop=mode.drop)

    def freeze(self) -> GateMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: GateMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _latest_attitude(self, tick: Tick, frame: SensorFrame) -> float:
        """Return the time of validity, s, of the last attitude that is finite, marked ok, and not from the future."""
        ahrs, since = frame.ahrs, self._memory.t_attitude
        if (
            ahrs.fresh
            and ahrs.ok
            and since < ahrs.t_valid <= tick.t + _TIME_ROUNDING
            and math.isfinite(sum(ahrs.value))
        ):
            return ahrs.t_valid
        return since


def _towards(target: float, last: float, limit: tuple[float, float], dt: float) -> float:
    """Return `last` moved towards `target` by at most rate dt, within the amplitude; `limit` is (amplitude, rate)."""
    amplitude, rate = limit
    last = min(max(last, -amplitude), amplitude) if math.isfinite(last) else 0.0
    target = min(max(target, -amplitude), amplitude) if math.isfinite(target) else 0.0
    return min(max(target, last - rate * dt), last + rate * dt)
