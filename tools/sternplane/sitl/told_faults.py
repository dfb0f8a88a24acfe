"""The faults of a plant on its terminal: which there are, and when each begins and ends, by the plant's own time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from sim_bridge.faults.fault import Fault

Step = Callable[[int], None]


def telling_faults(step: Step, faults: Sequence[Fault], dt_ns: int, tell: Callable[[str], None]) -> Step:
    """Return a step of the plant that also tells of the faults that begin and end with it.

    Args:
        step: takes the number of the tick.
        faults: of the run.
        dt_ns: of a tick.
        tell: takes a line.
    """
    if not faults:
        return step
    tell(f"faults, by the plant's time: {', '.join(fault.text for fault in faults)}")
    changes = [(fault.t, f"{fault.text} begins") for fault in faults]
    changes += [(fault.t + fault.duration, f"{fault.text} ends") for fault in faults if math.isfinite(fault.duration)]
    due = sorted(changes, key=lambda change: change[0], reverse=True)

    def told(k: int) -> None:
        step(k)
        while due and k * dt_ns >= round(1e9 * due[-1][0]):
            t, what = due.pop()
            tell(f"{t:9.2f} s  {what}")

    return told
