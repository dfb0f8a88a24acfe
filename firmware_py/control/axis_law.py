"""The interface of a law that moves one control: depth by stern planes, or heading by rudder."""

from __future__ import annotations

from typing import Protocol

from firmware_py.vehicle.linear_models import LinearModel, Vector3


class AxisLaw(Protocol):
    """A law with one input: sliding mode or PID."""

    def schedule(self, model: LinearModel, speed_ratio: float, caution: float) -> None:
        """Adapt the law to another speed.

        Args:
            model: the linear model at that speed.
            speed_ratio: that speed over the trim speed, > 0.
            caution: in [0, 1], how little is known of the model.
        """

    def update(self, error: Vector3, delta_ff: float, limit: float, dt: float) -> tuple[float, float]:
        """Return the fin angle (rad, within +-`limit`) and the sliding variable sigma (0 if the law has none).

        Args:
            error: x - x_d of the linear model's three states.
            delta_ff: feed-forward fin angle, rad.
            limit: greatest fin angle, rad.
            dt: step, s.
        """

    def reset(self) -> None:
        """Clear the integral."""

    def freeze(self) -> float:
        """Return the whole memory."""

    def thaw(self, memory: float) -> None:
        """Restore the memory that `freeze` returned."""
