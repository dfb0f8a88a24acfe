"""The courses of the adaptation study."""

from __future__ import annotations

import re

from sternplane.sitl.flight import SCENARIOS
from sternplane.study.adaptation.flight import Course
from sternplane.study.setups import FINS

_ADOPTION = "[autopilot.control.adoption]\nenabled = {adoption}\n"
_STEP = 14.0
_TRACK = """
description = "The adaptation study: depth and heading up and down, left and right, in a current."
duration_s = {duration}
completes = "time"
[environment]
bottom_depth_m = 60.0
current_ned_m_s = [0.06, 0.08, 0.0]
turbulence_m_s = {eddies}
[start]
depth_m = 10.0
u_m_s = {speed}
n_rpm = {rpm}
"""
LEG_TIME = 160.0
"""How long the straight leg is flown, s."""
_LEG = f"""
description = "The adaptation study: a straight leg across a current of 0.2 m/s."
duration_s = {LEG_TIME}
completes = "time"
[environment]
bottom_depth_m = 40.0
current_ned_m_s = [0.0, 0.2, 0.0]
[start]
depth_m = 10.0
u_m_s = 1.8
n_rpm = 492.0
[sensors.ahrs]
yaw_bias_deg = {{yaw_bias}}
[sensors.dvl]
bias_m_s = 0.0
[[orders]]
t_s = 0.5
arming = "arm"
mode = "mission"
[[waypoints]]
x_m = 400.0
y_m = 0.0
depth_m = 10.0
speed_m_s = 1.8
"""
_BEGIN = """
[[orders]]
t_s = 0.5
arming = "arm"
mode = "hold"
depth_m = 10.0
heading_deg = 0.0
speed_m_s = {speed}
"""


def track(duration: float = 180.0, eddies: float = 0.0, cruise: tuple[float, float] = (1.8, 492.0)) -> Course:
    """Return the track: steps of 2 m every 14 s and, between them, of 25 deg.

    Args:
        duration: s.
        eddies: 1 sigma, m/s.
        cruise: speed, m/s, and what the propeller turns at it, rpm.
    """
    speed, rpm = cruise
    orders, t, there = [], 2.0, True
    while t + _STEP / 2.0 < duration:
        orders.append(f"[[orders]]\nt_s = {t}\ndepth_m = {12.0 if there else 10.0}\n")
        orders.append(f"[[orders]]\nt_s = {t + _STEP / 2.0}\nheading_deg = {25.0 if there else 0.0}\n")
        t, there = t + _STEP, not there
    head = _TRACK.format(duration=duration, eddies=eddies, speed=speed, rpm=rpm)
    return Course("track", head + _ADOPTION + _BEGIN.format(speed=speed) + "".join(orders), 60.0)


def halved(course: Course, at: float = 60.0, to_settle: float = 30.0) -> Course:
    """Return a course on which all four fins lose half of their force."""
    lost = ", ".join(f'"weak:{fin}=50@{at:g}"' for fin in FINS)
    text = course.scenario.replace('completes = "time"', f'completes = "time"\nfaults = [{lost}]', 1)
    return Course(f"{course.name}, fins halved at {at:g} s", text, at + to_settle)


def slow_turns(course: Course) -> Course:
    """Return a course with turns of 2 deg/s, which half a rudder can make too."""
    text = course.scenario.replace("[[orders]]", "[autopilot.guidance]\nturn_rate_max_deg_s = 2.0\n[[orders]]", 1)
    return course._replace(name=f"{course.name}, turns of 2 deg/s", scenario=text)


def demonstration() -> Course:
    """Return the demonstration, whose vehicle file is as wrong as the flight makes it."""
    text = (SCENARIOS / "demo.toml").read_text(encoding="utf-8")
    text = without_factors(text).replace("{", "{{").replace("}", "}}")
    return Course("demonstration", text.replace("[environment]", _ADOPTION + "\n[environment]", 1), 120.0)


def straight_leg() -> Course:
    """Return a leg to the north in a current to the east, without bias of the DVL; {yaw_bias}: of the AHRS, deg."""
    return Course("straight leg", _LEG + _ADOPTION, 60.0)


def without_factors(scenario: str) -> str:
    """Return the text of a scenario without its [vehicle_factors]: its autopilot believes what vehicle.toml has."""
    return re.sub(r"(#[^\n]*\n)*\[vehicle_factors[^\n]*\n([^\[\n][^\n]*\n|\n)*", "", scenario)
