"""Pressure against the depth that DVL, pitch and speed carry on, with the bottom as a third witness.

The vertical velocity, by DVL and AHRS, or without DVL by pitch and the speed that the propeller makes likely, is
integrated to a carried depth D. The residual r = depth - D is constant while all is well, whatever it is. Its change
over 5, 10 and 40 s, without DVL 5, 20 and 60 s, is compared with thresholds; a single reading with the residual's
running mean.

Less deep than `surface` by both, r begins anew with every reading, for the hull leaves the water there. But D counts on
from where the pressure rose with it last: where it has come below `surface`, and the pressure has not, one is wrong.

The change of r says that pressure or D is wrong; `depth_arbitration` says which. Until it can, the deeper one holds.
So it does again where a pressure that the bottom cleared has gone too far from DVL and pitch (`parting`).
"""

from __future__ import annotations

import copy
import math

from firmware_py.estimation.integrity import near_surface
from firmware_py.estimation.integrity.depth_arbitration import PITCH_HOLDS, Accused, Entry, arbitrate, dvl_or_pitch
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.parting import TOGETHER
from firmware_py.estimation.integrity.vertical_memory import VerticalCheckMemory
from firmware_py.estimation.integrity.wander import look, wander_5s, wandered
from firmware_py.records.health import SourceFault

_MEAN = 0.3
"""Share of a reading in the running mean of the residual."""
_STEP = 0.25
"""Interval of the history, s."""
_LENGTH = 240
"""Entries of the history: 60 s."""
_WINDOWS = (20, 40, 160)
"""Entries over which pressure and DVL are compared: 5, 10, 40 s; without DVL the first, and those of `wander`."""
_LOOK = 5.0
"""How strong eddies are is looked at so often, s."""
_HELD = 3
"""So many readings in a row must show a change."""
_REAL = 5
"""So many outliers in a row are a step."""
_RATE, _RATE_UNKNOWN = 1.0, 2.5
"""How wrong a depth may become in a gap between readings, m/s: carried on, and not known."""
_CARRIED_AGE = 0.3
"""When nothing is known to carry the depth on for longer than this, s, pressure is not judged by it."""
_MAY_SPEAK = (*PITCH_HOLDS, SourceFault.UNDECIDED)
"""Under any other suspicion a pitch does not speak against the bottom."""
_GAP = 30.0
"""After a longer silence of the pressure, s, it is taken as it comes."""
_AGED, _AGED_BLIND, _AGED_MOST = 0.02, 0.4, 3.0
"""How far a carried depth may be off: growth with DVL and without, m/s, and the most, m."""
_BACK = 0.5
"""A pressure that is suspect must come back from the farthest that it was off, to less than this share of it."""
_PING_GAP = 1.0
"""Without a ping for longer, s, what the DVL alone carries begins anew."""


class VerticalCheck:
    """Carries the depth on and checks pressure readings against it."""

    def __init__(self, params: IntegrityParams) -> None:
        self._params = params
        self._limits = (params.depth_5s, params.depth_10s, params.depth_40s)
        self._blind_limits = (params.depth_blind_20s, params.depth_blind_60s)
        self.memory = VerticalCheckMemory()

    def carry_raw(self, t: float, dt: float, raw: float, heave: float, hull: float, pinged: bool) -> None:
        """Carry on by dt, s, at `raw` m/s what DVL and pitch say, believed or not, with the part that `heave` is.

        Not `pinged`: they say nothing. At `hull` m/s goes what thrust, drag, pitch and that heave say; NaN: nothing.
        """
        memory = self.memory
        memory.hull += (hull if hull == hull else raw) * dt
        memory.raw += raw * dt
        memory.heave += heave * dt
        if not pinged:
            memory.t_pinged = -math.inf
        elif t - memory.t_pinged > _PING_GAP:
            memory.t_raw = memory.t_pinged = t
        else:
            memory.t_pinged = t

    def carry(
        self, t: float, dt: float, model: float, raw: float, by_dvl: bool, modelled: bool, pitch: SourceFault, new: bool
    ) -> None:
        """Carry the depth on by dt, s, at `raw` m/s, which DVL and pitch say, if `by_dvl`, else at `model`.

        `modelled` is whether propeller and pitch tell of it; `pitch` what speaks against the AHRS, `new` whether that
        `is_newcomer`.
        """
        memory = self.memory
        memory.newcomer = new
        moved = (raw if by_dvl else model) * dt
        memory.carried += moved
        memory.model += model * dt
        if not modelled:
            memory.vague += dt
        memory.stand_in += moved
        if memory.stand_in < 0.0:
            memory.stand_in = 0.0  # it floats; nothing carries it higher
        if by_dvl:
            memory.aged += _AGED * dt
        else:
            memory.aged += _AGED_BLIND * dt
            memory.blind += dt
        if (by_dvl or modelled) and pitch in PITCH_HOLDS:
            memory.t_carried = t
        if by_dvl and pitch in _MAY_SPEAK and not new:
            memory.t_spoke = t

    def carry_late(self, moved: float, heave: float) -> None:
        """Carry the depths on by what a ping shows that the ones before it did not, m; `heave` is part of it."""
        memory = self.memory
        memory.carried += moved
        memory.raw += moved
        memory.heave += heave
        memory.stand_in += moved

    def check(self, t: float, depth: float, altitude: float, exact: bool = False) -> tuple[bool, Accused]:
        """Return whether a reading may be used, and who is accused; altitude in m, NaN if not known.

        `exact` is whether the readings repeat themselves exactly: then no eddies carry the hull.
        """
        params, memory = self._params, self.memory
        carried = memory.carried
        gap, memory.t = t - memory.t, t
        known = t - memory.t_carried <= _CARRIED_AGE
        if memory.residual != memory.residual or gap > _GAP or known is not memory.known:
            if memory.residual != memory.residual or gap > _GAP:
                memory.history, memory.parting = (), TOGETHER
            memory.known, memory.afloat = known, None
            if memory.stand_in != memory.stand_in:
                self._begin(t, depth)
                return True, Accused.NOBODY
        if memory.stand_in == memory.stand_in:  # it is suspect already
            memory.residual += _MEAN * (depth - carried - memory.residual)
            off = abs(memory.residual + carried - memory.stand_in)
            memory.lie = max(memory.lie, off)
            allowed = min(params.depth_step + memory.aged, _AGED_MOST, max(params.depth_step, _BACK * memory.lie))
            if off <= allowed:
                return False, Accused.NOBODY
            if memory.since is None:
                return False, Accused.PRESSURE_DRIFT
            return False, self._decide(self._entry(t, depth, altitude), memory.since, memory.window)
        predicted = carried + memory.residual
        if predicted < params.surface and depth < params.surface:
            then, held = memory.afloat, memory.held + 1
            self._begin(t, depth)
            memory.history, memory.parting = (), TOGETHER
            accused = (
                self._near_surface(then, held, self._entry(t, depth, altitude), exact) if known else Accused.NOBODY
            )
            return accused is not Accused.SHALLOW_PRESSURE, accused
        memory.afloat = None
        off = depth - predicted
        if abs(off) > params.depth_step + (_RATE if known else _RATE_UNKNOWN) * gap:
            memory.outliers += 1
            return False, Accused.PRESSURE_STEP if memory.outliers >= _REAL else Accused.NOBODY
        memory.outliers = 0
        if known:
            memory.residual += _MEAN * off
        else:
            memory.carried += off  # for the altitudes, which are compared by the depth that is carried
        history = memory.history
        now = self._entry(t, depth, altitude)
        speak = t - memory.t_spoke <= _CARRIED_AGE
        unnoticed = (self._limits[-1] / (_WINDOWS[-1] * _STEP) * gap if known else 0.0) if speak else math.nan
        memory.parting = memory.parting.followed(depth, memory.raw, memory.heave, unnoticed)
        if memory.parting.too_far and speak and not known:
            return False, self._overrule_bottom(now)
        accused = self._changed(now, history) if known else Accused.NOBODY
        if t - memory.t_entry >= _STEP - 1e-6:
            if t - memory.t_look >= _LOOK - 1e-6:
                memory.unsteady, memory.t_look = look(history, memory.unsteady), t
            if known and accused is Accused.NOBODY:
                limits, size = self._blind_limits, self._comparable(t)
                accused, window = wandered(now, history, size, limits, memory.unsteady, self._decide)
                memory.window = window or memory.window
            memory.t_entry = t
            memory.history = (*history[-_LENGTH + 1 :], now)
        return accused is not Accused.SHALLOW_PRESSURE, accused

    def _entry(self, t: float, depth: float, altitude: float) -> Entry:
        m = self.memory
        return Entry(m.residual, m.carried, altitude, m.blind, depth, m.raw, m.heave, m.model, m.vague, m.hull, t)

    def _overrule_bottom(self, now: Entry) -> Accused:
        """Let the depth that DVL and pitch carried hold; the bottom, which spoke for the pressure, has no say now."""
        memory = self.memory
        memory.history, memory.window = (now._replace(residual=now.residual + memory.parting.deeper),), 1
        memory.parting = TOGETHER
        return Accused.SHALLOW_PRESSURE

    def _near_surface(self, then: Entry | None, held: int, now: Entry, exact: bool) -> Accused:
        """Return who is accused where the hull sank since `then` without the pressure, for `held` readings by now."""
        memory = self.memory
        if then is None:
            memory.afloat = now
            return Accused.NOBODY
        sinking = near_surface.judge(now, then, self._params, memory.unsteady, exact)
        if sinking.agrees:
            memory.afloat = now
        if not sinking.contradicts:
            return Accused.NOBODY
        memory.held = held
        if held < _HELD:
            return Accused.NOBODY
        memory.history, memory.window = (then,), 1
        return self._decide(now, then, 1)

    def float_up(self) -> None:
        """Take note that the vehicle is at the surface, whatever carries its depth on: a fix is heard."""
        self.memory.afloat = None

    def distrust(self, entries: int, decided: bool = True) -> float:
        """Let the carried depth stand in for the pressure from `entries` of the history ago; return it, m."""
        memory = self.memory
        history = memory.history
        then = history[-min(entries, len(history))] if history else None
        memory.stand_in = memory.carried + (memory.residual if then is None else then.residual)
        memory.aged = memory.lie = 0.0
        memory.since = None if decided else then
        return memory.stand_in

    def trust(self) -> None:
        """Take the pressure for the depth again."""
        memory = self.memory
        memory.stand_in, memory.residual = math.nan, math.nan
        memory.outliers = memory.held = 0
        memory.since, memory.parting = None, TOGETHER

    @property
    def depth(self) -> float:
        """Return the depth, carried on where the pressure is not believed, m; NaN if it was never known."""
        memory = self.memory
        return memory.stand_in if memory.stand_in == memory.stand_in else memory.carried + memory.residual

    @property
    def stands_in(self) -> bool:
        """Return whether the carried depth stands in for the pressure."""
        return self.memory.stand_in == self.memory.stand_in

    def judge_raw(self) -> tuple[bool | None, Accused]:
        """Return whether DVL and pitch contradict the depth over 5, 10 or 40 s, None if that is not known; and who is
        wrong then, if the pressure is right.
        """
        memory, history = self.memory, self.memory.history
        differs: bool | None = None
        for window, limit in zip(_WINDOWS, self._limits, strict=True):
            if len(history) < window or history[-window].t < memory.t_raw:
                break
            then, now = history[-window], history[-1]
            differs = abs(now.depth - then.depth - (now.raw - then.raw)) > limit
            if differs:
                break
        return differs, dvl_or_pitch(history[-1], history, memory.t_raw) if differs else Accused.NOBODY

    def _changed(self, now: Entry, history: tuple[Entry, ...]) -> Accused:
        memory = self.memory
        size = self._comparable(now.t)
        for window, limit in zip(_WINDOWS, self._limits, strict=True):
            if size <= 0 or (size < window and window > _WINDOWS[0]):
                break
            then = history[-min(window, size)]
            change = now.residual - then.residual
            if now.blind_since(then):
                limit = max(self._params.depth_blind, wander_5s(memory.unsteady))
                if window > _WINDOWS[0]:
                    break
            if abs(change) > limit:
                memory.held += 1
                if memory.held < _HELD:
                    return Accused.NOBODY
                memory.window = window
                return self._decide(now, then, window)
        memory.held = 0
        return Accused.NOBODY

    def _comparable(self, t: float) -> int:
        """Return how many entries of the history have residuals that are comparable with that of now."""
        return min(len(self.memory.history), round((t - self.memory.began) / _STEP))

    def _decide(self, now: Entry, then: Entry, window: int) -> Accused:
        memory = self.memory
        return arbitrate(now, then, memory.history, window, self._params.depth_blind, self.stands_in, memory.newcomer)

    def _begin(self, t: float, depth: float) -> None:
        memory = self.memory
        memory.residual, memory.began = depth - memory.carried, t
        memory.outliers = memory.held = 0

    def freeze(self) -> VerticalCheckMemory:
        """Return the whole memory."""
        return copy.copy(self.memory)

    def thaw(self, memory: VerticalCheckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)
