"""NodeStatus in words."""

from __future__ import annotations

from firmware_py.wire.dronecan.node_messages import NodeStatus

HEALTH = ("OK", "WARNING", "ERROR", "CRITICAL")
MODE = ("OPERATIONAL", "INITIALIZATION", "MAINTENANCE", "SOFTWARE_UPDATE", "mode 4", "mode 5", "mode 6", "OFFLINE")
"""By their numbers in uavcan.protocol.NodeStatus."""


def status_text(status: NodeStatus | None) -> str:
    """Return health, and mode if it is not the usual one; "-" of a node without a status."""
    if status is None:
        return "-"
    mode = MODE[status.mode]
    return HEALTH[status.health] + ("" if status.mode == 0 else f", {mode}")


def uptime_text(status: NodeStatus | None) -> str:
    """Return how long a node runs."""
    if status is None:
        return "-"
    minutes, seconds = divmod(status.uptime_sec, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {seconds:02d} s" if minutes else f"{seconds} s"
