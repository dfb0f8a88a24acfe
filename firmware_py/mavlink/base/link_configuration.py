"""What a link is like, apart from what goes over it."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.mavlink.base.modes import Identity


class LinkConfiguration(NamedTuple):
    """For whom the vehicle is taken here; how many bytes a second go through; whether they come without datagrams.

    At a door of high latency HIGH_LATENCY2 goes out, and else only what was asked for.
    """

    identity: Identity
    bytes_per_s: float = math.inf
    stream: bool = False
    high_latency: bool = False
