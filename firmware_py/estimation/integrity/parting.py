"""How far DVL and pitch have carried the vehicle deeper than a pressure shows for which the bottom alone speaks.

A bottom that falls just as a pressure drifts bears the pressure out, as it does where DVL or pitch is wrong. While the
hull convicts neither of these two, the bottom is one witness, DVL, pitch and propeller are another. So its word holds
for a way: then it is not decided, and the deeper one holds.

The way is a one-sided sum (CUSUM) of what they part by, reading by reading. While nothing is in doubt, what DVL and
pitch may be off by unnoticed is taken from it; in doubt nothing is, for what parts slowly goes as deep in the end.

A vehicle follows a pressure that drifts by its pitch. What the DVL's own heave makes is left to the hull for longer,
which heaves little, and in the end convicts the DVL.
"""

from __future__ import annotations

import math
from typing import NamedTuple

_ALONE, _HEAVED = 3.0, 6.0
"""The bottom's word holds for so much, m, and where heave makes it. A pitch that drifts with its gyro by 0.5 deg/s is
convicted at 2.5 m, a w of the DVL that is off by 0.2 m/s at 5.4 m; a hold 2 m above a depth limit ends 1 m below it."""
_EXPLAINS = 0.2
"""Heave makes it, if no more than this share is left."""


class Parting(NamedTuple):
    """By how much they have parted as of a reading.

    Attributes:
        deeper: how much deeper DVL and pitch carried the vehicle, m,
        by_heave: and the part of it that heave made, m.
        depth: the reading, m.
        raw, heave: as in `Entry`.
    """

    deeper: float = 0.0
    by_heave: float = 0.0
    depth: float = math.nan
    raw: float = math.nan
    heave: float = math.nan

    def followed(self, depth: float, raw: float, heave: float, unnoticed: float) -> Parting:
        """Return it as of the next reading.

        Args:
            depth: of the reading, m.
            raw, heave: as in `Entry`, m.
            unnoticed: what DVL and pitch may be off by since the last one, m; NaN: they do not tell of the depth.
        """
        deeper = self.deeper + (raw - self.raw) - (depth - self.depth) - unnoticed
        if deeper != deeper:
            return Parting(self.deeper, self.by_heave, depth, raw, heave)
        if deeper <= 0.0:
            return Parting(0.0, 0.0, depth, raw, heave)
        return Parting(deeper, self.by_heave + heave - self.heave, depth, raw, heave)

    @property
    def too_far(self) -> bool:
        """Return whether the bottom alone is no longer enough."""
        explained = abs(self.deeper - self.by_heave) < _EXPLAINS * self.deeper
        return self.deeper > (_HEAVED if explained else _ALONE)


TOGETHER = Parting()
"""They have not parted."""
