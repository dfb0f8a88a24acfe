"""Error frames of the kernel's CAN, by what they report (linux/can/error.h)."""

from __future__ import annotations

import pytest

from firmware_py.adapters.buses.socketcan_bus import error_kinds

ERROR = 0x20000000


@pytest.mark.parametrize(
    ("identifier", "second", "kinds"),
    [
        (0x040, 0x00, ["error_bus_off"]),
        (0x004, 0x01, ["error_controller_overflow"]),
        (0x004, 0x08, ["error_warning"]),
        (0x004, 0x10, ["error_passive"]),
        (0x004, 0x20, ["error_passive"]),
        (0x004, 0x40, ["error_active_again"]),
        (0x004, 0x00, ["error_controller"]),
        (0x020, 0x00, ["error_no_acknowledge"]),
        (0x088, 0x00, ["error_protocol", "error_bus"]),
        (0x200, 0x00, ["error_other"]),
    ],
)
def test_an_error_frame_is_counted_by_its_kinds(identifier: int, second: int, kinds: list[str]) -> None:
    assert error_kinds(ERROR | identifier, bytes((0, second, 0, 0, 0, 0, 0, 0))) == kinds
