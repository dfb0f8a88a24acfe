"""LOG_*: listed, downloaded, asked for again, and erased only of a disarmed vehicle."""

from __future__ import annotations

import errno
import os
from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.files.tree import LogFile
from firmware_py.records.order import Mode
from tests.unit.firmware_py.mavlink.station import LinkedVehicle, Station, put_together

ONE, TWO = bytes(i * i % 251 for i in range(1000)), bytes(range(180))


class Shelf:
    """Two logs on a disk that answers every second time."""

    def __init__(self) -> None:
        self.files = {"one.mcap": ONE, "two.mcap": TWO}
        self.ready = self.broken = False
        self.erased = 0

    def logs(self) -> Sequence[LogFile] | None:
        if self.broken:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        self.ready = not self.ready
        entries = [
            LogFile(name, len(content), 1_700_000_000 + i, False)
            for i, (name, content) in enumerate(self.files.items())
        ]
        return None if self.ready else entries

    def read(self, name: str, offset: int, n: int) -> bytes | None:
        if name not in self.files:
            raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
        self.ready = not self.ready
        return None if self.ready else self.files[name][offset : offset + n]

    def erase(self) -> bool:
        if self.broken:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        self.ready = not self.ready
        self.erased += not self.ready
        return not self.ready


def vehicle_with_logs() -> tuple[LinkedVehicle, Station, Shelf]:
    vehicle, shelf = LinkedVehicle(), Shelf()
    vehicle.node.offer_logs(shelf)
    return vehicle, vehicle.stations[0], shelf


def listed(vehicle: LinkedVehicle, start: int = 0, end: int = 0xFFFF) -> list[tuple[int, ...]]:
    vehicle.stations[0].send(mavlink.MAVLink_log_request_list_message(1, 1, start, end))
    vehicle.step(10)
    said = vehicle.stations[0].heard("LOG_ENTRY")
    return [(m.id, m.num_logs, m.last_log_num, m.time_utc, m.size) for m in said]


def told(vehicle: LinkedVehicle, number: int, offset: int, count: int, ticks: int = 30) -> list[tuple[int, int, bytes]]:
    vehicle.stations[0].send(mavlink.MAVLink_log_request_data_message(1, 1, number, offset, count))
    vehicle.step(ticks)
    return [(m.id, m.ofs, bytes(m.data[: m.count])) for m in vehicle.stations[0].heard("LOG_DATA")]


def test_logs_are_listed_with_their_sizes_and_times() -> None:
    vehicle, _, _ = vehicle_with_logs()
    entries = [(1, 2, 2, 1_700_000_000, 1000), (2, 2, 2, 1_700_000_001, 180)]
    assert listed(vehicle) == entries
    assert listed(vehicle, 2, 2) == entries[1:]
    assert listed(vehicle, 3, 9) == []
    assert listed(LinkedVehicle()) == [(0, 0, 0, 0, 0)]


def test_a_log_is_told_whole_from_any_place_and_ends_with_a_part_that_is_not_full() -> None:
    vehicle, _, _ = vehicle_with_logs()
    parts = told(vehicle, 1, 0, 2**32 - 1)
    assert [offset for _, offset, _ in parts] == [*range(0, 1000, 90)]
    assert b"".join(data for _, _, data in parts) == ONE
    assert {number for number, _, _ in parts} == {1}
    assert told(vehicle, 1, 500, 100) == [(1, 500, ONE[500:590]), (1, 590, ONE[590:600])]
    assert told(vehicle, 2, 90, 2**32 - 1) == [(2, 90, TWO[90:]), (2, 180, b"")]
    assert told(vehicle, 2, 4_000_000_000, 90) == [(2, 4_000_000_000, b"")]


def test_a_new_request_takes_the_place_of_the_old_and_an_end_ends_it() -> None:
    vehicle, station, _ = vehicle_with_logs()
    told(vehicle, 1, 0, 1000, ticks=3)
    parts = told(vehicle, 2, 0, 180)
    assert {number for number, _, _ in parts} == {2}
    told(vehicle, 1, 0, 1000, ticks=3)
    station.send(mavlink.MAVLink_log_request_end_message(1, 1))
    vehicle.step(20)
    assert station.heard("LOG_DATA") == []


def test_what_is_not_there_or_cannot_be_read_is_said() -> None:
    vehicle, station, shelf = vehicle_with_logs()
    for number in (0, 3):
        station.send(mavlink.MAVLink_log_request_data_message(1, 1, number, 0, 90))
        vehicle.step(5)
        assert [m.text for m in station.heard("STATUSTEXT")] == [f"there is no log {number}"]
    shelf.broken = True
    station.send(mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF))
    vehicle.step(5)
    assert [m.text for m in station.heard("STATUSTEXT")] == ["logs cannot be read: Input/output error"]


def test_a_log_keeps_its_number_though_older_ones_are_removed_meanwhile() -> None:
    vehicle, _, shelf = vehicle_with_logs()
    shelf.files["three.mcap"] = bytes(300)
    listed(vehicle)
    begin = told(vehicle, 2, 0, 90)
    del shelf.files["one.mcap"]
    assert begin + told(vehicle, 2, 90, 2**32 - 1) == [(2, 0, TWO[:90]), (2, 90, TWO[90:]), (2, 180, b"")]
    listed(vehicle)
    assert told(vehicle, 2, 0, 90) == [(2, 0, bytes(90))]


def test_a_log_that_is_gone_is_said_and_ends() -> None:
    vehicle, station, shelf = vehicle_with_logs()
    listed(vehicle)
    told(vehicle, 1, 0, 1000, ticks=3)
    del shelf.files["one.mcap"]
    vehicle.step(5)
    gone = [m for m in station.messages if m.get_type() == "LOG_DATA"]
    assert [(m.id, m.count) for m in gone][-1] == (1, 0)
    assert [m.text for m in station.heard("STATUSTEXT")] == ["logs cannot be read: No such file or directory"]
    station.send(mavlink.MAVLink_log_request_data_message(1, 1, 1, 180, 90))
    vehicle.step(5)
    assert [(m.id, m.ofs, m.count) for m in station.messages if m.get_type() == "LOG_DATA"] == [(1, 180, 0)]
    assert put_together(station.heard("STATUSTEXT")) == ["log 1, one.mcap, was removed; list the logs again"]


def test_logs_are_erased_of_a_disarmed_vehicle_only() -> None:
    vehicle, station, shelf = vehicle_with_logs()
    vehicle.mode = Mode.HOLD
    vehicle.step()
    station.send(mavlink.MAVLink_log_erase_message(1, 1))
    vehicle.step(3)
    assert shelf.erased == 0
    assert [m.text for m in station.heard("STATUSTEXT")] == ["logs are not erased while armed: disarm first"]
    vehicle.mode = Mode.DISARMED
    vehicle.step()
    station.send(mavlink.MAVLink_log_erase_message(1, 1))
    vehicle.step()
    assert not station.heard("STATUSTEXT"), "not yet"
    vehicle.step(2)
    assert shelf.erased == 1
    assert put_together(station.heard("STATUSTEXT")) == ["logs erased, except those that may still be written"]
    bare = LinkedVehicle()
    bare.stations[0].send(mavlink.MAVLink_log_erase_message(1, 1))
    bare.step()
    assert [m.text for m in bare.stations[0].heard("STATUSTEXT")] == ["there are no logs to erase"]


def test_logs_that_cannot_be_erased_are_said() -> None:
    vehicle, station, shelf = vehicle_with_logs()
    shelf.broken = True
    station.send(mavlink.MAVLink_log_erase_message(1, 1))
    vehicle.step(3)
    assert put_together(station.heard("STATUSTEXT")) == ["logs cannot be erased: Input/output error"]


U16, U32 = st.integers(0, 2**16 - 1) | st.integers(0, 3), st.integers(0, 2**32 - 1) | st.integers(0, 1100)


@given(st.lists(st.tuples(st.booleans(), U16, U32, U32), max_size=8))
def test_whatever_is_asked_for_comes_in_small_datagrams(asked) -> None:
    vehicle, station, _ = vehicle_with_logs()
    for data, number, offset, count in asked:
        if data:
            station.send(mavlink.MAVLink_log_request_data_message(1, 1, number, offset, count))
        else:
            station.send(mavlink.MAVLink_log_request_list_message(1, 1, number, offset & 0xFFFF))
        before = len(station.messages)
        vehicle.step()
        assert len(station.messages) - before <= 7
