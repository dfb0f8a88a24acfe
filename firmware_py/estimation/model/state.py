"""The layout of the filter's state: x* = (motion, water, sensor biases, parameters), paper Eq. 13.

Motion: u v w p q r (over ground) phi theta psi. Water: nothing, the steady current (north, east), or the current and
eddies about it (north, east, down), m/s. Then a bias for each sensor that has one, then the parameters.
"""

from __future__ import annotations

MOTIONS = ("u", "v", "w", "p", "q", "r", "phi", "theta", "psi")
"""Names of the motion states."""
PHI, THETA, PSI = 6, 7, 8
MOVING = 9
"""How many motion states there are; the water's states begin here."""
STILL, CURRENT, EDDIES = 0, 2, 5
"""How many states the water has."""
CURRENT_NORTH, CURRENT_EAST, EDDY_NORTH, EDDY_EAST, EDDY_DOWN = range(MOVING, MOVING + EDDIES)
WATER_END = MOVING + EDDIES
"""Behind the last state of water with eddies."""
WATER_AXIS = (0, 1, 0, 1, 2)
"""The axis (north, east, down) along which each state of the water flows."""

EQUATIONS = 6
"""X Y Z K M N: a parameter moves the vehicle by a force in one of these."""
WATER = 9
"""Column of Phi where the water's velocity (north, east, down) begins, behind the motion states."""
WIDTH = 16
"""Columns of Phi and the like, whole vectors of the processor: nine motion states, three of the water's velocity."""
LINEAR, ANGULAR = slice(0, 3), slice(3, 6)
"""The velocities u v w and the rates p q r."""
