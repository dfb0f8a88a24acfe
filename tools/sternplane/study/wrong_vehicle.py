"""Makes a configuration whose vehicle file is wrong on purpose."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.toml_files import read_toml
from sternplane.identification.vehicle_file import write


def spoiled(shipped: Path, folder: Path, spoil: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """Copy a configuration to `folder`, which must not exist, and return its vehicle file as `spoil` leaves it."""
    shutil.copytree(shipped, folder)
    table = read_toml(shipped / "vehicle.toml")
    spoil(table)
    write(folder / "vehicle.toml", table, "Wrong on purpose.")
    return table


def scaled(factors: Mapping[str, float]) -> Callable[[dict[str, Any]], None]:
    """Return what multiplies coefficients of a vehicle file by `factors`."""

    def spoil(table: dict[str, Any]) -> None:
        for name, factor in factors.items():
            table["coefficients"][name] *= factor

    return spoil
