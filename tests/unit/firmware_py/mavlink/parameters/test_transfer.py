"""The parameter protocol: what is listed, set, refused and kept; pymavlink packs and reads every message."""

from __future__ import annotations

import enum
import math
import struct
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.base.modes import Identity
from firmware_py.mavlink.parameters.store import FILE, ParameterStore, shortest
from firmware_py.mavlink.parameters.transfer import ParameterTransfer
from firmware_py.parameter_tree import list_parameters, with_values
from firmware_py.params import ParamError, TakesEffect, load, param, table
from firmware_py.records.order import ParameterChange
from firmware_py.tick import Tick

TICK = Tick(0, 10_000_000)
REAL, INT = mavlink.MAV_PARAM_TYPE_REAL32, mavlink.MAV_PARAM_TYPE_INT32


class Colour(enum.Enum):
    """What it looks like."""

    RED = enum.auto()
    BLUE = enum.auto()


@dataclass(frozen=True)
class Law:
    gain: float = param(0.1, unit="deg", low=-1.0, high=10.0, doc="How strong.", mav="GAIN")
    poles: tuple[float, float] = param((-0.4, -0.5), unit="1/s", low=-5.0, high=-0.01, doc="Where.", mav="POLE")
    count: int = param(7, low=0, high=100_000, doc="How many.", mav="COUNT")
    on: bool = param(True, doc="Whether.", mav="ON")
    colour: Colour = param(Colour.RED, mav="COLOUR", when=TakesEffect.DISARMED)
    size: float = param(1.0, low=0.5, high=2.0, doc="Of its memory.", mav="SIZE", when=TakesEffect.RESTART)
    hidden: float = param(3.0, doc="Nobody sees it.")

    def __post_init__(self) -> None:
        if self.poles[0] == self.poles[1]:
            raise ParamError("poles_1_s: must differ")


@dataclass(frozen=True)
class Toy:
    law: Law = table(Law, mav="L_")


class Checker:
    def __init__(self, record: Toy) -> None:
        self.record = record

    def with_changes(self, values: Mapping[str, Any]) -> Checker:
        return Checker(with_values(self.record, values, "toy.toml"))


class Station:
    """A conversation, and pymavlink at its other end."""

    def __init__(self, book: ParameterStore | None = None, identity: Identity = Identity.ARDUSUB) -> None:
        self.book = book or ParameterStore([*list_parameters(Toy())], Checker(Toy()))
        self.armed = False
        self.said: list[Any] = []
        self.texts: list[str] = []
        self.dropped = 0
        self.service = ParameterTransfer(self.book, self, identity, lambda: self.armed)
        self.k = 0
        self.out, self.back = mavlink.MAVLink(None, 255, 190), mavlink.MAVLink(None, 1, 1)

    def send(self, message: Any) -> None:
        self.said.append(message)

    def send_text(self, text: str, matters: int) -> None:
        self.texts.append(text)

    def send_from_cycle(self, name: int) -> None:
        raise AssertionError

    def count_dropped(self) -> None:
        self.dropped += 1

    def hear(self, message: Any) -> None:
        (heard,) = mavlink.MAVLink(None).parse_buffer(message.pack(self.out))
        self.service.message_handlers()[heard.get_msgId()](TICK, heard)

    def ticks(self, count: int = 40) -> list[Any]:
        """What comes in that many ticks, as the station reads it."""
        ticks = range(self.k, self.k + count)
        self.k += count
        self.said += [message for k in ticks for message in self.service.due(Tick(k, TICK.dt_ns))]
        frames, self.said = b"".join(message.pack(self.back) for message in self.said), []
        return mavlink.MAVLink(None).parse_buffer(frames) or []

    def values(self, count: int = 40) -> list[tuple[str, float]]:
        return [(m.param_id, m.param_value) for m in self.ticks(count) if m.get_type() == "PARAM_VALUE"]

    def errors(self) -> list[tuple[str, int]]:
        return [(m.param_id, m.error) for m in self.ticks() if m.get_type() == "PARAM_ERROR"]

    def list(self) -> list[Any]:
        self.hear(mavlink.MAVLink_param_request_list_message(1, 1))
        return self.ticks()

    def set(self, name: str, value: float, kind: int = REAL) -> None:
        self.hear(mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, kind))

    def integer(self, name: str, value: int) -> None:
        self.set(name, struct.unpack("<f", struct.pack("<i", value))[0], INT)


def kept(book: ParameterStore) -> dict[str, Any]:
    ((name, content),) = book.files_to_save()
    assert name == FILE
    return tomllib.loads(content.decode())


LISTED = [
    ("L_GAIN", REAL, 0.1),
    ("L_POLE1", REAL, -0.4),
    ("L_POLE2", REAL, -0.5),
    ("L_COUNT", INT, 7),
    ("L_ON", INT, 1),
    ("L_COLOUR", INT, 0),
    ("L_SIZE", REAL, 1.0),
]


def test_the_list_tells_every_parameter_in_its_place_and_again_when_asked_again() -> None:
    station = Station()
    for _ in range(2):
        told = station.list()
        assert [(m.param_id, m.param_type, m.param_index, m.param_count) for m in told] == [
            (name, kind, i, len(LISTED)) for i, (name, kind, _) in enumerate(LISTED)
        ]
        assert [m.param_value for m in told] == pytest.approx([value for _, _, value in LISTED])
    station.hear(mavlink.MAVLink_param_request_list_message(1, 1))
    station.ticks(3)
    assert [m.param_index for m in station.list()] == list(range(len(LISTED)))


def test_an_integer_is_cast_for_ardupilots_stations_and_written_bytewise_for_all_others() -> None:
    for identity, form in ((Identity.ARDUSUB, "<f"), (Identity.GENERIC, "<i")):
        station = Station(identity=identity)
        raw = {m.param_id: struct.pack("<f", m.param_value) for m in station.list()}
        assert struct.unpack(form, raw["L_COUNT"]) == (7,)
        assert struct.unpack("<f", raw["L_GAIN"]) == pytest.approx((0.1,))
        if identity is Identity.GENERIC:
            station.integer("L_COUNT", 65_537)
        else:
            station.set("L_COUNT", 65_537.0, INT)
        station.ticks()
        assert kept(station.book) == {"law": {"count": 65_537}}


def test_one_is_read_by_name_or_by_place() -> None:
    station = Station()
    for name, place in ((b"L_POLE2", -1), (b"", 2)):
        station.hear(mavlink.MAVLink_param_request_read_message(1, 1, name, place))
        assert station.values() == [("L_POLE2", -0.5)]


@pytest.mark.parametrize(
    ("name", "place"), [(b"L_HIDDEN", -1), (b"", -1), (b"L_GAIN", 7), (b"L_GAIN", -2), (b"\xff\xfe", -1)]
)
def test_what_is_not_there_is_said_not_to_be_there(name: bytes, place: int) -> None:
    station = Station()
    station.hear(mavlink.MAVLink_param_request_read_message(1, 1, name, place))
    assert [error for _, error in station.errors()] == [mavlink.MAV_PARAM_ERROR_DOES_NOT_EXIST]
    assert station.texts[0].startswith("there is no parameter ")
    station.set("L_HIDDEN", 1.0)
    assert station.errors() == [("L_HIDDEN", mavlink.MAV_PARAM_ERROR_DOES_NOT_EXIST)]
    assert not station.book.changes()


def test_a_value_that_is_set_is_told_to_every_station_ordered_of_the_vehicle_and_kept() -> None:
    station = Station()
    other = Station(station.book, Identity.GENERIC)
    station.set("L_GAIN", 2.3)
    assert station.values() == other.values() == [("L_GAIN", pytest.approx(2.3))]
    assert station.book.changes() == (ParameterChange((("law.gain_deg", 2.3),)),)
    assert kept(station.book) == {"law": {"gain_deg": 2.3}}
    assert not station.book.changes()
    assert not station.book.files_to_save()
    station.set("L_GAIN", 2.3)  # its answer was lost
    assert station.values() == [("L_GAIN", pytest.approx(2.3))]
    assert not station.book.changes()


def test_one_entry_of_a_list_is_ordered_and_kept_with_the_others() -> None:
    station = Station()
    station.set("L_POLE2", -0.75)
    station.ticks()
    assert station.book.changes() == (ParameterChange((("law.poles_1_s", [-0.4, -0.75]),)),)
    assert kept(station.book) == {"law": {"poles_1_s": [-0.4, -0.75]}}


def test_only_what_differs_from_the_files_is_kept() -> None:
    station = Station()
    for name, value in (("L_ON", 0.0), ("L_COLOUR", 1.0), ("L_GAIN", 2.0), ("L_GAIN", 0.1)):
        station.set(name, value)
    station.ticks()
    assert kept(station.book) == {"law": {"on": False, "colour": "blue"}}


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("L_GAIN", 10.5, "L_GAIN stays 0.1: 10.5 is not in [-1, 10] deg"),
        ("L_GAIN", math.nan, "L_GAIN stays 0.1: nan is not a number"),
        ("L_GAIN", -math.inf, "L_GAIN stays 0.1: -inf is not a number"),
        ("L_COUNT", 2.5, "L_COUNT stays 7: 2.5 is not a whole number"),
        ("L_ON", 2.0, "L_ON stays true: 2 is not in [0, 1] (0 false, 1 true)"),
        ("L_COLOUR", 3.0, "L_COLOUR stays red: 3 is not in [0, 1] (0 red, 1 blue)"),
        ("L_POLE1", -0.5, "L_POLE1 stays -0.4: toy.toml: law: poles_1_s: must differ"),
    ],
)
def test_a_value_that_cannot_be_is_refused_with_the_reason_and_the_old_one_echoed(
    name: str, value: float, words: str
) -> None:
    station = Station()
    old = dict(station.book.index)
    station.set(name, value)
    messages = station.ticks()
    assert [m.get_type() for m in messages].count("PARAM_VALUE") == 1
    (echo,) = (m for m in messages if m.get_type() == "PARAM_VALUE")
    assert echo.param_id == name
    assert echo.param_value == pytest.approx({n: v for n, _, v in LISTED}[name])
    (error,) = (m for m in messages if m.get_type() == "PARAM_ERROR")
    assert (error.param_id, error.error) == (name, mavlink.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE)
    assert station.texts == [words]
    assert not station.book.changes()
    assert not station.book.files_to_save()
    assert station.book.index == old


def test_a_number_of_the_other_type_is_refused_where_its_bytes_would_be_misread() -> None:
    station = Station(identity=Identity.GENERIC)
    station.set("L_COUNT", 8.0, REAL)
    station.integer("L_GAIN", 2)
    station.ticks()
    assert station.texts == ["L_COUNT stays 7: it is an INT32", "L_GAIN stays 0.1: it is a REAL32"]
    assert not station.book.changes()


def test_what_would_make_an_armed_vehicle_stumble_waits_until_it_is_disarmed() -> None:
    station = Station()
    station.armed = True
    station.set("L_COLOUR", 1.0)
    assert station.errors() == [("L_COLOUR", mavlink.MAV_PARAM_ERROR_PERMISSION_DENIED)]
    assert station.texts == ["L_COLOUR stays red while armed: disarm to change it"]
    station.set("L_COLOUR", 0.0)  # as it is: nothing to refuse
    station.set("L_GAIN", 1.0)
    assert [name for name, _ in station.values()] == ["L_COLOUR", "L_GAIN"]
    station.armed = False
    station.set("L_COLOUR", 1.0)
    assert station.values() == [("L_COLOUR", 1.0)]


def test_what_waits_for_the_next_start_is_kept_and_shown_but_not_ordered() -> None:
    station = Station()
    station.set("L_SIZE", 1.5)
    assert station.values() == [("L_SIZE", 1.5)]
    assert station.texts == ["L_SIZE takes effect at the next start"]
    assert not station.book.changes()
    assert kept(station.book) == {"law": {"size": 1.5}}


def test_a_storm_of_values_is_tried_one_a_tick_and_no_more_than_so_many_wait() -> None:
    station = Station()
    for k in range(1000):
        station.set("L_GAIN", k / 1000)
    assert len(station.book.changes()) == 0
    assert station.dropped == 1000 - 16
    station.ticks(1)
    assert len(station.book.changes()) == 1
    station.ticks(100)
    assert len(station.book.changes()) == 15


def test_links_try_their_values_in_turn_one_in_a_tick_however_many_wait() -> None:
    first = Station()
    second = Station(book=first.book)
    for i in range(4):
        first.set("L_GAIN", 0.2 + i)
        second.set("L_GAIN", 0.7 + i)
    changed = []
    for k in range(8):
        changed.append([])
        for station in (first, second):
            station.service.due(Tick(k, TICK.dt_ns))
            changed[-1].append(len(station.book.changes()))
    assert changed == [[1, 0], [0, 1]] * 4


def test_the_file_that_is_kept_makes_the_same_values_again() -> None:
    station = Station()
    for name, value in (
        ("L_GAIN", 1.2345678),
        ("L_POLE1", -0.123),
        ("L_COUNT", 12.0),
        ("L_ON", 0.0),
        ("L_COLOUR", 1.0),
    ):
        station.set(name, value)
    station.ticks()
    again = [*list_parameters(load(Toy, kept(station.book), "x"), Toy())]
    assert [(s.name, shortest(s.value)) for s in again] == [(s.name, s.value) for s in station.book.settings]


names = st.sampled_from([name for name, _, _ in LISTED]).map(str.encode) | st.binary(max_size=16)


@given(
    st.lists(st.tuples(names, st.floats(width=32) | st.floats(-10, 10, width=32), st.integers(0, 255)), max_size=30),
    st.sampled_from(Identity),
    st.booleans(),
)
def test_whatever_is_sent_every_value_stays_one_that_can_be(
    sets: list[tuple[bytes, float, int]], identity: Identity, armed: bool
) -> None:
    station = Station(identity=identity)
    station.armed = armed
    for name, value, kind in sets:
        station.hear(mavlink.MAVLink_param_set_message(1, 1, name, value, kind))
        station.ticks(2)
    record = Toy()
    for change in station.book.changes():
        record = with_values(record, dict(change.values), "x")  # raises if it could not be
    now = {s.name: s for s in list_parameters(record)}
    for setting in station.book.settings:
        assert setting.low <= setting.value <= setting.high
        assert not setting.is_integer or setting.value == int(setting.value)
        if setting.when is not TakesEffect.RESTART:
            assert shortest(now[setting.name].value) == shortest(setting.value)


@given(st.decimals(-1000, 1000, places=4, allow_nan=False))
def test_a_number_comes_through_single_precision_as_a_person_wrote_it(number: Any) -> None:
    written = float(number)
    sent = struct.unpack("<f", struct.pack("<f", written))[0]
    assert struct.pack("<f", shortest(sent)) == struct.pack("<f", written)
    if abs(written) < 100:
        assert shortest(sent) == pytest.approx(written, abs=1e-12)
