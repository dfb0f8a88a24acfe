"""The processor that compiled kernels and the bits of a log depend on."""

from __future__ import annotations

import platform
from itertools import takewhile
from pathlib import Path


def processor(cpuinfo: Path = Path("/proc/cpuinfo")) -> tuple[str, str]:
    """Return (model, flags) of the first processor; x86 and ARM name them differently."""
    try:
        with cpuinfo.open(encoding="utf-8", errors="replace") as file:
            lines = list(takewhile(str.strip, file))
    except OSError:
        return platform.processor() or "unknown", ""
    found = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)}
    model = found.get("model name") or found.get("CPU part") or "unknown"
    return model, found.get("flags") or found.get("Features") or ""
