"""What is lost on wires and links, and which single values are left out, counted by source and cause once a second.

Where a count begins to rise fast it is told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from firmware_py.records.cycle import Cycle
from firmware_py.records.health import SensorHealth
from firmware_py.tick import NS_PER_S, Rate

OUTLIERS = "outliers_"
"""Single values that the estimator left out are counted so, by sensor: no wire has lost them."""
FAST = 10
"""More than so many in a second are told."""
_ALWAYS = ("_unknown_model_", "set_ups_failed", "start_ups_failed", "watchdog_lost", "impossible_angles")
"""Parts of the names of counts that are told however slowly they rise: somebody must mend it."""
_AGAIN_S = 60.0
"""Of one count no more than one sentence within this time."""
_APART_S = 10.0
"""No more than one sentence within this time: one cause, such as a bus that loses frames, makes many counts rise."""

Counts = Callable[[], Mapping[str, int]]


class LossWatch:
    """Asks all sources once a second.

    Attributes:
        tell: takes a sentence for people.
        count: takes all counts, and how many messages have arrived on the bus.
    """

    def __init__(self) -> None:
        self.tell: Callable[[str], None] = lambda _sentence: None
        self.count: Callable[[Mapping[str, int], int], None] = lambda _totals, _received: None
        self._sources: list[Counts] = []
        self._received: Callable[[], int] = lambda: 0
        self._notes: list[Callable[[Cycle], None]] = []
        self._refused: dict[str, int] = {}
        self._last: dict[str, int] = {}
        self._told: dict[str, float] = {}
        self._t_told = -math.inf

    def add(self, losses: Counts) -> Callable[[], None]:
        """Add a source; return what to call before it is closed: from then on its counts stay."""
        self._sources.append(losses)

        def freeze() -> None:
            final = dict(losses())
            self._sources[self._sources.index(losses)] = lambda: final

        return freeze

    def add_hardware(
        self, losses: Counts, received: Callable[[], int], note: Callable[[Cycle], None]
    ) -> Callable[[], None]:
        """Add the hardware; `note` is shown the cycle before each full second. Return as `add` does."""
        self._received = received
        self._notes.append(note)
        return self.add(losses)

    def totals(self) -> dict[str, int]:
        """Return how much was lost since the start, by source and cause."""
        found: dict[str, int] = dict(self._refused)
        for source in self._sources:
            found |= source()
        return found

    def update(self, cycle: Cycle) -> dict[str, int]:
        """Return the counts that have changed since the last second; mostly none."""
        tick = cycle.tick
        if (tick.t_ns + tick.dt_ns) % NS_PER_S == 0:
            for note in self._notes:
                note(cycle)
        if not tick.every(Rate.HZ_1):
            return {}
        refused = zip(SensorHealth._fields, cycle.state.refused, strict=False)
        self._refused = {f"{OUTLIERS}{sensor}": count for sensor, count in refused if count}
        totals, last = self.totals(), self._last
        changed = {name: count for name, count in totals.items() if count != last.get(name, 0)}
        self._last = totals
        self.count(totals, self._received())
        self._tell({name: count - last.get(name, 0) for name, count in changed.items()}, tick.t)
        return changed

    def _tell(self, rises: Mapping[str, int], t: float) -> None:
        """Tell what must be mended, count by count, and of what has risen fast the most, with how many others."""
        fast: dict[str, int] = {}
        for name, more in rises.items():
            if t - self._told.get(name, -math.inf) < _AGAIN_S:
                continue
            if more > 0 and any(part in name for part in _ALWAYS):
                self._told[name] = t
                self.tell(_sentence(name, more))
            elif more > FAST:
                fast[name] = more
        if fast and t - self._t_told >= _APART_S:
            self._t_told = t
            self._told |= dict.fromkeys(fast, t)
            most = max(fast, key=fast.__getitem__)
            self.tell(_sentence(most, fast[most], len(fast) - 1))


def _sentence(name: str, more: int, others: int = 0) -> str:
    """Return a sentence that mostly fits into one STATUSTEXT of 50 characters."""
    # Messages missed in a silence are counted when it is over: not in this second were they lost.
    rate = "more" if name.endswith("_missed") else "in 1 s"
    told = f"{name.replace('_', ' ')}: {more} {rate}"
    return f"{told}, and {others} other{'s' if others > 1 else ''}" if others else told
