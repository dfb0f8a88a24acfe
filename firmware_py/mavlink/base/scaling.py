"""Conversion of numbers to message fields: whole units, bounds, and the field's value for "unknown"."""

from __future__ import annotations

from firmware_py.tick import NS_PER_S, Tick

INT16, INT32 = (-(2**15) + 1, 2**15 - 1), (-(2**31) + 1, 2**31 - 1)
UINT16 = (0, 2**16 - 2)
"""The range of a field; the number just outside often means "unknown"."""
_U32 = 2**32 - 1


def whole(value: float, unit: float, bounds: tuple[int, int], unknown: int = 0) -> int:
    """Return `value` in whole units of `unit`, clipped to `bounds`; `unknown` for NaN."""
    low, high = bounds
    count = value / unit
    if count != count:
        return unknown
    return low if count <= low else high if count >= high else round(count)


def boot_ms(tick: Tick) -> int:
    """Return time_boot_ms; it wraps after 49 days, as the field does."""
    return tick.t_ns * 1000 // NS_PER_S & _U32


def boot_us(tick: Tick) -> int:
    """Return the vehicle time in whole us."""
    return tick.t_ns * 1_000_000 // NS_PER_S


def boot_us32(tick: Tick) -> int:
    """Return the vehicle time in us for a field of 32 bits; it wraps after 71 minutes."""
    return boot_us(tick) & _U32
