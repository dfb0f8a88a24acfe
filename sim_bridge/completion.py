"""Whether a flight came to the end that its scenario meant it to have, and if not, why."""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.records.event_text import sentences
from firmware_py.records.order import Mode
from sim_bridge.scenarios import Completes

_SURFACE = 1.0
"""Less deep than this, m, a vehicle has come up."""


class Completion:
    """Watches every cycle.

    To surface by order, or at the end of a mission, is one thing; to be brought up by a rule is another: no completed
    mission, though it may end well (`surfaced`).

    Args:
        completes: what the scenario meant.
        watch: for how long it must have lain disarmed at the surface to be done, s; it may sink again.
        true_depth: the plant's, m. Where the plant is out of reach (another process, the sea) the vehicle's own word
            counts: a fix, or its estimate of the depth.
    """

    def __init__(self, completes: Completes, true_depth: Callable[[], float] | None = None, watch: float = 0.0) -> None:
        self.done = False
        """True when nothing more can come: a vehicle that was to surface has disarmed itself."""
        self._completes = completes
        self._true_depth = true_depth
        self._watch = watch
        self._t_up = math.inf
        self._mode = Mode.DISARMED
        self._armed = False
        self._aborted = ""
        self._said = self._refused = ""
        self._last = ""
        self._up = self._commanded = self._dropped = False

    @property
    def completed(self) -> bool:
        """True if, with the last cycle seen, the scenario has come to its end."""
        if self._aborted:
            return False
        if self._completes is Completes.SURFACED:
            return self.done
        return self._mode not in (Mode.DISARMED, Mode.SURFACE)

    @property
    def surfaced(self) -> bool:
        """True if a rule ended what was meant, and the vehicle has come up and lies disarmed at the surface."""
        return bool(self._aborted) and self._up

    @property
    def judged_by(self) -> str:
        """Return what says that the vehicle has come up: "truth" or "estimate"."""
        return "estimate" if self._true_depth is None else "truth"

    @property
    def reason(self) -> str:
        """Why it is not completed, as the vehicle said it."""
        if self.surfaced:
            told = ", the release of its drop weight commanded," if self._commanded else ""
            without = ", without its drop weight," if self._dropped else told
            return f"surfaced safely{without} because of a rule: {self._aborted.partition(': ')[2] or self._aborted}"
        if self._aborted:
            later = "" if self._last in ("", self._aborted) else f", then {self._last}"
            under_way = "" if self._mode is Mode.DISARMED else f"; in mode {self._mode.name.lower()} at the end"
            return f"aborted: {self._aborted}{later}{under_way}"
        if not self._armed:
            return f"never armed: {self._refused or self._said or 'nobody asked for it'}"
        if self._completes is Completes.SURFACED:
            return "it had not surfaced when the time was over"
        return "it was no longer flying when the time was over"

    def see(self, cycle: Cycle) -> None:
        """Takes one cycle in."""
        mode, before = cycle.mode.mode, self._mode
        if cycle.events:
            changes = [event for event in cycle.events if event.kind is EventKind.MODE_CHANGED]
            self._said = sentences(changes or cycle.events)[-1].text
            self._dropped = self._dropped or any(e.kind is EventKind.WEIGHT_RELEASED for e in cycle.events)
            if refusals := [event for event in cycle.events if event.kind is EventKind.ARMING_REFUSED]:
                self._refused = sentences(refusals)[-1].text
        if mode is before:
            self.done = self.done or (self._t_up < math.inf and cycle.tick.t - self._t_up >= self._watch)
            return
        self._mode, self._up, self._t_up = mode, False, math.inf
        self._commanded = self._commanded or cycle.mode.drop
        self._armed = self._armed or mode is not Mode.DISARMED
        if cycle.mode.failsafe:
            self._abort()
        elif mode is Mode.DISARMED:
            self._up = self._came_up(cycle) and before is Mode.SURFACE
            if not self._up:
                self._abort()
            if self._completes is Completes.SURFACED and self._up:
                self.done = self._watch == 0.0
                self._t_up = math.inf if self.done else cycle.tick.t

    def _came_up(self, cycle: Cycle) -> bool:
        if self._true_depth is None:
            return cycle.heard.fix.ok or cycle.state.eta.z < _SURFACE
        depth = self._true_depth()
        if depth >= _SURFACE:
            self._said += f", at a depth of {depth:.1f} m in truth"
        return depth < _SURFACE

    def _abort(self) -> None:
        self._last = self._said or "nobody said why"
        self._aborted = self._aborted or self._last
