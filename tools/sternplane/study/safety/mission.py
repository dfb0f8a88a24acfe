"""The missions that faults strike: a dive as in the demonstration, down to 28 m; and the long quiet ones."""

from __future__ import annotations

from collections.abc import Sequence

from sternplane.study.waypoints import waypoint

ONSETS = (20.0, 52.0, 100.0)
"""When a fault begins, s: in 5 m, at the beginning of a dive in 9 m, and at its end, in 25 m, still diving."""
PLACES = ("5 m", "9 m", "25 m")
"""About how deep it is then."""
DEPTH_MAX, BOTTOM = 30.0, 40.0
"""The rule's limit and the depth of the water, m."""
_PATIENCE, _LONGEST = 450.0, 1200.0
"""A vehicle at cruise is given up after so long, s, and one that still flies its mission; a slower one has longer."""
QUIET = 600.0
"""A flight without faults, s."""

_HEAD = """
description = "The safety study."
duration_s = {duration}
completes = "surfaced"
faults = {faults}
[environment]
bottom_depth_m = {bottom}
turbulence_m_s = {eddies}
{profile}
[start]
{start}
{learning}
[autopilot.safety]
depth_max_m = {depth_max}
[[orders]]
t_s = 0.5
arming = "arm"
[[orders]]
t_s = 1.0
mode = "mission"
"""
_NOISE = """
[sensors]
ahrs = { roll_pitch_noise_deg = 0.6, yaw_noise_deg = 1.0, gyro_noise_deg_s = 0.1 }
pressure = { noise_pa = 100.0 }
dvl = { noise_m_s = 0.02, altitude_noise_m = 0.04 }
altimeter = { noise_m = 0.06 }
fix = { noise_m = 4.0 }
battery = { noise_v = 0.04 }
leak = { noise_pct = 1.0 }
"""
_COARSE = """
[sensors]
pressure = { noise_pa = 1.0 }
"""
_UNDER_WAY = """depth_m = 4.0
u_m_s = {speed}
n_rpm = {rpm}"""
_AFLOAT = "depth_m = 0.0"
_NO_LEARNING = """[autopilot.estimation.learning]
enabled = false
"""
CRUISE = {"npsauv2": (1.8, 492.0), "remus100": (1.5, 1461.0), "torpedo_x": (1.5, 1461.0)}
"""The vehicles that are flown: their speed, m/s, and what the propeller turns at it, rpm."""
NPS = "npsauv2"
_LEGS = ((45.0, 0.0, 6.0), (85.0, 15.0, 10.0), (175.0, 30.0, 28.0), (205.0, 20.0, 28.0))
"""North, east, depth, m."""


def patience(vehicle: str, speed: float = 0.0) -> float:
    """Return the patience of the judge with a vehicle, s; its speed is 0 at cruise, m/s."""
    return _PATIENCE * _slower(vehicle, speed)


def scenario(
    faults: Sequence[str],
    *,
    eddies: float = 0.0,
    learning: bool = True,
    profile: Sequence[tuple[float, float]] = (),
    watch: float = 0.0,
    vehicle: str = NPS,
    afloat: bool = False,
    coarse: bool = False,
    speed: float = 0.0,
    bottom: float = BOTTOM,
    duration: float = 0.0,
) -> str:
    """Return the scenario of one flight with faults.

    Args:
        faults: each as `faults.fault` reads it.
        eddies: 1 sigma, m/s.
        learning: whether the coefficients are learned on the way.
        profile: (north, depth) of the bottom, m; none is flat.
        watch: for how long it is watched after it surfaced and disarmed itself, s.
        vehicle: one of CRUISE.
        afloat: whether it begins at rest at the surface.
        coarse: whether the pressure has less noise than a Bar30 has steps.
        speed: of the mission, m/s; 0 is the cruise of the vehicle.
        bottom: how deep the water is where no profile says so, m.
        duration: when it is cut off, s; 0 is long after a vehicle should have come up.
    """
    cruise, rpm = CRUISE[vehicle]
    speed = speed or cruise
    start = _AFLOAT if afloat else _UNDER_WAY.format(speed=speed, rpm=rpm * speed / cruise)
    head = _head(faults, duration or _LONGEST * _slower(vehicle, speed), eddies, learning, profile, start, bottom)
    return f"watch_s = {watch}\n" + head + "".join([waypoint(place, speed) for place in _LEGS]) + _COARSE * coarse


def quiet_scenario(duration: float, *, eddies: float, learning: bool = True) -> str:
    """Return a flight that goes on for its whole time, with turns and changes of depth, at twice the stated noise."""
    legs = []
    for i in range(int(duration / 25.0) + 2):
        legs.append((45.0 * (i + 1), 15.0 * (i % 2), 6.0 + 6.0 * (i // 2 % 3)))
    return (
        _head((), duration, eddies, learning, (), _UNDER_WAY.format(speed=CRUISE[NPS][0], rpm=CRUISE[NPS][1]), BOTTOM)
        + "".join([waypoint(place, CRUISE[NPS][0]) for place in legs])
        + _NOISE
    )


def _slower(vehicle: str, speed: float) -> float:
    cruise, _ = CRUISE[vehicle]
    return cruise / (speed or cruise)


def _head(
    faults: Sequence[str],
    duration: float,
    eddies: float,
    learning: bool,
    profile: Sequence[tuple[float, float]],
    start: str,
    bottom: float,
) -> str:
    points = ", ".join(f"{{ north_m = {north}, depth_m = {depth} }}" for north, depth in profile)
    return _HEAD.format(
        duration=duration,
        faults=list(faults),
        bottom=bottom,
        eddies=eddies,
        profile=f"bottom = [{points}]" if profile else "",
        start=start,
        learning="" if learning else _NO_LEARNING,
        depth_max=DEPTH_MAX,
    )
