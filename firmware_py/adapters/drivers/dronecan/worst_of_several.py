"""Sensors of one kind on one node, told apart by an id in their messages: the one that tells the worst is heard.

Two that were heard in turn would be one that jumps to and fro, and no jump would ever be confirmed
(`estimation/integrity/confirmation.py`): a wet compartment beside a dry one would be no leak.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Generic, NamedTuple, TypeVar

from firmware_py.records.sensing import Battery, Heard
from firmware_py.wire.dronecan import equipment_messages as eq

VALID_RANGE, TOO_CLOSE = 1, 2
SLOW_S = 3.0
"""A battery or hygrometer that was not heard for longer than this, s, is left out; they report about once a second."""
ALTIMETER_S = 1.0
"""The same of an altimeter: the others are heard again before the altitude is unknown."""

M = TypeVar("M")


class Measured(NamedTuple):
    """What one of several sensors tells.

    Attributes:
        id: which of them.
        badness: the more, the worse; -inf if it knows nothing.
        heard: its value.
    """

    id: int
    badness: float
    heard: Heard[Any]


class WorstOfSeveral(Generic[M]):
    """Follows one sensor, until another one tells worse, or it falls silent. What is heard is always a new value.

    Args:
        read: what a message of a time, s, tells.
        timeout: a sensor that was not heard for longer than this, s, is left out.
    """

    def __init__(self, read: Callable[[M, float], Measured], timeout: float) -> None:
        self._read, self._timeout = read, timeout
        self._id, self._badness, self._t = -1, -math.inf, -math.inf

    def hear(self, message: M, t: float, believed: bool) -> Heard[Any] | None:
        """Return what a message of time t, s, tells; None if another sensor told worse. One not believed is told on."""
        one = self._read(message, t)
        recent = t - self._t <= self._timeout
        if believed and recent and one.id != self._id and one.badness <= self._badness:
            return None
        self._id, self._badness, self._t = one.id, one.badness if believed else -math.inf, t
        return one.heard


def hygrometers() -> WorstOfSeveral[eq.Hygrometer]:
    """Return what hears the wettest hygrometer."""
    return WorstOfSeveral(_humidity, SLOW_S)


def batteries() -> WorstOfSeveral[eq.BatteryInfo]:
    """Return what hears the least charged pack: in series it ends all of them, in parallel that is on the safe side."""
    return WorstOfSeveral(_battery, SLOW_S)


def altimeters() -> WorstOfSeveral[eq.RangeMeasurement]:
    """Return what hears the altimeter that is nearest to the bottom; no altitude is told while that is too near."""
    return WorstOfSeveral(_range, ALTIMETER_S)


def _humidity(message: eq.Hygrometer, t: float) -> Measured:
    value = message.humidity / 100.0
    ok = math.isfinite(value)
    return Measured(message.id, value if ok else -math.inf, Heard(value, t, True, ok))


def _battery(message: eq.BatteryInfo, t: float) -> Measured:
    charge = message.state_of_charge_pct / 100.0 if message.state_of_charge_pct <= 100 else math.nan
    value, ok = Battery(message.voltage, message.current, charge), math.isfinite(message.voltage)
    known = ok and not math.isnan(charge)
    return Measured(message.battery_id, -charge if known else -math.inf, Heard(value, t, True, ok))


def _range(message: eq.RangeMeasurement, t: float) -> Measured:
    ok = message.reading_type == VALID_RANGE and math.isfinite(message.range)
    badness = -message.range if ok else math.inf if message.reading_type == TOO_CLOSE else -math.inf
    return Measured(message.sensor_id, badness, Heard(message.range, t, True, ok))
