"""Error frames of the kernel's CAN (linux/can/error.h): what they report, and what state of the bus follows."""

from __future__ import annotations

import pytest

from firmware_py.adapters.buses.bus_health import BusHealth, error_kinds

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


OFF, RESTARTED = (0x040, 0x00), (0x100, 0x00)
WARNING, PASSIVE, ACTIVE = (0x004, 0x08), (0x004, 0x20), (0x004, 0x40)


@pytest.mark.parametrize(
    ("reported", "states"),
    [
        ([WARNING, PASSIVE, WARNING, ACTIVE], [True, False, True, True]),
        ([PASSIVE, OFF, RESTARTED], [False, False, True]),
        ([PASSIVE, (0x020, 0x00), (0x080, 0x00)], [False, False, False]),
        ([OFF, PASSIVE, ACTIVE], [False, False, True]),
    ],
)
def test_the_state_of_the_bus_follows_what_the_controller_reports(reported, states) -> None:
    health, found = BusHealth(), []
    for identifier, second in reported:
        health.hear_error(ERROR | identifier, bytes((0, second, 0, 0, 0, 0, 0, 0)))
        found.append(health.sound)
    assert found == states
    assert sum(health.errors.values()) == len(reported)


def test_a_frame_that_came_ends_bus_off_and_one_that_was_taken_ends_down_alone() -> None:
    health = BusHealth()
    health.fail()
    assert (health.sound, health.counts()) == (False, {"down": 1})
    health.carry(received=False)
    assert (health.sound, health.counts()) == (True, {})
    health.hear_error(ERROR | 0x40, bytes(8))
    health.carry(received=False)
    assert health.counts() == {"error_bus_off": 1, "off": 1}
    health.carry(received=True)
    assert (health.sound, health.counts()) == (True, {"error_bus_off": 1})


@pytest.mark.parametrize("reported", [PASSIVE, OFF])
def test_an_interface_that_is_brought_up_again_begins_sound(reported) -> None:
    health = BusHealth()
    health.hear_error(ERROR | reported[0], bytes((0, reported[1], 0, 0, 0, 0, 0, 0)))
    health.fail()
    assert {*health.counts()} & {"down", "off", "passive"} == {"down"}
    health.carry(received=False)
    assert (health.sound, {*health.counts()} & {"down", "off", "passive"}) == (True, set())


def test_a_frame_that_came_does_not_end_error_passive() -> None:
    health = BusHealth()
    health.hear_error(ERROR | PASSIVE[0], bytes((0, PASSIVE[1], 0, 0, 0, 0, 0, 0)))
    health.carry(received=True)
    assert health.counts() == {"error_passive": 1, "passive": 1}


def test_an_error_frame_without_data_is_counted() -> None:
    assert error_kinds(ERROR | 0x004, b"") == ["error_controller"]
