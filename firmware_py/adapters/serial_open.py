"""A serial device opened by pyserial, for drivers and for links to ground stations."""

from __future__ import annotations

import termios
from typing import Any

import serial


def open_serial(device: str, baud: int, **options: Any) -> Any:
    """Return an open port that never waits and that nobody else may open.

    Raises:
        OSError, ValueError: it cannot be opened.
    """
    try:
        return serial.Serial(device, baud, timeout=0, exclusive=True, **options)
    except termios.error as error:  # of a device that goes in the middle of the opening; pyserial lets it through
        raise OSError(*error.args) from None
