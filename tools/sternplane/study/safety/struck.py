"""What a fault strikes, by the names that events use: only that may be called faulty."""

from __future__ import annotations

from sim_bridge.faults.fault import Fault, parse_fault

STERNS = ("stern_port", "stern_starboard")
RUDDERS = ("rudder_upper", "rudder_lower")
FINS = (*STERNS, *RUDDERS)
ON_BUS = ("ahrs", "pressure", "altitude", "fix", "battery", "leak", *FINS, "propeller", "drop weight")
"""Who speaks on the CAN bus; the DVL has a line of its own."""
_NAMES = {
    "altimeter": ("altitude",),
    "servo_hub": FINS,
    "esc": ("propeller",),
    "hardpoint": ("drop weight",),
    "weight": ("drop weight",),
}
_NOBODY = ("CURRENT", "BALLAST", "autopilot", "station", "clock", "disk")
"""Groups of targets that are no sensor or actuator."""
_OF_NODES = ("off", "silent", "critical")
"""Kinds that strike a whole node: battery and leak sensor are one."""


def struck(faults: tuple[str, ...]) -> frozenset[str]:
    """Return the names of the sensors and actuators that are struck."""
    return frozenset(name for text in faults for name in _struck(parse_fault(text)))


def _struck(fault: Fault) -> tuple[str, ...]:
    kind, target = fault.kind, fault.target.partition(".")[0]
    if kind.group in _NOBODY:
        return ()
    if kind.group == "bus":  # frames are lost or late: each device is as sound as before
        return ON_BUS if kind.name == "off" else ()
    if target == "battery" and kind.name in _OF_NODES:
        return ("battery", "leak")
    return _NAMES.get(target, (target,))
