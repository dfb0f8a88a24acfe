"""The properties of a link, apart from what is sent over it."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.mavlink.base.modes import Identity


class LinkConfiguration(NamedTuple):
    """The identity shown on a link, its capacity, and whether bytes arrive as a stream or as datagrams.

    A high-latency link sends HIGH_LATENCY2, and otherwise only what a station asks for.
    """

    identity: Identity
    bytes_per_s: float = math.inf
    stream: bool = False
    high_latency: bool = False
