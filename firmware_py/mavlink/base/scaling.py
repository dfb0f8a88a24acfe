"""From numbers to fields: whole units, bounds, and each field's own word for "unknown"."""

from __future__ import annotations

from firmware_py.schedule import NS_PER_S, Tick

INT16, INT32 = (-(2**15) + 1, 2**15 - 1), (-(2**31) + 1, 2**31 - 1)
UINT16 = (0, 2**16 - 2)
"""What a field can say; the number beside a range's end often means "unknown"."""
_U32 = 2**32 - 1


def whole(value: float, unit: float, bounds: tuple[int, int], unknown: int = 0) -> int:
    """`value` in whole units of `unit`, kept within bounds; NaN gives `unknown`."""
    low, high = bounds
    count = value / unit
    if count != count:
        return unknown
    return low if count <= low else high if count >= high else round(count)


def boot_ms(tick: Tick) -> int:
    """time_boot_ms; it wraps after 49 days, as the field does."""
    return tick.t_ns * 1000 // NS_PER_S & _U32


def boot_us(tick: Tick) -> int:
    """Vehicle time in whole us."""
    return tick.t_ns * 1_000_000 // NS_PER_S


def boot_us32(tick: Tick) -> int:
    """The same in a field of 32 bits, which wraps after 71 minutes."""
    return boot_us(tick) & _U32
