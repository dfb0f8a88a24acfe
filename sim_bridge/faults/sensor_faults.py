"""Faults of sensors: what becomes of a reading between the instrument and its wire."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from sim_bridge.devices.sensors import Corruption, Reading
from sim_bridge.faults.channels import CHANNELS, base_of, channel_of

OUTLIERS = 0.05
"""Share of values that a lasting `spike` hits."""


def changed(channel: str, change: Callable[[float, float], float]) -> Corruption:
    """Return what changes one channel: `change` takes its value (SI) and time of validity (s).

    What could not be measured, such as a velocity without bottom lock, stays so.
    """
    known = channel_of(channel)

    def corrupt(reading: Reading[Any]) -> Reading[Any]:
        value, t = reading
        return reading if value is None else Reading(known.put(value, change(known.get(value), t)), t)

    return corrupt


def lost(share: float, random: np.random.Generator) -> Corruption:
    """Return what loses a share of all readings, in [0, 1]."""
    return lambda reading: None if random.random() < share else reading


def frozen() -> Corruption:
    """Return what repeats the first value that it sees, each time as a new one."""
    held: list[Any] = []

    def corrupt(reading: Reading[Any]) -> Reading[Any]:
        if not held:
            held.append(reading.value)
        return Reading(held[0], reading.t_valid)

    return corrupt


def not_a_number(sensor: str) -> Corruption:
    """Return what makes every channel of a sensor NaN."""
    base = base_of(sensor)
    faults = [changed(name, lambda _x, _t: math.nan) for name, channel in CHANNELS.items() if channel.sensor == base]

    def corrupt(reading: Reading[Any]) -> Reading[Any] | None:
        for fault in faults:
            reading = fault(reading) or reading
        return reading

    return corrupt


def spike(channel: str, height: float, random: np.random.Generator, once: bool) -> Corruption:
    """Return what moves single values of a channel by `height`: the first, or one of twenty."""
    hit = changed(channel, lambda x, _t: x + height)
    struck = math.nan

    def corrupt(reading: Reading[Any]) -> Reading[Any] | None:
        nonlocal struck
        if math.isnan(struck):
            struck = reading.t_valid
        strikes = reading.t_valid == struck if once else random.random() < OUTLIERS
        return hit(reading) if strikes else reading

    return corrupt
