"""The fin angle that one axis demands: the law's, with the excitation of a learning manoeuvre."""

from __future__ import annotations

from firmware_py.marine import clip


def fin_demand(delta: float, excitation: float, grip: float, limit: float, fade: float) -> float:
    """Return the fin angle to demand, rad.

    Args:
        delta: fin angle of the law, rad.
        excitation: fin angle of the manoeuvre, rad; 0 without one.
        grip: share of the law's angle, in [0, 1]; 1 without a manoeuvre.
        limit: greatest angle of the sum, rad.
        fade: factor in [0, 1] by which fins are reduced at low speed.
    """
    return fade * clip(grip * delta + excitation, -limit, limit)
