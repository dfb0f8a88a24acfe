"""The id of a frame is one integer: of 29 bits without a flag, as DroneCAN has it, or of 11 bits with one."""

from __future__ import annotations

STANDARD = 1 << 29
"""Flag of an id of 11 bits, as CANopen has it; an id without it has 29. No id of 29 bits has this bit."""
