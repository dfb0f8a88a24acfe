"""What a flight is connected to besides its devices, on a CAN bus as over HIL."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.ports import Ground, Recorder


class Session(NamedTuple):
    """What gives orders to a flight, keeps it, ends it and tells of it.

    Attributes:
        ground: the source of orders.
        recorder: writes the log.
        stop: asked at every tick.
        say: prints a line, such as real-time options that are not permitted.
        losses: is given the counts of lost, refused and malformed messages.
    """

    ground: Ground
    recorder: Recorder
    stop: Callable[[], bool]
    say: Callable[[str], None]
    losses: LossWatch
