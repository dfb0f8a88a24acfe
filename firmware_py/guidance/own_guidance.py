"""A guidance of one's own: it chooses depth, heading and speed of a mission, in place of the legs between waypoints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from firmware_py.guidance.guidance import Guidance
from firmware_py.guidance.guidance_memory import GuidanceMemory
from firmware_py.guidance.manoeuvre import Excitation
from firmware_py.marine import clip, wrap
from firmware_py.own_part import Guard, GuardMemory, OwnClass, OwnPart
from firmware_py.records.command import ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.mission import Manoeuvre
from firmware_py.records.order import Mode, Order, Setpoint
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Vehicle


class GuidanceLaw(OwnPart):
    """A guidance law. It is asked in MISSION, but for the mission's learning manoeuvres, and while the state is finite.

    HOLD, LOITER, GUIDED, RETURN and SURFACE are flown by the built-in guidance. What it wants is held to the depth
    limit and the greatest speed, and smoothed as every setpoint is.

    Attributes:
        finished: whether the mission is done; set it to end a mission before its last waypoint is passed.
    """

    finished: bool = False

    def update(self, tick: Tick, proposed: Setpoint, state: StateEstimate) -> Sequence[float]:
        """Return (z_d, psi_d, u_d): depth (m, down), heading (rad), speed (m/s).

        `proposed` is what the built-in guidance would fly: return it where nothing else is wanted.
        """
        raise NotImplementedError


class OwnGuidanceMemory(NamedTuple):
    """What both remember."""

    built_in: GuidanceMemory
    own: GuardMemory
    ended: bool


class OwnGuidance(Guidance):
    """The built-in guidance, which asks one's own in a mission; see `Guidance`."""

    def __init__(self, own: OwnClass[GuidanceLaw], vehicle: Vehicle, *args: Any) -> None:
        """Make it; `args` are those of `Guidance`."""
        super().__init__(*args)
        self._own = Guard("guidance", own, vehicle)
        self._deepest: float = args[2]
        self._tick = Tick(0, 1)
        self._ended = False

    @property
    def finished(self) -> bool:
        """Whether the mission is flown, or one's own guidance says so."""
        return (self._ended and self._mode is Mode.MISSION) or super().finished

    def update(self, tick: Tick, mode: ModeState, order: Order, state: StateEstimate) -> Reference:
        """Return this tick's reference."""
        self._tick = tick
        if mode.mode is Mode.DISARMED:
            self._own.rest()
            self._ended = False
        reference = super().update(tick, mode, order, state)
        self.events += self._own.told()
        return reference

    def _proceed(self, entered: bool, u_d: float, state: StateEstimate, dt: float) -> tuple[float, Excitation]:
        across, dither = super()._proceed(entered, u_d, state, dt)
        if self._mode is Mode.MISSION and not isinstance(self._route.current, Manoeuvre):
            wanted = self._own.ask(self._tick.k, lambda own: self._asked(own, state))
            self._wanted, self._ended = (self._wanted, False) if wanted is None else wanted
        return across, dither

    def _asked(self, own: GuidanceLaw, state: StateEstimate) -> tuple[Setpoint, bool]:
        """Return what one's own guidance wants, looked at and held to the limits, and whether it is done."""
        z_d, psi_d, u_d = map(float, tuple(own.update(self._tick, self._wanted, state))[:3])
        if not math.isfinite(z_d + psi_d + u_d):
            raise ValueError(f"not finite: {z_d}, {psi_d}, {u_d}")
        setpoint = Setpoint(clip(z_d, 0.0, self._deepest), wrap(psi_d), clip(u_d, 0.0, self._turning.speed_max))
        return setpoint, bool(own.finished)

    def freeze(self) -> Any:
        """Return the whole memory."""
        return OwnGuidanceMemory(super().freeze(), self._own.freeze(), self._ended)

    def thaw(self, memory: Any) -> None:
        """Restore the memory that `freeze` returned."""
        super().thaw(memory.built_in)
        self._own.thaw(memory.own)
        self._ended = memory.ended
