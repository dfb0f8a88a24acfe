"""A servo that reports nothing: where it is by what it was told, and how well that is known."""

from __future__ import annotations

import math

SERVO_TIME = 0.12
"""Time constant of a servo that obeys, with the way of its command, s."""
PLAY_STD, LAG_STD = math.radians(0.07), 0.05
"""1 sigma of its play, rad, and of that time, s."""


def servo_angle(angle: float, told: float, dt: float) -> float:
    """Return where a servo that was at an angle (rad) is after it was told another one for dt (s)."""
    return angle - (told - angle) * math.expm1(-dt / SERVO_TIME)


def servo_rate(angle: float, told: float) -> float:
    """Return how fast such a servo turns, rad/s."""
    return (told - angle) / SERVO_TIME
