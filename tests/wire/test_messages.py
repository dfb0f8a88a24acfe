"""Layouts, ids and signatures are DSDL's; bytes are pydronecan's; a bad payload is a DecodeError and nothing else."""

from __future__ import annotations

import itertools
import math
import struct

import pytest
from dronecan.transport import f16_from_f32
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.wire.dronecan import bitwise_codec
from firmware_py.wire.dronecan import equipment_messages as eq
from firmware_py.wire.dronecan import message_table as m
from firmware_py.wire.dronecan import node_messages as nodes
from firmware_py.wire.dronecan.dsdl_types import (
    Boolean,
    DecodeError,
    DsdlArray,
    Float,
    Integer,
    Struct,
    Union,
    Void,
    array,
    float16,
    max_bits,
    min_bits,
    struct_of,
    union,
    upto,
)
from firmware_py.wire.dronecan.message_table import BY_ID, TransferKind

TYPES = list(BY_ID.values())
NAMES = [f"{kind.name.rpartition('.')[2]}-{kind.kind.name.lower()}" for kind in TYPES]
RENAMED = {"param_index": "index"}
every_type = pytest.mark.parametrize("kind", TYPES, ids=NAMES)

EDGES = (0.0, -0.0, 65504.0, 65519.9, 65520.0, -70000.0, 2.0**-24, 2.0**-25, 5e-8, 1.0 + 2.0**-11, 3.5e38, -3.5e38)


def values(layout):
    """Values of a layout, in range and out of it."""
    match layout:
        case Integer(n, signed, _):
            low = -(1 << n - 1) if signed else 0
            inside = st.integers(low, low + (1 << n) - 1)
            if n == 64:  # where pydronecan's own limit of int64 is 2^63, one too many
                return inside
            return inside | st.integers(-(2 << n), 2 << n) | st.sampled_from((low, low + (1 << n) - 1, -1))
        case Boolean():
            return st.booleans()
        case Float():
            return st.floats(-100.0, 100.0) | st.floats() | st.floats(width=16) | st.sampled_from(EDGES)
        case DsdlArray(Integer(8, False, False), length, dynamic):
            return st.binary(min_size=0 if dynamic else length, max_size=length)
        case DsdlArray(item, length, dynamic):
            items = values(item)
            if not dynamic:
                return st.tuples(*[items] * length)
            few = st.lists(items, max_size=min(4, length)).map(tuple)
            return few | st.lists(items, min_size=length, max_size=length).map(tuple)
        case Struct(record, parts):
            return st.tuples(*[values(p) for p in parts if not isinstance(p, Void)]).map(lambda v: record(*v))
        case Union(record, alternatives):
            tagged = [st.tuples(st.just(tag), values(a)) for tag, a in enumerate(alternatives)]
            return st.one_of(tagged).map(lambda v: record(*v))
    raise AssertionError(layout)


def same(a, b):
    """Equal to the sign of zero, and NaN equals NaN."""
    return repr(a) == repr(b)


@every_type
def test_a_type_is_what_its_definition_says(kind, peer):
    definition = peer.definition(kind)
    longest = {
        TransferKind.MESSAGE: "get_max_bitlen",
        TransferKind.REQUEST: "get_max_bitlen_request",
        TransferKind.RESPONSE: "get_max_bitlen_response",
    }[kind.kind]
    assert kind.data_type_id == definition.default_dtid
    assert kind.signature == definition.get_data_type_signature()
    assert kind.crc_seed == definition.base_crc
    assert (kind.kind is TransferKind.MESSAGE) == (definition.kind == definition.KIND_MESSAGE)
    assert [RENAMED.get(name, name) for name in kind.record._fields] == peer.fields(kind)
    assert kind.max_bytes == math.ceil(getattr(definition, longest)() / 8)


@every_type
@settings(max_examples=25)  # of each type; rounding has cases of its own below
@given(data=st.data())
def test_bytes_are_those_of_pydronecan_both_ways(kind, peer, data):
    record = data.draw(values(struct_of(kind.record)))
    payload = kind.encode(record)
    assert payload == peer.encode(kind, record)
    decoded = kind.decode(payload)
    assert type(decoded) is kind.record
    assert same(decoded, peer.decode(kind, payload))
    assert kind.encode(decoded) == payload


@every_type
@settings(max_examples=25)  # of each type; rounding has cases of its own below
@given(data=st.data())
def test_the_fast_codec_does_what_the_exact_one_does(kind, data):
    layout = struct_of(kind.record)
    record = data.draw(values(layout))
    payload = bitwise_codec.encode(layout, record)
    assert kind.encode(record) == payload
    assert same(kind.decode(payload), bitwise_codec.decode(layout, payload))
    assert same(kind.decode(bytearray(payload)), kind.decode(payload))


@every_type
@given(payload=st.binary(max_size=80))
def test_any_bytes_are_a_record_or_a_decode_error(kind, payload):
    try:
        record = kind.decode(payload)
    except DecodeError:
        with pytest.raises(DecodeError):
            bitwise_codec.decode(struct_of(kind.record), payload)
    else:
        assert same(record, bitwise_codec.decode(struct_of(kind.record), payload))
        assert len(kind.encode(record)) == len(payload)


FIXED = [kind for kind in TYPES if min_bits(struct_of(kind.record)) == max_bits(struct_of(kind.record))]


@pytest.mark.parametrize("kind", FIXED, ids=lambda kind: kind.name)
def test_a_payload_too_short_or_too_long_is_refused(kind):
    for length in range(kind.max_bytes + 4):
        if length != kind.max_bytes:
            with pytest.raises(DecodeError, match="payload"):
                kind.decode(bytes(length))


def test_a_length_beyond_the_array_is_refused():
    payload = bytearray(m.AHRS_SOLUTION.encode(solution()))
    payload[15] = 10  # orientation_covariance holds at most 9
    with pytest.raises(DecodeError, match="at most 9"):
        m.AHRS_SOLUTION.decode(bytes(payload) + bytes(20))
    with pytest.raises(DecodeError, match="15 items"):
        m.ARRAY_COMMAND.decode(bytes(64))
    with pytest.raises(DecodeError, match="tag"):
        m.GET_SET.decode(bytes((0, 7)))


def test_a_record_that_no_payload_can_say_is_refused():
    with pytest.raises(ValueError, match="at most 15"):
        m.ARRAY_COMMAND.encode(eq.ArrayCommand((eq.ActuatorCommand(0, 1, 0.0),) * 16))
    short = nodes.HardwareVersion(unique_id=b"15 bytes only..")
    answer = nodes.GetNodeInfoResponse(nodes.NodeStatus(0), nodes.SoftwareVersion(), short, b"")
    with pytest.raises(ValueError, match="must be 16"):
        m.GET_NODE_INFO_RESPONSE.encode(answer)
    with pytest.raises(ValueError, match="tag 5"):
        m.GET_SET.encode(nodes.GetSetRequest(0, nodes.Value(5, 0), b""))
    with pytest.raises(TypeError):
        m.NODE_STATUS.encode(nodes.NodeStatus(1.5))


def solution():
    return eq.AhrsSolution(0x01020304050607, (0.0, 0.5, -0.5, 1.0), (), (1.0, 2.0, -2.0), (), (0.0, 0.0, 9.8125), ())


# By hand: float16 1 is 0x3C00, 0.5 0x3800, 2 0x4000, 9.8125 = 1.2265625 * 2^3 0x48E8; float32 101325 is 0x47C5E680.
GOLDEN = [
    (m.STATIC_PRESSURE, eq.StaticPressure(101325.0, 1.0), "80e6c547 003c"),
    (m.NODE_STATUS, nodes.NodeStatus(0x01020304, 2, 3, 5, 0xABCD), "04030201 9d cdab"),
    (m.AHRS_SOLUTION, solution(), "07060504030201 0000 0038 00b8 003c 00 003c 0040 00c0 00 0000 0000 e848"),
    (
        m.ARRAY_COMMAND,
        eq.ArrayCommand((eq.ActuatorCommand(7, 1, -0.5),)),
        "07 01 00b8",
    ),
    (m.RPM_COMMAND, eq.RpmCommand((0x0ABCD, -1)), "cdab 3ffff0"),
    (m.TICK, nodes.LockstepTick(5, 50_000_000, 9, 1), "05000000 80f0fa0200000000 0900 01"),
    (m.TICK_DONE, nodes.LockstepTickDone(5, 3), "05000000 0300"),
    (m.GET_NODE_INFO, nodes.GetNodeInfoRequest(), ""),
    (m.ALLOCATION, nodes.Allocation(73, True, b"\x01\x02\x03\x04\x05\x06"), "93 010203040506"),
    (m.GLOBAL_TIME_SYNC, nodes.GlobalTimeSync(0x01020304050607), "07060504030201"),
    (m.LOG_MESSAGE, nodes.LogMessage(nodes.LogLevel(2), b"node", b"no"), "44 6e6f6465 6e6f"),
    (m.KEY_VALUE, nodes.KeyValue(1.0, b"ctd.t"), "0000803f 6374642e74"),
    (m.EXECUTE_OPCODE, nodes.ExecuteOpcodeRequest(1, -2), "01 feffffffffff"),
    (m.EXECUTE_OPCODE_RESPONSE, nodes.ExecuteOpcodeResponse(0, True), "000000000000 80"),
    (m.RESTART_NODE, nodes.RestartNodeRequest(), "1e1b55ceac"),
    (
        m.GET_TRANSPORT_STATS_RESPONSE,
        nodes.GetTransportStatsResponse(1, 2, 3, (nodes.CanIfaceStats(4, 5, 6),)),
        "010000000000 020000000000 030000000000 040000000000 050000000000 060000000000",
    ),
]


@pytest.mark.parametrize(("kind", "record", "payload"), GOLDEN, ids=[g[0].name for g in GOLDEN])
def test_golden_bytes(kind, record, payload):
    assert kind.encode(record).hex() == payload.replace(" ", "")
    assert kind.decode(bytes.fromhex(payload)) == record


def test_float16_rounds_as_libuavcan_at_ties():
    """Every seventh tie between two float16, what is next to it as float64 and as float32, both signs."""
    finite = struct.unpack("<31744e", struct.pack("<31744H", *range(31744)))
    single = struct.Struct("<f")
    for low, high in list(itertools.pairwise(finite))[::7]:
        tie = 0.5 * (low + high)
        below = struct.unpack("<f", struct.pack("<I", struct.unpack("<I", single.pack(tie))[0] - 1))[0]
        middle = 0.5 * (tie + below)  # rounds to the tie as float32
        for value in (
            tie,
            math.nextafter(tie, 0.0),
            math.nextafter(tie, 1e9),
            below,
            middle,
            math.nextafter(middle, 0.0),
        ):
            assert bitwise_codec.half(value) == f16_from_f32(value)
            assert bitwise_codec.half(-value) == f16_from_f32(-value)


def test_layouts_that_no_message_has_are_exact():
    """By hand: 3 bits of length, 3 flags, a float16 that begins within a byte; and a tag of one bit."""
    flags = Struct(lambda *fields: fields, (upto(Boolean(), 5), array(float16, 1)))
    assert bitwise_codec.encode(flags, ((True, False, True), (1.0,))) == bytes.fromhex("7400f0")
    assert bitwise_codec.decode(flags, bytes.fromhex("7400f0")) == ((True, False, True), (1.0,))
    either = union(nodes.Value, Integer(8), Integer(16))
    assert bitwise_codec.encode(either, (1, 0x1234)) == bytes.fromhex("9a0900")
    assert bitwise_codec.decode(either, bytes.fromhex("9a0900")) == (1, 0x1234)


def test_ids_are_unique_and_lockstep_is_vendor_specific():
    assert len(BY_ID) == len(TYPES)
    assert all(20000 <= kind.data_type_id < 21000 for kind in (m.TICK, m.TICK_DONE))
