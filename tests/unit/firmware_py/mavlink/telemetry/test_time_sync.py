"""Clocks compared: TIMESYNC, PING, and a date that stations tell."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.unit.firmware_py.mavlink.station import LinkedVehicle

DATE_US = 1_700_000_000_000_000


def test_timesync_is_answered_with_vehicle_time_and_only_a_request_is() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    for k, ns in ((0, 1), (1, 10_000_000), (250, 2_500_000_000)):
        vehicle.step(k - vehicle.k)
        station.heard("TIMESYNC")
        station.send(mavlink.MAVLink_timesync_message(0, -123_456_789_012_345))
        vehicle.step()
        assert [(m.tc1, m.ts1) for m in station.heard("TIMESYNC")] == [(ns, -123_456_789_012_345)]
    station.send(mavlink.MAVLink_timesync_message(5, 7))
    vehicle.step(3)
    assert station.heard("TIMESYNC") == []


def test_a_ping_is_answered_to_who_asked_and_an_answer_is_not() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    station.send(mavlink.MAVLink_ping_message(DATE_US, 42, 0, 0))
    station.send(mavlink.MAVLink_ping_message(DATE_US, 43, 1, 1))
    vehicle.step(3)
    said = [(m.time_usec, m.seq, m.target_system, m.target_component) for m in station.heard("PING")]
    assert said == [(DATE_US, 42, 255, 190)]


@pytest.mark.parametrize(("told", "date"), [(DATE_US, DATE_US), (5, 0), (2**64 - 1, 0)])
def test_a_date_is_told_on_all_links_once_a_station_knows_it(told: int, date: int) -> None:
    vehicle = LinkedVehicle(links=2)
    vehicle.step(100)
    assert {m.time_unix_usec for m in vehicle.stations[1].heard("SYSTEM_TIME")} == {0}
    vehicle.stations[0].send(mavlink.MAVLink_system_time_message(told, 77))
    vehicle.step(100)
    (said,) = vehicle.stations[1].heard("SYSTEM_TIME")
    assert said.time_unix_usec == (date + (said.time_boot_ms - 1000) * 1000 if date else 0)
