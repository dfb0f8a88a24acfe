"""Where the program lies: in a checkout, or installed from a wheel."""

from __future__ import annotations

import os
from pathlib import Path

from firmware_py.params import ParamError

_PACKAGE = Path(__file__).resolve().parents[1]
ROOT = _PACKAGE.parent
"""The folder that holds the packages: the checkout, or where the wheel was installed."""


def is_checkout(root: Path = ROOT) -> bool:
    """Whether the program runs from a checkout; a wheel brings no pyproject.toml."""
    return (root / "pyproject.toml").is_file()


def configs() -> Path:
    """Return the folder of the shipped configurations and scenarios: inside the package in a wheel."""
    packed = _PACKAGE / "configs"
    return packed if packed.is_dir() else ROOT / "configs"


def shipped_vehicles() -> tuple[str, ...]:
    """Return the names of the shipped vehicles: the folders of `configs` that have a vehicle file."""
    return tuple(sorted([path.parent.name for path in configs().glob("*/vehicle.toml")]))


def configuration_folder(named: str | os.PathLike[str]) -> Path:
    """Return the folder of a configuration by what a person calls it.

    A folder that exists is that folder, else NAME and configs/NAME are the shipped vehicle of that name: an installed
    program has no configs/ where it is started. Anything else is returned as it is, to be refused where it is read.
    """
    path = Path(named)
    if not os.path.isdir(path):  # Path.is_dir raises for a name that is too long
        name = path.name if path.parts in ((path.name,), ("configs", path.name)) else ""
        if name in shipped_vehicles():
            return configs() / name
    return path


def configuration_file(named: str | os.PathLike[str]) -> Path:
    """Return a file of a configuration by what a person calls it, as `configuration_folder` does: NAME/FILE."""
    path = Path(named)
    shipped = configuration_folder(path.parent) / path.name
    return path if os.path.lexists(path) or not os.path.isfile(shipped) else shipped


def no_configuration(path: Path) -> ParamError:
    """Return the error of what is no configuration folder: a file of one is told apart."""
    if os.path.isfile(path):
        return ParamError(f"{path}: is a file; give its folder, {path.parent}")
    shipped = ", ".join(shipped_vehicles())
    return ParamError(f"{path}: there is no such configuration folder, nor a shipped vehicle of that name: {shipped}")
