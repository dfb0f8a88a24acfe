"""Numbers of UDP buses for tests: each is one test's alone, on the whole machine, while it holds it."""

from __future__ import annotations

import contextlib
import itertools
import socket
import time
from collections.abc import Iterator

_NUMBERS = range(1, 10)
"""But 0, the program's default: somebody may fly on it."""


@contextlib.contextmanager
def free_number() -> Iterator[int]:
    """Yield the number of a bus that no other test on this machine is using; wait for one if need be."""
    with socket.socket(socket.AF_UNIX) as lock:
        for number in itertools.cycle(_NUMBERS):
            try:
                lock.bind(f"\0sternplane-test-bus-{number}")
                break
            except OSError:
                time.sleep(0.02)
        yield number
