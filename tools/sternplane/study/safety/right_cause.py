"""As what a fault may be named: a sensor that is late is not called drifting, nor a fin that is lost jammed."""

from __future__ import annotations

import functools

from sim_bridge.faults.fault import parse_fault

_WRONG = ("IMPOSSIBLE", "FROZEN", "STEP", "DRIFT", "HEADING", "STEERING", "CURRENT", "CONTRADICTED", "UNDECIDED")
"""A value that is not true: by which of its signs it is found first depends on the flight."""
_KINDS = {
    "off": ("SILENT", "LOST"),  # the propeller of an ESC without power is LOST by what the vehicle does
    "silent": ("SILENT",),
    "nan": ("UNHEALTHY",),
    "critical": ("UNHEALTHY",),
    "late": ("LATE", "SILENT"),  # nothing comes until the first late value does
    "lossy": ("SILENT",),
    "duplicate": ("TWO_SENDERS", "OTHER_DEVICE"),
    "freeze": _WRONG,
    "bias": _WRONG,
    "drift": _WRONG,
    "set": _WRONG,
    "lost": ("LOST", "WEAK"),
    "weak": ("WEAK",),
    "slow": ("SLOW", "LAGGING"),
    "loose": ("LOOSE",),
    "jam": ("JAMMED",),
    "stuck": ("JAMMED", "HARDPOINT_HOLDS"),
    "hard-over": ("HARD_OVER", "JAMMED"),
}


@functools.cache
def right_kinds(faults: tuple[str, ...]) -> frozenset[str]:
    """Return the faults (names of `SourceFault` and `ActuatorFault`) as which what these strike may be named."""
    kinds = {parse_fault(text).kind.name for text in faults}
    return frozenset(name for kind in kinds for name in _KINDS.get(kind, ()))
