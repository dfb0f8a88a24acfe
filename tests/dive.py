"""A flight that is quick to fly."""

DIVE = """
description = "A short dive."
duration_s = 12.0
completes = "time"

[[orders]]
t_s = 0.5
arming = "arm"
mode = "hold"
depth_m = 4.0
heading_deg = 120.0
speed_m_s = 1.5
"""
