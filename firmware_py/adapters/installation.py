"""Where the program lies: in a checkout, or installed from a wheel."""

from __future__ import annotations

from pathlib import Path

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
