"""Where a flight kept its passport; if it kept none, or not to its end, why, as far as its last cycle tells."""

from __future__ import annotations

from pathlib import Path

from firmware_py.records.adoption import Refusal
from firmware_py.records.cycle import Cycle
from firmware_py.records.health import ActuatorFault
from firmware_py.run.kept_passport import FILE, PassportKeeper

_SOON = 1.0
"""What was known no longer than this before the end, s, was kept to the end."""
_NO_DAMAGE = (ActuatorFault.NONE, ActuatorFault.SILENT)


class PassportNote:
    """Sees a flight's cycles, and says afterwards whether it left a passport.

    Args:
        state: the flight's state folder, as it is before the flight.
        keeper: what saves the passport there.
    """

    def __init__(self, state: Path, keeper: PassportKeeper) -> None:
        self._file = state / FILE
        self._keeper = keeper
        self._before = _version(self._file)
        self._last: Cycle | None = None

    def update(self, cycle: Cycle) -> None:
        """Take in a cycle."""
        self._last = cycle

    @property
    def text(self) -> str:
        """Return where it was kept, or why it was not, or not to the end, in a line; "" if there was no flight."""
        if self._last is None:
            return ""
        if _version(self._file) != self._before:
            kept, keeper = f"passport kept in {self._file}", self._keeper
            if self._last.tick.t - keeper.t_kept > _SOON:
                kept += f", as it was known at {keeper.t_kept:.1f} s, not at the end: {why(self._last)}"
            return f"{kept}; against the vehicle file: {keeper.off}" if keeper.off else kept
        earlier = "; that of an earlier flight stays" if self._before is not None else ""
        return f"no passport kept: {why(self._last)}{earlier}"


def why(last: Cycle) -> str:
    """Return why a flight that ended with this cycle kept none, or none of its end."""
    actuators, laws = last.actuators, (last.adopted.depth, last.adopted.heading)
    if any(fault not in _NO_DAMAGE for fault in (*actuators.fins, actuators.propeller)):
        return "damage of a fin or of the propeller is named, and may have been learned"
    if True not in last.state.learned.valid:
        return "no coefficient is valid at the end of the flight"
    if any(law.refusal is Refusal.RESIDUALS for law in laws):
        return "the motion contradicts what was learned"
    return "damage was named shortly before the end, or what was learned is not finite"


def _version(file: Path) -> tuple[int, int] | None:
    """Return what tells a file from the one that replaces it; None if there is none."""
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns
