"""A law of depth and heading of one's own, in place of sliding mode and PID."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.own_part import Guard, OwnPart
from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.tick import Tick


class Steering(NamedTuple):
    """What a law of one's own says.

    Attributes:
        delta_s: stern planes, rad, positive bow down.
        delta_r: rudder, rad, positive to port.
        n: propeller, rev/s; None: as the built-in speed control has it.
        sigma_z: sliding variable of depth, m, for the log; 0 if the law has none.
        sigma_psi: that of heading, rad.
    """

    delta_s: float
    delta_r: float
    n: float | None = None
    sigma_z: float = 0.0
    sigma_psi: float = 0.0


class Law(OwnPart):
    """A law of depth and heading. It steers in every mode but MANUAL and SURFACE, while state and reference are finite.

    Its angles are limited, reduced at low speed and given the excitation of learning manoeuvres as those of the
    built-in laws are. SURFACE is always flown by the built-in laws.
    """

    def update(self, tick: Tick, reference: Reference, state: StateEstimate) -> Steering | Sequence[float]:
        """Return the steering of this tick, or (delta_s, delta_r) alone; rad.

        Args:
            tick: now; `tick.t` s, `tick.dt` s.
            reference: what to follow: z_d (m), psi_d (rad), u_d (m/s) and their derivatives.
            state: where the vehicle is: eta (m, rad; NED, z down), nu (m/s, rad/s; over the ground), what is learned.
        """
        raise NotImplementedError


def steering(guard: Guard[Law], tick: Tick, reference: Reference, state: StateEstimate) -> Steering | None:
    """Return what a law of one's own says, looked at; None if it has failed."""

    def ask(law: Law) -> Steering:
        answer = Steering(*law.update(tick, reference, state))
        values = [float(value) for value in answer if value is not None]
        if not math.isfinite(sum(values)):
            raise ValueError(f"not finite: {answer}")
        n = None if answer.n is None else float(answer.n)
        return Steering(float(answer[0]), float(answer[1]), n, float(answer[3]), float(answer[4]))

    return guard.ask(tick.k, ask)
