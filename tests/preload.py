"""What a forked `sternplane` finds imported: all that its sub-commands import when they run."""

from __future__ import annotations

from firmware_py.adapters import kernel_cache

kernel_cache.use()  # before anything imports a kernel

from sternplane.cli import fly  # noqa: E402, F401
from sternplane.sitl import command, plant  # noqa: E402, F401
