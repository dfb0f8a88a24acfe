"""Says what a vehicle waits for: a bus that is not there, a port, a link to a station."""

from __future__ import annotations

from collections.abc import Callable

from firmware_py.records.cycle import Cycle
from firmware_py.tick import NS_PER_S, Rate

_AGAIN_NS = 60 * NS_PER_S


class DeviceWatch:
    """Asks once a second; tells what is missing at once, and again every minute, and when it is there.

    Args:
        tell: takes a sentence.
        status: takes all that is missing, in one line, whenever it changes.
    """

    def __init__(self, tell: Callable[[str], None], status: Callable[[str], None] = lambda _line: None) -> None:
        self._tell, self._status = tell, status
        self._missing: dict[str, Callable[[], str]] = {}
        self._last: dict[str, str] = {}
        self._again_ns: dict[str, int] = {}

    def add(self, name: str, missing: Callable[[], str]) -> None:
        """Watch a device; `missing` returns why it is not there, or nothing."""
        self._missing[name] = missing

    def update(self, cycle: Cycle) -> None:
        """Look at all of them once a second."""
        if not cycle.tick.every(Rate.HZ_1):
            return
        t_ns, before = cycle.tick.t_ns, self._last
        self._last = now = {name: why for name, missing in self._missing.items() if (why := missing())}
        for name, why in now.items():
            if name not in before or t_ns >= self._again_ns[name]:
                self._again_ns[name] = t_ns + _AGAIN_NS
                self._tell(f"waiting for {name}: {why}")
        for name in before:
            if name not in now:
                self._tell(f"{name} is there")
        if now.keys() != before.keys() or not t_ns:
            self._status(f"waiting for {', '.join(now)}" if now else "every device and link is there")
