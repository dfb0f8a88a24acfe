"""What the procedure of coming up remembers from one tick to the next."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.command import AscentStage


class AscentMemory(NamedTuple):
    """What the procedure remembers.

    Attributes:
        stage: the present one.
        begun: when SURFACE was entered, s.
        since: when the stage began, s.
        pitch: the desired pitch, rad.
        z: depth in the last tick, m.
        z_dot: its low-passed rate of change, m/s.
        least: the depth from which "deeper" counts: the least since SURFACE or a new attempt began, m.
        best: the least depth that counted as progress, m.
        t_best: when it was reached, or depth or a fix last told of the surface, s.
        gathers: how much longer it may be without progress, s, for it began at rest and gathers way first.
        off: for how long the pitch has been off, s.
        rolled: for how long the roll has been large, s.
        z_begun: depth when SURFACE was entered, m.
        altitude_begun: altitude then, m; NaN if it was unknown.
        climbed: height made since then by attitude and velocity, m.
        t_near: since when it has been near the surface, s; NaN while it is not.
        t_up: when a good depth was last less than `surface_depth`, s.
        t_fix: since when a fix has been heard, s; NaN while none is.
        most: the altitude from which less counts: the greatest since SURFACE or a new attempt began, m.
        t_told: when it was last told that the vehicle waits, s.
        asked: whether the release was asked for, or made before; without a weight that is said once in each SURFACE.
        drop: whether the weight is released, for good.
        heavy: whether it sank with its bow up, so that it drives with full power to the end of SURFACE.
    """

    stage: AscentStage = AscentStage.NONE
    begun: float = 0.0
    since: float = 0.0
    pitch: float = 0.0
    z: float = 0.0
    z_dot: float = 0.0
    least: float = math.inf
    best: float = math.inf
    t_best: float = 0.0
    gathers: float = 0.0
    off: float = 0.0
    rolled: float = 0.0
    z_begun: float = 0.0
    altitude_begun: float = math.nan
    climbed: float = 0.0
    t_near: float = math.nan
    t_up: float = -math.inf
    t_fix: float = math.nan
    most: float = math.nan
    t_told: float = 0.0
    asked: bool = False
    drop: bool = False
    heavy: bool = False
