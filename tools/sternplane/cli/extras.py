"""The libraries that draw are an extra: what to install where they are missing."""

from __future__ import annotations

from importlib.util import find_spec

from firmware_py.run.usage_error import UsageError

_DRAWING = ("plotly", "jinja2", "matplotlib")
HINT = "pip install 'sternplane[report]'"
"""What installs them."""


def missing() -> list[str]:
    """Return the libraries of the extra `report` that are not installed."""
    return [name for name in _DRAWING if find_spec(name) is None]


def require(extra: str, *libraries: str) -> None:
    """Refuse a command that cannot do without libraries that are not installed.

    Args:
        extra: of the package, that has them.
        libraries: by the names under which they are imported.

    Raises:
        UsageError: what is missing, and how to install it.
    """
    if absent := [name for name in libraries if find_spec(name) is None]:
        raise UsageError(f"this needs {', '.join(absent)}: pip install 'sternplane[{extra}]'")


def require_report() -> None:
    """Refuse a command that draws where it cannot.

    Raises:
        UsageError: what is missing, and how to install it.
    """
    if absent := missing():
        raise UsageError(f"this command draws, and needs {', '.join(absent)}: {HINT}")
