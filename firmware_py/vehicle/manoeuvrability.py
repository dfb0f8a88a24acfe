"""What the vehicle can still do, by the coefficients in force and by what is known of its fins.

Of one axis, fins reach what those that move make at their limits, beside those that are stuck, while the other axis is
held in balance. For a vector of fin angles d, |d_i| <= L_i, that is the greatest s . d under r . d = 0: by duality the
least sum_i |s_i - k r_i| L_i over k, which lies at some k = s_i / r_i (Boyd and Vandenberghe 2004, ch. 5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware_py.records.adoption import Adopted
from firmware_py.records.health import FinHealth
from firmware_py.records.manoeuvrability import UNLIMITED, Manoeuvrability
from firmware_py.vehicle.linear_models import (
    DivingCoefficients,
    SteeringCoefficients,
    diving_coefficients,
    diving_model,
    steering_coefficients,
)
from firmware_py.vehicle.turning import steady_turn, yaw_axis
from firmware_py.vehicle.vehicle import Vehicle

_TRIM = math.radians(5.0)
"""Pitch that planes must hold, rad."""
_STABLE = 1e-6
"""A hull that is hardly stable on its course turns as tightly as asked, 1/m^2."""
_SPEED_MOST = 10.0
"""m/s; a vehicle without planes can be steered at no speed."""

_Row = Sequence[float]


def reach(row: _Row, other: _Row, limits: _Row, left: Sequence[FinHealth]) -> tuple[float, float]:
    """Return the greatest negative and positive row . d, rad, both >= 0, while other . d = 0, if that can be.

    Args:
        row: what each fin adds to the axis.
        other: what it adds to the axis that is held.
        limits: travel of each fin, rad.
        left: what is left of each fin; empty: all of them are sound.
    """
    left = left or [FinHealth()] * len(row)
    stuck = [fin.stuck if fin.stuck == fin.stuck else 0.0 for fin in left]
    travel = [0.0 if fin.stuck == fin.stuck else fin.effect * most for fin, most in zip(left, limits, strict=True)]
    balanced = abs(_dot(other, stuck)) <= sum([abs(b) * most for b, most in zip(other, travel, strict=True)]) + 1e-9
    multipliers = [a / b for a, b in zip(row, other, strict=True) if b] if balanced else []
    found = []
    for side in (-1.0, 1.0):
        most = min([_bound(row, other, travel, stuck, side, side * k) for k in (0.0, *multipliers)])
        found.append(max(0.0, most))
    return found[0], found[1]


class ManoeuvrabilityModel:
    """Computes `Manoeuvrability`; it keeps the last answer, which its arguments alone determine."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take the vehicle.

        Raises:
            ParamError: no inertia is left.
        """
        self._vehicle, effectiveness = vehicle, vehicle.effectiveness
        self._s, self._r = effectiveness.s, effectiveness.r
        self._limits = tuple([fin.delta_max for fin in vehicle.fins])
        self._files = diving_coefficients(vehicle), steering_coefficients(vehicle)
        self._sound = self._reaches(())
        self._fins: tuple[FinHealth, ...] = ()
        self._damaged = self._moved = self._sound
        self._last: tuple[Adopted | None, tuple[FinHealth, ...]] = None, ()
        self._found = self._computed(*self._files, *self._files, ())

    def of(self, adopted: Adopted | None, left: tuple[FinHealth, ...]) -> Manoeuvrability:
        """Return what it can do by the coefficients in force (None: vehicle.toml's) and what is left of its fins."""
        last, fins = self._last
        if adopted is last and (left is fins or left == fins):
            return self._found
        self._last = adopted, left
        diving, steering = self._files
        if adopted is not None:
            diving, steering = DivingCoefficients(*adopted.diving), SteeringCoefficients(*adopted.steering)
            held = adopted.held_diving or diving, adopted.held_steering or steering
            files = [one if one[0] == one[0] else file for one, file in zip(held, self._files, strict=True)]
            self._found = self._computed(
                diving, steering, DivingCoefficients(*files[0]), SteeringCoefficients(*files[1]), left
            )
        else:
            self._found = self._computed(diving, steering, diving, steering, left)
        return self._found

    def _reaches(self, left: Sequence[FinHealth]) -> tuple[tuple[float, float], tuple[float, float]]:
        return reach(self._s, self._r, self._limits, left), reach(self._r, self._s, self._limits, left)

    def _computed(
        self,
        diving: DivingCoefficients,
        steering: SteeringCoefficients,
        held_diving: DivingCoefficients,
        held_steering: SteeringCoefficients,
        left: tuple[FinHealth, ...],
    ) -> Manoeuvrability:
        """Return what is left: what fins lost may show in the coefficients in force, or not yet: the less counts."""
        vehicle = self._vehicle
        if left is not self._fins:
            self._fins, self._damaged = left, self._reaches(left)
            self._moved = self._reaches([fin._replace(effect=1.0) for fin in left])
        damaged, moved = self._damaged, self._moved
        pitch = diving_model(vehicle, 1.0, diving)
        pitch_held = pitch if held_diving == diving else diving_model(vehicle, 1.0, held_diving)
        damping = -pitch.A[0][0]
        control, control_held = -pitch.b[0], -pitch_held.b[0]
        up, down = (
            min(control * whole_, control_held * part) for whole_, part in zip(moved[0], damaged[0], strict=True)
        )
        gain = _turn_gain(vehicle, steering)
        gain_held = gain if held_steering == steering else _turn_gain(vehicle, held_steering)
        sides = zip(moved[1], damaged[1], strict=True)
        turn = min([min(_curvature(gain, a), _curvature(gain_held, b)) for a, b in sides])
        authority, restoring = min(up, down), -pitch.A[0][1]
        up_left, down_left = (part / whole_ for part, whole_ in zip(damaged[0], self._sound[0], strict=True))
        return Manoeuvrability(
            turn,
            min([part / whole_ for part, whole_ in zip(damaged[1], self._sound[1], strict=True)]),
            up / damping if damping > 0.0 else math.inf,
            min(up_left, 1.0),
            min(up_left, down_left, 1.0),
            1.0 / damping if damping > 0.0 else 0.0,
            _speed(restoring, authority),
        )


def _turn_gain(vehicle: Vehicle, steering: SteeringCoefficients) -> float:
    """Return the curvature of a steady turn by the rudder angle, 1/(m rad); infinite if the hull is not stable."""
    return abs(steady_turn(yaw_axis(vehicle, steering), _STABLE))


def _curvature(gain: float, angle: float) -> float:
    """Return the curvature of a steady turn by this rudder angle, rad, 1/m: none by none, however unstable the hull."""
    return gain * angle if angle > 0.0 else 0.0


def _speed(restoring: float, authority: float) -> float:
    """Return the speed at which planes of an authority at 1 m/s, 1/s^2, hold the trim, m/s."""
    moment = restoring * math.sin(_TRIM)
    if moment <= 0.0:
        return 0.0
    return min(math.sqrt(moment / authority), _SPEED_MOST) if authority > 0.0 else _SPEED_MOST


def _bound(row: _Row, other: _Row, travel: _Row, stuck: _Row, side: float, k: float) -> float:
    """Return the dual bound on side * row . d for one multiplier of the other axis."""
    net = [side * (a - side * k * b) for a, b in zip(row, other, strict=True)]
    return sum([abs(n) * most for n, most in zip(net, travel, strict=True)]) + _dot(net, stuck)


def _dot(row: _Row, angles: _Row) -> float:
    return sum([a * angle for a, angle in zip(row, angles, strict=True)])


__all__ = ["UNLIMITED", "Manoeuvrability", "ManoeuvrabilityModel", "reach"]
