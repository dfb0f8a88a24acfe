"""What truly became of a simulated vehicle that may not know it: when it was up, and when its drop weight went."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim_bridge.completion import SURFACE
from sternplane.logs.reading import Piece


class TrueEnd:
    """Looks at the truth of a run; it is shown the pieces of the log one after the other."""

    def __init__(self) -> None:
        self._known = self._dived = self._carried = False
        self._up = self._gone = math.nan

    def add(self, piece: Piece) -> None:
        """Take a piece in; a log without truth has none."""
        if "eta.z" not in piece.truth:
            return
        self._known = True
        t, deep = piece.columns["t"], ~(piece.truth["eta.z"] < SURFACE)
        if deep.any():
            self._dived, last = True, int(np.flatnonzero(deep)[-1])
            self._up = float(t[last + 1]) if last + 1 < len(t) else math.nan
        elif self._dived and math.isnan(self._up):
            self._up = float(t[0])
        weight = piece.truth.get("drop_weight")
        if weight is None:
            return
        self._carried |= bool((weight > 0.0).any())
        if self._carried and math.isnan(self._gone) and not weight[-1] > 0.0:
            self._gone = float(t[int(np.argmin(weight > 0.0))])

    def document(self) -> dict[str, Any] | None:
        """Return up_s, from when it was at the surface until the end, and weight_gone_s; None without a truth."""
        if not self._known:
            return None
        return {name: None if math.isnan(t) else t for name, t in (("up_s", self._up), ("weight_gone_s", self._gone))}
