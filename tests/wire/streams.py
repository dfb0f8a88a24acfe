"""What every decoder of a stream of bytes is tried with: a line of STREAMS for each protocol."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from firmware_py.wire.serial import waterlink_dvl
from firmware_py.wire.serial.stream import Decoder


class Stream(NamedTuple):
    """A protocol.

    Attributes:
        decoder: makes a fresh one.
        pieces: good messages as they are on the wire, the first of them one that is read; messages of other kinds too.
        messages: what is read of these.
    """

    decoder: Callable[[], Decoder[Any]]
    pieces: tuple[bytes, ...]
    messages: tuple[Any, ...]


_VELOCITIES = tuple(
    waterlink_dvl.Velocity(1.5, -0.02, 0.1, True, 12.34, 0.005, (1e-6,) * 9, 1000 * k, 1000 * k + 90, 100.0, 0)
    for k in range(2)
)

STREAMS = {
    "waterlink_dvl": Stream(
        waterlink_dvl.lines,
        (
            waterlink_dvl.encode(_VELOCITIES[0]),
            b"wru,0,0.070,1.10,-40,-95*9c\r\n",
            waterlink_dvl.encode(_VELOCITIES[1]),
        ),
        _VELOCITIES,
    ),
}
