"""A flight that is quick to fly."""


def dive(duration: float) -> str:
    """Return a scenario of so many seconds: a vehicle dives from the surface."""
    return f"""
description = "A short dive."
duration_s = {duration}
completes = "time"

[[orders]]
t_s = 0.5
arming = "arm"
mode = "hold"
depth_m = 4.0
heading_deg = 120.0
speed_m_s = 1.5
"""


DIVE = dive(12.0)
