"""What tells that the vehicle is up: a fix, depth, altitude, the height made; and by when something should have."""

from __future__ import annotations

import math

from firmware_py.marine import clip
from firmware_py.records.command import AscentStage
from firmware_py.safety.ascent_memory import AscentMemory
from firmware_py.safety.ascent_view import AscentView
from firmware_py.safety.safety_params import SafetyParams

_STEADY = 0.05
"""Slower than this, m/s, it neither rises nor sinks."""
_MARGIN = 1.5
"""A climb may take so many times what the desired pitch and speed make of it."""
_WAITS = 2.0
"""Near the surface and not told for so many times `wait_time`: the weight goes."""
_HELD_DOWN = 10.0
"""Where nothing is gained for so long, s, water flows down as fast as the vehicle climbs by `level_pitch`."""
SLOW = 0.5
"""Slower through the water than this, m/s, a vehicle glides, or drifts."""
_DIPS = 10.0
"""What lies at the surface dips under it for no longer than this, s."""


class SurfaceWitness:
    """Judges by what `Ascent` remembers; `speed` is that of coming up, m/s."""

    def __init__(self, params: SafetyParams, speed: float) -> None:
        self._params = params.ascent
        self._surface, self._submerged = params.surface_depth, params.submerged_depth
        self._deepest = params.depth_max + params.ascent.limit_margin
        self._climb_rate = speed * math.sin(params.ascent.pitch)

    def is_surfaced(self, m: AscentMemory, t: float, depth_ok: bool, z: float, fix: bool, altitude: float) -> bool:
        """Return whether a fix and a second witness, or without a receiver two witnesses, tell of the surface.

        Time without change of depth is no witness: a neutral hull rests anywhere. A fix is not believed against a good
        pressure that says deep, unless it is held for `fix_time`, and either the vehicle would not count as submerged
        at that depth, or it is at rest without its weight and does not rise: then it floats.

        Args:
            m: what `Ascent.update` returned last.
            t: now, s.
            depth_ok: whether the pressure is good.
            z: the depth, m, without pressure by dead reckoning.
            fix: whether a fix is heard.
            altitude: above the bottom, m; NaN if unknown.
        """
        shallow, p = z < self._surface, self._params
        held = fix and t - m.t_fix >= p.fix_time
        rests = m.drop and m.stage is AscentStage.STOPPED and t - m.since >= p.fix_time and abs(m.z_dot) <= _STEADY
        if depth_ok and (not shallow or fix):
            return shallow or (held and (z < self._submerged or rests))
        if fix:
            return shallow or self._risen(m, altitude) or (held and rests)
        return not p.fix_needed and depth_ok and self._made(m, altitude)

    def is_overdue(self, m: AscentMemory, v: AscentView) -> bool:
        """Return whether it should have been told to be at the surface, and two other witnesses do not put it there."""
        late = v.t - m.begun > self._params.up_time + self.climb_time(m)
        late = late or v.t - m.t_near > _WAITS * self._params.wait_time
        return late and not self._floats(m, v)

    def is_below(self, m: AscentMemory, v: AscentView) -> bool:
        """Return whether, without a good pressure, both altitude and the depth by dead reckoning tell of the deep."""
        reckoned = v.attitude_ok and v.speed_ok and v.z > self._submerged
        return reckoned and math.isfinite(v.altitude) and not self._risen(m, v.altitude)

    def is_held_down(self, m: AscentMemory, v: AscentView) -> bool:
        """Return whether a vehicle near the surface gains nothing, and may pitch up: its bow is in the water."""
        return v.depth_ok and v.z > self._submerged and v.t - m.t_best > _HELD_DOWN

    def sinks_unseen(self, m: AscentMemory, v: AscentView) -> bool:
        """Return whether the bottom comes nearer to one with little way, whatever depth says: no slope does so."""
        slow = v.speed_ok and v.through <= SLOW and not v.fix
        return slow and m.most - v.altitude > self._params.deeper and not self._floats(m, v)

    def climb_time(self, m: AscentMemory) -> float:
        """Return what a climb takes at most, s; a depth beyond the limit is one that ran away."""
        return _MARGIN * clip(m.z_begun, 0.0, self._deepest) / self._climb_rate

    def _floats(self, m: AscentMemory, v: AscentView) -> bool:
        """Return whether a good pressure says surface, now and then at least, and the height made says so too."""
        return v.depth_ok and v.t - m.t_up <= _DIPS and self._made(m, v.altitude)

    def _risen(self, m: AscentMemory, altitude: float) -> bool:
        """Return whether the altitude tells that the vehicle came up, or it was there from the start."""
        return m.z_begun < self._surface or altitude - m.altitude_begun >= 0.9 * m.z_begun - self._surface

    def _made(self, m: AscentMemory, altitude: float) -> bool:
        """Return whether the altitude or dead reckoning does."""
        return self._risen(m, altitude) or m.climbed >= 0.8 * m.z_begun - self._surface
