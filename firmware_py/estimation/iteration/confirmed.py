"""Which coefficients a pass through the flight has confirmed, and what has made them uncertain again since.

A running filter takes its slopes about what it believes at the moment. Where that was just made uncertain, it is as
wrong as in the beginning, and the filter ends up off and too sure of it in the same way: 5 s after lost rudders
M_ds was 1.9 times what it is, 9 of its sigmas off. A pass confirms, whose slopes lie about the whole flight since.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from firmware_py.compiled import Flags
from firmware_py.estimation.iteration.acceptance import Verdict


class Confirmed:
    """Flags of the learned coefficients, each (names,); where nothing is `iterated`, everything is confirmed.

    Attributes:
        iterated: a pass has confirmed it, and none was rejected since.
        shaken: it was made uncertain after that.
    """

    def __init__(self, count: int, iterates: bool) -> None:
        """Take how many there are, and whether there are passes."""
        self._iterates = iterates
        self.iterated, self.shaken = np.full(count, not iterates), np.zeros(count, dtype=np.bool_)

    @property
    def holds(self) -> Flags:
        """Return what is confirmed now."""
        now: Flags = self.iterated & ~self.shaken
        return now

    def forget(self) -> None:
        """Take note that all of it begins anew."""
        self.iterated[:], self.shaken[:] = not self._iterates, False

    def shake(self, those: Flags) -> None:
        """Take note that those were made uncertain."""
        self.shaken |= those & self._iterates

    def heed(self, verdict: Verdict, permitted: Callable[[int], Flags]) -> None:
        """Take note of what became of a pass, which let learn what `permitted` says of the first so many."""
        if verdict is Verdict.ACCEPTED:
            learned = permitted(len(self.iterated))
            self.iterated |= learned
            self.shaken &= ~learned
        elif verdict is Verdict.REJECTED:
            self.iterated[:] = False

    def freeze(self) -> tuple[Flags, Flags]:
        """Return the whole memory."""
        return self.iterated.copy(), self.shaken.copy()

    def thaw(self, iterated: Flags, shaken: Flags) -> None:
        """Restore the memory that `freeze` returned."""
        self.iterated[:], self.shaken[:] = iterated, shaken
