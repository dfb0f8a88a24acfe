"""One flight at a time for a state folder: a second one, by mistake, would overwrite or set aside what is kept."""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from firmware_py.run.usage_error import UsageError

LOCK_FILE = "fly.lock"


@contextlib.contextmanager
def alone_with(state: Path | None) -> Iterator[None]:
    """Hold the folder while the context lasts; the kernel gives it up when the process ends, however that does.

    Raises:
        UsageError: another flight holds it.
    """
    if state is None:
        yield
        return
    try:
        state.mkdir(parents=True, exist_ok=True)
        held = os.open(state / LOCK_FILE, os.O_CREAT | os.O_RDWR, 0o644)
    except OSError:  # that it cannot be written is said by who writes
        yield
        return
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(held)
        raise UsageError(f"--state {state}: another flight uses it; end that one, or choose another folder") from None
    try:
        yield
    finally:
        os.close(held)
