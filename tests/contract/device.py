"""What a device brings to the contract of drivers: its own words, written without the codec under test."""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.records.sensing import Ahrs, Dvl, Fix

ATTITUDES = (
    Ahrs(0.1, -0.2, 1.5, 0.01, -0.02, 0.03),
    Ahrs(-0.3, 0.4, -2.5, -0.5, 0.25, 1.0),
    Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
)
FAR_ATTITUDES = (Ahrs(3.1, 1.5, -3.1, 20.0, -20.0, 20.0), Ahrs(-3.1, -1.5, 3.1, -20.0, 20.0, -20.0))
VELOCITIES = (Dvl(1.5, -0.25, 0.125, 0.01, 20.0), Dvl(-0.5, 0.25, -0.05, 0.02, 3.5), Dvl(0.0, 0.0, 0.0, 0.005, 50.0))
FAR_VELOCITIES = (Dvl(9.5, -9.5, 9.5, 5.0, 199.0), Dvl(-9.5, 9.5, -9.5, 0.001, 0.05))
FIXES = (Fix(0.64, -2.13, 2.0), Fix(-0.25, 1.5, 4.5), Fix(1e-4, -1e-4, 1.0))
FAR_FIXES = (Fix(1.5707, 3.1415, 900.0), Fix(-1.5707, -3.1415, 0.1))


@dataclass(frozen=True)
class Device:
    """A device at the far end of a stream of bytes.

    Attributes:
        name: of the instrument.
        instrument: the driver's side of it.
        truths: three different measurements of its role.
        extremes: the largest and smallest ones that it can tell.
        encode: the bytes of a measurement, stamped with the time of the device's own clock, s.
        corrupt: the same bytes with what its checksum alone tells to be wrong, their form left as it is: a digit or a
            number that is another one. Without a checksum, with what their form tells.
        doubtful: measurements that the device does not vouch for, as bytes.
        tolerance: of what it tells, in the units of the role: of all its numbers, or of each.
        delay: by how much a measurement is older than its arrival, as the device tells, s.
        clocked: it tells the time of its own clock.
        summed: what it sends has a checksum.
        family: devices of one family understand one another.
    """

    name: str
    instrument: Instrument
    truths: tuple[Any, Any, Any]
    extremes: tuple[Any, ...]
    encode: Callable[[Any, float], bytes]
    corrupt: Callable[[bytes], bytes]
    doubtful: tuple[bytes, ...]
    tolerance: float | tuple[float, ...] = 1e-6
    delay: Callable[[Any], float] = field(default=lambda _: 0.0)
    clocked: bool = False
    summed: bool = True
    family: str = ""

    def __str__(self) -> str:
        return self.name


def xor_line(body: str) -> bytes:
    """A line in the form of NMEA 0183."""
    return b"$%s*%02X\r\n" % (body.encode(), functools.reduce(operator.xor, body.encode()))


def damaged(content: bytes) -> bytes:
    """The bytes with a bit in their middle turned round, within a digit where they are text."""
    odd = bytearray(content)
    odd[len(odd) // 2] ^= 1
    return bytes(odd)
