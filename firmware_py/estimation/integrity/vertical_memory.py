"""What the check of pressure against the carried depth remembers."""

from __future__ import annotations

import math
from dataclasses import dataclass

from firmware_py.estimation.integrity.depth_arbitration import Entry
from firmware_py.estimation.integrity.parting import TOGETHER, Parting


@dataclass(slots=True)
class VerticalCheckMemory:
    """Carried depths, mean residual and history.

    `known` is whether they can be carried on; `stand_in` the depth in place of a suspect pressure; `since` the entry
    from which pressure and carried depth went apart, where the pressure is suspect and it is not decided; `window`
    how many entries of the history before its end that was. Residuals are comparable since `began`, `raw` since
    `t_raw`; `lie` is the farthest that a suspect pressure was from `stand_in`, m. `unsteady` is how much the drift from
    propeller and pitch changes in 5 s, m, as seen at `t_look`. `afloat` is when pressure and carried depth rose
    together last, near the surface; `parting` how far DVL and pitch, which spoke last at `t_spoke`, went from the
    pressure; `newcomer` whether the pitch is that of an AHRS that was lost not long ago.
    """

    carried: float = 0.0
    raw: float = 0.0
    heave: float = 0.0
    hull: float = 0.0
    began: float = -math.inf
    t_raw: float = -math.inf
    t_pinged: float = -math.inf
    lie: float = 0.0
    blind: float = 0.0
    model: float = 0.0
    vague: float = 0.0
    since: Entry | None = None
    window: int = 20
    t_carried: float = -math.inf
    t: float = -math.inf
    known: bool = False
    residual: float = math.nan
    outliers: int = 0
    held: int = 0
    t_entry: float = -math.inf
    history: tuple[Entry, ...] = ()
    stand_in: float = math.nan
    aged: float = 0.0
    unsteady: float = math.nan
    t_look: float = -math.inf
    afloat: Entry | None = None
    t_spoke: float = -math.inf
    parting: Parting = TOGETHER
    newcomer: bool = False
