"""Whether a flight came to the end that its scenario meant it to have, and if not, why."""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.records.event_text import sentences
from firmware_py.records.health import WeightState
from firmware_py.records.order import Mode
from sim_bridge.scenarios import Completes

SURFACE = 1.0
"""Less deep than this, m, a vehicle has come up; deeper than `_SUNK`, it has sunk again."""
_SUNK = 2.0
_TICK = 0.2
"""Longer than any tick, s: the last one of a scenario begins no earlier than this before its end."""
_OPEN = (WeightState.HELD, WeightState.SILENT, WeightState.COMMANDED)
"""A drop weight of which it is not yet known whether the release has done it."""
_CONFIRMED = 5.0
"""For so long is it awaited what became of a drop weight, s: after 3 s, as shipped, the vehicle says that it stays."""
_DOING = {
    Mode.MISSION: "flew its mission",
    Mode.RETURN: "was returning",
    Mode.SURFACE: "was coming up",
    Mode.HOLD: "was holding",
}


class Completion:
    """Watches every cycle.

    To surface by order, or at the end of a mission, is one thing; to be brought up by a rule is another: no completed
    mission, though it may end well (`surfaced`).

    Args:
        completes: what the scenario meant.
        watch: for how long it must have lain disarmed at the surface to be done, s; it may sink again.
        true_depth: the plant's, m. Where the plant is out of reach (another process, the sea) the vehicle's own word
            counts: a fix, or its estimate of the depth.
        duration: after which the scenario ends the flight, s; infinite where that is not known.
    """

    def __init__(
        self,
        completes: Completes,
        true_depth: Callable[[], float] | None = None,
        watch: float = 0.0,
        duration: float = math.inf,
    ) -> None:
        self.done = False
        """True when nothing more can come: a vehicle that was to surface has disarmed itself."""
        self._completes = completes
        self._true_depth = true_depth
        self._watch = watch
        self._duration = duration
        self._t_up = math.inf
        self._mode = Mode.DISARMED
        self._armed = False
        self._aborted = self._ended_by = self._brought_up = ""
        self._last_cycle: Cycle | None = None
        self._said = self._refused = ""
        self._last = ""
        self._up = self._commanded = self._dropped = False

    @property
    def completed(self) -> bool:
        """True if, with the last cycle seen, the scenario has come to its end."""
        if self._aborted:
            return False
        if self._completes is Completes.SURFACED:
            return self.done and not self._sank
        return self._mode not in (Mode.DISARMED, Mode.SURFACE)

    @property
    def surfaced(self) -> bool:
        """True if a rule ended what was meant, and the vehicle has come up and lies disarmed at the surface."""
        return bool(self._aborted) and self._up and not self._sank

    @property
    def judged_by(self) -> str:
        """Return what says that the vehicle has come up: "truth" or "estimate"."""
        return "estimate" if self._true_depth is None else "truth"

    @property
    def reason(self) -> str:
        """Why it is not completed, as the vehicle said it."""
        if self._sank:
            why = f" because of a rule: {self._aborted}" if self._aborted else ""
            return f"it had surfaced{why}, and sank again: it ends disarmed, {self._depth():.1f} m deep in truth"
        if self.surfaced:
            told = ", the release of its drop weight commanded," if self._commanded else ""
            without = ", without its drop weight," if self._dropped else told
            first, why = _cause(self._aborted), _cause(self._brought_up or self._aborted)
            before = "" if first == why else f"; before that: {first}"
            return f"surfaced safely{without} because of a rule: {why}{before}"
        if self._aborted:
            later = "" if self._last in ("", self._aborted) else f", then {self._last}"
            ended = f"{self._ended_by}: {self._aborted}{later}"
            if self._mode is Mode.DISARMED:
                return ended
            if self._completes is Completes.SURFACED and (self._time_is_over or self._is_up_unknown):
                return f"{self._too_late}; before that, {ended}"
            return f"{ended}; at the end in mode {self._mode.name}, {self._where_it_is}"
        if not self._armed:
            return f"never armed: {self._refused or self._said or 'nobody asked for it'}"
        if self._completes is Completes.SURFACED:
            return self._too_late
        return "it was no longer flying when the time was over"

    @property
    def _sank(self) -> bool:
        """Return whether it came up, disarmed itself, and is deep again by the truth."""
        return self._up and self._mode is Mode.DISARMED and self._depth() > _SUNK

    def _depth(self) -> float:
        """Return the true depth, m; NaN where it is out of reach."""
        return math.nan if self._true_depth is None else self._true_depth()

    @property
    def _where_it_is(self) -> str:
        """Return whether it has come up, and by whose word."""
        by = "by the truth" if self._true_depth is not None else "by its own estimate"
        return f"{'at the surface' if self._is_up() else 'under water'} {by}"

    @property
    def _time_is_over(self) -> bool:
        """Return whether the scenario's time has ended the flight, and nobody before it."""
        cycle = self._last_cycle
        return cycle is not None and cycle.tick.t >= self._duration - _TICK

    @property
    def _is_up_unknown(self) -> bool:
        """Return whether it comes up, is at the surface by the truth, and no fix tells it so."""
        cycle = self._last_cycle
        heard = cycle is not None and cycle.heard.fix.ok
        return self._mode is Mode.SURFACE and self._true_depth is not None and self._is_up() and not heard

    @property
    def _too_late(self) -> str:
        """Return what it did when its time was over; of a flight that the scenario's time ended, what gives more."""
        time = f"the scenario's {self._duration:g} s were" if self._time_is_over else "the time was"
        if self._is_up_unknown:
            return f"it was at the surface when {time} over, but did not know it: no fix"
        if not self._time_is_over:
            return "it had not surfaced when the time was over"
        doing = _DOING.get(self._mode, f"was in mode {self._mode.name}")
        return f"{time} over while it {doing}, {self._where_it_is}; scenario.duration_s gives more"

    def see(self, cycle: Cycle) -> None:
        """Takes one cycle in."""
        mode, before = cycle.mode.mode, self._mode
        self._last_cycle = cycle
        if cycle.events:
            changes = [event for event in cycle.events if event.kind is EventKind.MODE_CHANGED]
            self._said = sentences(changes or cycle.events)[-1].text
            self._dropped = self._dropped or any(e.kind is EventKind.WEIGHT_RELEASED for e in cycle.events)
            if refusals := [event for event in cycle.events if event.kind is EventKind.ARMING_REFUSED]:
                self._refused = sentences(refusals)[-1].text
        if mode is before:
            up = cycle.tick.t - self._t_up
            watched = up >= self._watch and not (up < _CONFIRMED and _awaits_weight(cycle))
            self.done = self.done or (watched and not self._sank)
            return
        self._mode, self._up, self._t_up = mode, False, math.inf
        self._commanded = self._commanded or cycle.mode.drop
        self._armed = self._armed or mode is not Mode.DISARMED
        if cycle.mode.failsafe:
            self._abort("a rule ended the mission" if before is Mode.MISSION else f"a rule ended mode {before.name}")
            if mode is Mode.SURFACE:
                self._brought_up = self._last
        elif mode is Mode.DISARMED:
            self._up = self._came_up() and before is Mode.SURFACE
            if not self._up:
                self._abort("it was disarmed too soon")
            if self._completes is Completes.SURFACED and self._up:
                self.done = self._watch == 0.0 and not _awaits_weight(cycle)
                self._t_up = math.inf if self.done else cycle.tick.t

    def _is_up(self) -> bool:
        """Return whether it is at the surface now: by the truth, where it is known."""
        if self._true_depth is not None:
            return self._true_depth() < SURFACE
        cycle = self._last_cycle
        return cycle is not None and (cycle.heard.fix.ok or cycle.state.eta.z < SURFACE)

    def _came_up(self) -> bool:
        up = self._is_up()
        if not up and self._true_depth is not None:
            self._said += f", at a depth of {self._depth():.1f} m in truth"
        return up

    def _abort(self, by: str) -> None:
        self._last = self._said or "nobody said why"
        if not self._aborted:
            self._aborted, self._ended_by = self._last, by


def _awaits_weight(cycle: Cycle) -> bool:
    """Return whether the release of the weight is commanded, and its hardpoint has yet to say what became of it."""
    return cycle.mode.drop and cycle.actuators.drop_weight in _OPEN


def _cause(sentence: str) -> str:
    """Return why a mode was entered, of the sentence that tells of it."""
    return sentence.partition(": ")[2] or sentence
