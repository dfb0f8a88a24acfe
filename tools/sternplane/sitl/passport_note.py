"""Whether a simulated flight kept a passport; if it kept none, why, as far as its last cycle tells."""

from __future__ import annotations

from pathlib import Path

from firmware_py.records.adoption import Refusal
from firmware_py.records.cycle import Cycle
from firmware_py.records.health import ActuatorFault
from firmware_py.run.kept_passport import FILE

_NO_DAMAGE = (ActuatorFault.NONE, ActuatorFault.SILENT)


class PassportNote:
    """Sees a flight's cycles, and says afterwards whether it left a passport.

    Args:
        state: the flight's state folder, as it is before the flight.
    """

    def __init__(self, state: Path) -> None:
        self._file = state / FILE
        self._before = _version(self._file)
        self._last: Cycle | None = None

    def update(self, cycle: Cycle) -> None:
        """Take in a cycle."""
        self._last = cycle

    @property
    def text(self) -> str:
        """Return why none was kept, in a line; "" if one was, or there was no flight."""
        if self._last is None or _version(self._file) != self._before:
            return ""
        earlier = "; that of an earlier flight stays" if self._before is not None else ""
        return f"no passport kept: {why(self._last)}{earlier}"


def why(last: Cycle) -> str:
    """Return why a flight that ended with this cycle kept none."""
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
