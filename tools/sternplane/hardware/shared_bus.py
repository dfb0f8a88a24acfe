"""A bus that a bench tool shares with the devices."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from firmware_py.run.options import BUSES
from firmware_py.run.usage_error import UsageError


@contextlib.contextmanager
def shared_bus(spec: str, *, standard: bool = False) -> Iterator[CanBus]:
    """Yield a bus that other processes are on too; with `standard` its frames with ids of 11 bits come as well.

    Raises:
        BusError, UsageError: in one line, why there is none.
    """
    if spec.startswith("virtual"):
        raise UsageError(f"bus {spec}: a virtual bus ends at its process; give --bus {BUSES}")
    with contextlib.closing(open_bus(spec, standard=standard)) as bus:
        yield bus
