"""What a log's bits depend on besides our own sources: the processor, and the libraries that compute."""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
_COMPUTING = ("numpy", "numba", "llvmlite")
_DISTRIBUTIONS = (*_COMPUTING, "python-can", "pyserial", "mcap", "rich", "plotly")


def fingerprint() -> dict[str, str]:
    """What must be equal for two runs to give the same bits.

    The compiled kernels use whatever the processor has (its flags), and `math` is the C library's.
    """
    model, flags = _processor()
    return {
        "machine": platform.machine(),
        "cpu": model,
        "cpu flags": hashlib.sha256(" ".join(sorted(flags.split())).encode()).hexdigest()[:16],
        "libc": " ".join(platform.libc_ver()).strip() or "unknown",
        "python": platform.python_version(),
        **{name: _version(name) for name in _COMPUTING},
    }


def difference(logged: Mapping[str, str], here: Mapping[str, str]) -> str:
    """One clause for what differs, "" if nothing does: "cpu: EPYC there, Cortex-A72 here"."""
    names = [name for name in here if logged.get(name) != here[name]]
    return "; ".join(f"{name}: {logged.get(name, 'unknown')} there, {here[name]} here" for name in names)


def versions() -> dict[str, str]:
    """Version of every library that takes part in a run."""
    return {name: _version(name) for name in _DISTRIBUTIONS}


def header(scenario: str, configuration: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    """What a log begins with: all that a replay needs, and where the log comes from."""
    return {
        "scenario": scenario,
        **more,
        "git": git_revision(),
        "machine": fingerprint(),
        "versions": versions(),
        "mission": configuration["mission"],
        "configuration": configuration,
    }


def git_revision(root: Path = ROOT) -> str:
    """The commit of the sources, "-dirty" behind it when they were changed since; "unknown" where git cannot say."""
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return done.stdout.strip() or "unknown"


def _version(distribution: str) -> str:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _processor(cpuinfo: Path = Path("/proc/cpuinfo")) -> tuple[str, str]:
    """(model, flags) of the first processor; x86 and ARM name them differently."""
    try:
        lines = cpuinfo.read_text().partition("\n\n")[0].splitlines()
    except OSError:
        return platform.processor() or "unknown", ""
    found = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)}
    model = found.get("model name") or found.get("CPU part") or "unknown"
    return model, found.get("flags") or found.get("Features") or ""
