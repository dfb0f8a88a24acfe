"""Provenance of a log: the version that wrote it, and the processor and libraries that its bits depend on."""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
from collections.abc import Mapping
from typing import Any

from firmware_py import __version__
from firmware_py.adapters.processor import processor
from firmware_py.chosen_parts import described
from firmware_py.own_parts import NO_OWN_PARTS, OwnParts
from firmware_py.run.version import git_revision

_COMPUTING = ("numpy", "numba", "llvmlite")
_DISTRIBUTIONS = (*_COMPUTING, "python-can", "pyserial", "pymavlink", "mcap", "zstandard")


def fingerprint() -> dict[str, str]:
    """Return what must be equal for two runs to give the same bits.

    The compiled kernels use whatever the processor has (its flags), and `math` is the C library's.
    """
    model, flags = processor()
    return {
        "machine": platform.machine(),
        "cpu": model,
        "cpu flags": hashlib.sha256(" ".join(sorted(flags.split())).encode()).hexdigest()[:16],
        "libc": " ".join(platform.libc_ver()).strip() or "unknown",
        "python": platform.python_version(),
        **{name: _version(name) for name in _COMPUTING},
    }


def difference(logged: Mapping[str, str], here: Mapping[str, str]) -> str:
    """Return what differs, such as "cpu: EPYC there, Cortex-A72 here"; "" if nothing does."""
    names = [name for name in here if logged.get(name) != here[name]]
    return "; ".join(f"{name}: {logged.get(name, 'unknown')} there, {here[name]} here" for name in names)


def versions() -> dict[str, str]:
    """Return the version of every library that a run uses."""
    return {name: _version(name) for name in _DISTRIBUTIONS}


def header(
    scenario: str, configuration: Mapping[str, Any], own: OwnParts = NO_OWN_PARTS, **more: Any
) -> dict[str, Any]:
    """Return the header of a log: all that a replay needs, and the provenance; `own` are the parts of one's own."""
    if parts := described(own):
        more["own_parts"] = parts
    return {
        "scenario": scenario,
        **more,
        "version": __version__,
        "git": git_revision(),
        "machine": fingerprint(),
        "versions": versions(),
        "mission": configuration["mission"],
        "configuration": configuration,
    }


def _version(distribution: str) -> str:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"
