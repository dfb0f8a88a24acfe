"""Records as CDR: every bit comes back, and a foreign decoder reads the same."""

from __future__ import annotations

import dataclasses
import math
import struct
import types
import typing
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap_ros2.decoder import DecoderFactory

from firmware_py.records.command import Applied, FinCommand
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import NOTHING_LEARNED
from firmware_py.records.event import Event
from firmware_py.records.health import GOOD, Candidate, Role, sound
from firmware_py.records.manoeuvrability import UNLIMITED
from firmware_py.records.order import BESIDE, Mode, Order
from firmware_py.records.sensing import ROLES, Heard, silence
from firmware_py.wire.log import ros2_schema
from firmware_py.wire.log.cdr_codec import CdrCodec, closing_records
from firmware_py.wire.log.ros2_schema import Layout, SchemaError

FINS = 4
ODD = [math.nan, -0.0, math.inf, -math.inf, 5e-324, 1.7976931348623157e308, 0.1]
PAYLOAD = struct.unpack("<d", struct.pack("<Q", 0x7FF8_DEAD_BEEF_0001))[0]
FLOATS = st.floats(allow_nan=True) | st.sampled_from([*ODD, PAYLOAD])
TEXTS = st.text(max_size=30)


def records(hint: Any) -> st.SearchStrategy[Any]:
    """Any record of that type, with tuples of `FINS` where they may have any length."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if hint is float:
        return FLOATS
    if hint is int:
        return st.integers(-(2**63), 2**63 - 1)
    if hint is bool:
        return st.booleans()
    if origin is types.UnionType:
        return st.none() | st.sampled_from(args[0])
    if args == (str, ...):
        return st.lists(TEXTS, max_size=4).map(tuple)
    if hint == tuple[Event, ...]:
        return st.lists(EVENTS, max_size=3).map(tuple)
    if origin is tuple:
        return st.tuples(*[records(args[0])] * (FINS if args[-1] is ... else len(args)))
    if isinstance(hint, type) and issubclass(hint, int):
        return st.sampled_from(hint)
    cls = origin or hint
    hints = typing.get_type_hints(cls)
    parts = {n: records(args[0] if isinstance(hints[n], typing.TypeVar) else hints[n]) for n in logged(cls)}
    return st.builds(cls, **parts)


def logged(cls: Any) -> list[str]:
    if not dataclasses.is_dataclass(cls):
        return list(cls._fields)
    return [f.name for f in dataclasses.fields(cls) if BESIDE not in f.metadata]


EVENTS = st.builds(
    Event,
    **{name: records(hint) for name, hint in typing.get_type_hints(Event).items() if name != "numbers"},
    numbers=st.lists(FLOATS, max_size=4).map(tuple),
)
CYCLES = records(Cycle)


def flat(value: Any) -> list[Any]:
    """All leaves in order, floats as their bits, each with its type."""
    if dataclasses.is_dataclass(value):
        return [leaf for f in dataclasses.fields(value) for leaf in flat(getattr(value, f.name))]
    if isinstance(value, tuple):
        return [type(value), len(value), *(leaf for item in value for leaf in flat(item))]
    return [type(value), struct.pack("<d", value) if isinstance(value, float) else value]


@pytest.fixture(scope="module")
def codec() -> CdrCodec[Cycle]:
    fins = (0.0,) * FINS
    flags = (False,) * FINS
    learned = dataclasses.replace(NOTHING_LEARNED, value=fins, std=fins, valid=flags, excited=flags)
    blank = dict.fromkeys(("tick", "order", "mode", "reference", "demand"))
    nothing = silence(FINS)
    frame = dataclasses.replace(nothing, **{f"spare_{role}": (getattr(nothing, role),) * FINS for role in ROLES})
    sample: Any = Cycle(
        frame=frame,
        state=SimpleNamespace(learned=learned, candidates=(Candidate(Role.AHRS, 0, True, GOOD),) * FINS),
        actuators=sound(FINS),
        adopted=SimpleNamespace(diving=fins, steering=fins, held_diving=fins, held_steering=fins, refuted=flags[:2]),
        left=UNLIMITED,
        fins=FinCommand(fins, 0.0),
        applied=Applied(fins, 0.0, False, False),
        events=(),
        **blank,
    )
    return CdrCodec.like(sample)


@given(cycle=CYCLES)
def test_every_bit_of_a_cycle_comes_back(codec: CdrCodec[Cycle], cycle: Cycle) -> None:
    data = codec.encode(cycle)
    again = codec.decode(data)
    assert flat(again) == flat(cycle)
    assert codec.encode(again) == data


@given(cycle=CYCLES)
@settings(max_examples=40)
def test_a_ros2_decoder_reads_the_same(codec: CdrCodec[Cycle], cycle: Cycle) -> None:
    schema: Any = type("S", (), {"id": 1, "name": codec.name, "encoding": "ros2msg", "data": codec.schema.encode()})()
    decode = DecoderFactory().decoder_for("cdr", schema)
    assert decode is not None
    message = decode(codec.encode(cycle))

    def same(ours: Any, theirs: Any) -> None:
        if dataclasses.is_dataclass(ours) or hasattr(ours, "_fields"):
            for name in logged(type(ours)):
                same(getattr(ours, name), getattr(theirs, name))
        elif isinstance(ours, tuple):
            assert len(ours) == len(theirs)
            for a, b in zip(ours, theirs, strict=True):
                same(a, b)
        elif isinstance(ours, str):
            assert theirs.rstrip("\0") == ours.rstrip("\0")
        else:
            assert flat(theirs)[-1] == flat(-1 if ours is None else ours)[-1]

    same(cycle, message)


@given(cycles=st.lists(CYCLES, min_size=1, max_size=4))
@settings(max_examples=25)
def test_columns_hold_what_the_records_hold(codec: CdrCodec[Cycle], cycles: list[Cycle]) -> None:
    layout = Layout(
        ros2_schema.parse_schema("Cycle", codec.schema)
    )  # from the schema alone, as a reader of old logs has it
    data = [codec.encode(cycle) for cycle in cycles]
    columns = layout.columns(data)
    assert columns["frame.fins.value"].shape == (len(cycles), FINS)
    for i, cycle in enumerate(cycles):
        assert columns["applied.fins"][i].tobytes() == struct.pack(f"<{FINS}d", *cycle.applied.fins)
        assert columns["frame.fins.ok"][i].tolist() == [fin.ok for fin in cycle.frame.fins]
        assert columns["reference.waypoint"][i] == cycle.reference.waypoint
        assert columns["order.mode"][i] == (-1 if cycle.order.mode is None else cycle.order.mode)
        learned = cycle.state.learned
        assert columns["state.learned.value"][i].tobytes() == struct.pack(f"<{FINS}d", *learned.value)
        assert columns["state.learned.valid"][i].tolist() == list(learned.valid)
        assert columns["state.learned.nis"].shape == (len(cycles), 3)
        assert columns["state.learned.resets"][i] == learned.resets
        closing = closing_records(Event, layout)
        assert flat(closing(data[i])) == flat(cycle.events)


def test_bytes_are_those_of_the_standard() -> None:
    """Written out by hand: encapsulation, then each number aligned to its size from behind it."""

    class Small(NamedTuple):
        flag: bool
        level: float
        order: Mode | None
        count: int
        words: tuple[str, ...]

    golden = (
        "00010000"  # CDR_LE, no options
        "01" "00000000000000"  # flag, padding to 8
        "000000000000f83f"  # level 1.5
        "ff" "00000000000000"  # order None, padding to 8
        "feffffffffffffff"  # count -2
        "02000000"  # two strings
        "03000000" "686900" "00"  # "hi" with its zero, padding to 4
        "01000000" "00"  # ""
    )  # fmt: skip
    codec = CdrCodec.like(Small(False, 0.0, None, 0, ()))
    small = Small(True, 1.5, None, -2, ("hi", ""))
    assert codec.encode(small).hex() == golden
    assert codec.decode(bytes.fromhex(golden)) == small
    assert "int8 ORDER_NONE=-1\nint8 ORDER_DISARMED=0" in codec.schema


def test_structs_of_unequal_stride_stand_where_cdr_puts_them() -> None:
    """An array's items are aligned field by field: the second `Heard` begins at 24, behind 18 bytes and padding."""

    class Hub(NamedTuple):
        fins: tuple[Heard[float], ...]

    hub = Hub((Heard(1.0, 2.0, True, False), Heard(3.0, 4.0, False, True)))
    codec = CdrCodec.like(hub)
    data = codec.encode(hub)[4:]
    assert data == struct.pack("<dd??6xdd??", 1.0, 2.0, True, False, 3.0, 4.0, False, True)
    assert codec.layout.columns([codec.encode(hub)])["fins.t_valid"].tolist() == [[2.0, 4.0]]


def test_lists_of_flags_and_of_counts_stand_item_by_item() -> None:
    class Flags(NamedTuple):
        valid: tuple[bool, ...]
        counts: tuple[int, ...]
        pair: tuple[bool, bool]

    flags = Flags((True, False, True), (-1, 2**62), (False, True))
    codec = CdrCodec.like(flags)
    data = codec.encode(flags)
    assert data[4:] == struct.pack("<???5xqq??", True, False, True, -1, 2**62, False, True)
    assert codec.decode(data) == flags
    assert codec.schema == "bool[3] valid\nint64[2] counts\nbool[2] pair\n"
    assert codec.layout.columns([data, data])["valid"].tolist() == [[True, False, True]] * 2


def test_a_codec_made_of_the_schema_is_the_same(codec: CdrCodec[Cycle]) -> None:
    again = CdrCodec.of(Cycle, codec.schema)
    assert (again.name, again.schema, again.layout.format) == (codec.name, codec.schema, codec.layout.format)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("float64 u_d", "float64 speed_d"),
        ("int64 late_ns\n", ""),
        ("ARMING_ARM=1", "ARMING_ARM=3"),
        ("sternplane/Demand demand", "sternplane/Demands demand"),
        ("bool leak", "complex64 leak"),
    ],
)
def test_another_versions_schema_is_refused(codec: CdrCodec[Cycle], old: str, new: str) -> None:
    assert old in codec.schema
    with pytest.raises(SchemaError):
        CdrCodec.of(Cycle, codec.schema.replace(old, new, 1))


def test_a_tuple_of_another_length_is_refused(codec: CdrCodec[Cycle]) -> None:
    cycle: Any = dataclasses.replace
    found = codec.decode(bytes(codec.layout.size))
    for wrong in ((0.0,) * 3, (0.0,) * 5):
        with pytest.raises(ValueError, match="unpack"):
            codec.encode(cycle(found, applied=Applied(wrong, 0.0, False, False)))


def test_no_length_is_a_length() -> None:
    @dataclasses.dataclass(frozen=True)
    class Learned:
        coefficients: tuple[float, ...]
        n: int

    Learned.__annotations__ = {"coefficients": tuple[float, ...], "n": int}
    codec = CdrCodec.like(Learned((), 7))
    assert codec.decode(codec.encode(Learned((), 7))) == Learned((), 7)
    assert "coefficients" not in codec.schema  # ROS 2 knows no array of length zero
    assert CdrCodec.of(Learned, codec.schema).decode(codec.encode(Learned((), 7))) == Learned((), 7)


def test_what_cannot_be_logged_is_refused_at_once() -> None:
    class Loose(NamedTuple):
        anything: list[float]

    class Capital(NamedTuple):
        M_q: float

    class Early(NamedTuple):
        words: tuple[str, ...]
        n: int

    for sample, words in ((Loose([]), "anything"), (Capital(1.0), "lower case"), (Early((), 1), "must be last")):
        with pytest.raises(SchemaError, match=words):
            CdrCodec.like(sample)


@given(columns=st.lists(st.sampled_from(ODD), min_size=1, max_size=5))
def test_single_numbers_keep_sign_and_kind(columns: list[float]) -> None:
    class One(NamedTuple):
        value: float

    codec = CdrCodec.like(One(0.0))
    values = codec.layout.columns([codec.encode(One(v)) for v in columns])["value"]
    assert values.tobytes() == np.array(columns).tobytes()


def test_orders_of_none_and_of_every_mode_come_back() -> None:
    codec = CdrCodec.like(Order())
    for mode in (None, *Mode):
        assert codec.decode(codec.encode(Order(mode=mode))).mode is mode
