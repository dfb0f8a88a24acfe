"""Where the trailing edge of a fin points at a positive angle: what an eye must see, whatever is reported."""

from __future__ import annotations

import math

from firmware_py.vehicle.fins import Fin

_SOME = 0.1


def trailing_edge(fin: Fin) -> str:
    """Return the direction in words.

    A positive angle of a stern plane turns the bow down, one of a rudder to port (`vehicle.Vehicle`): the edge points
    there too. The hinge says how much of either a fin is; a bow plane moves as a stern plane does.
    """
    down, port = math.cos(fin.hinge), math.sin(fin.hinge)
    words = ["down" if down > 0.0 else "up"] if abs(down) > _SOME else []
    if abs(port) > _SOME:
        words.append("to port" if port > 0.0 else "to starboard")
    return " and ".join(words)
