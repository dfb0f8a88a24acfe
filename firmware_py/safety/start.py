"""A start under water: the mode in which an earlier run of the program ended, and what this one makes of it.

A program that crashed or was killed in flight starts again disarmed, at a depth at which nobody reaches the vehicle. So
it comes up by itself (rule RESTARTED). On deck and in a workshop fins and propeller must not move: for `restart_time` a
good depth must say that it is under water, and no fix that it is not; and the time since it was armed must be known and
short, which is decided before the run (`run.kept_navigation`). Where no depth is heard, that of the earlier run counts
for some minutes, in which nobody lifts a vehicle out. Once it is armed, disarmed (under water by force alone), or
found at the surface, that is over: a vehicle that is put into the water later stays disarmed.
"""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.records.order import Mode

_JUST = 300.0
"""Where a program ended so short a time ago, s, the vehicle still is under water, if it was."""
_DOUBT = 4
"""So many times as long a shallow depth must hold there: a pressure that is stuck is found out meanwhile."""


class KeptMode(NamedTuple):
    """The mode in which an earlier run of the program ended, how long before this run that was, s, and how deep, m."""

    mode: Mode = Mode.DISARMED
    ago: float = 0.0
    depth: float = 0.0

    def still_under_water(self, submerged: float) -> bool:
        """Return whether nobody can have lifted it out since; deeper than `submerged`, m, is under water."""
        return self.depth > submerged and self.ago < _JUST


NOT_ARMED = KeptMode()


class Start(NamedTuple):
    """What is remembered of the start.

    Attributes:
        kept: of the earlier run; DISARMED too if it was armed too long ago.
        open: nobody has armed or disarmed it since, and it was not found at the surface.
        shallow: for how many ticks it has been at the surface.
    """

    kept: KeptMode = NOT_ARMED
    open: bool = True
    shallow: int = 0

    @property
    def was_armed(self) -> bool:
        """Return whether it may have to come up by itself."""
        return self.open and self.kept.mode is not Mode.DISARMED

    def after_a_tick(self, settled: bool, at_surface: bool, ticks: int, submerged: float) -> Start:
        """Return what is remembered after a tick; it is over once `settled`, or `at_surface` for more than `ticks`.

        Where the earlier run ended a moment ago deeper than `submerged`, m, it takes four times as long.
        """
        if not self.open:
            return self
        if settled or self.shallow >= ticks * (_DOUBT if self.kept.still_under_water(submerged) else 1):
            return OVER
        shallow = self.shallow + 1 if at_surface else 0
        return self if shallow == self.shallow else self._replace(shallow=shallow)


OVER = Start(open=False)
