"""param.pck, read by pymavlink's own decoder; and the metadata files with their checksums."""

from __future__ import annotations

import json
import struct
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from pymavlink.mavftp import MAVFTP

from firmware_py.mavlink.parameters import metadata
from firmware_py.mavlink.parameters.packed_file import pack
from firmware_py.mavlink.parameters.store import ParameterStore
from firmware_py.parameter_tree import Parameter
from firmware_py.params import TakesEffect
from tests.unit.firmware_py.mavlink.station import cycle


def setting(name: str, value: float, whole: bool = False, base: float | None = None, **more) -> Parameter:
    said = {
        "key": "law.gain_deg",
        "index": -1,
        "default": value,
        "unit": "deg",
        "low": -1e6,
        "high": 1e6,
        "choices": (),
        "refused": (),
        "group": "law",
        "doc": "How strong.",
        "when": TakesEffect.AT_ONCE,
    }
    return Parameter(name=name, value=value, base=value if base is None else base, is_integer=whole, **(said | more))


def test_the_bytes_of_a_small_file_are_those_of_the_format() -> None:
    packed = pack([setting("AB_C", 2.0, whole=True), setting("AB_CD", 0.5), setting("AB_X", 1.0, base=4.0)], True)
    assert packed == (
        struct.pack("<HHH", 0x671C, 3, 3)
        + b"\x03\x30AB_C" + struct.pack("<i", 2)
        + b"\x04\x04D" + struct.pack("<f", 0.5)
        + b"\x14\x03X" + struct.pack("<ff", 1.0, 4.0)
    )  # fmt: skip


names = st.lists(st.text("AB_1", min_size=1, max_size=16), unique=True, min_size=1, max_size=60)
values = st.floats(-1e6, 1e6, width=32)


@given(names, st.data(), st.booleans())
def test_another_decoder_reads_names_values_and_defaults(names: list[str], data: st.DataObject, defaults: bool) -> None:
    listed = []
    for name in names:
        whole = data.draw(st.booleans())
        number = st.integers(-(2**31), 2**31 - 1).map(float) if whole else values
        listed.append(setting(name, data.draw(number), whole, data.draw(number)))
    read = MAVFTP.ftp_param_decode(pack(listed, defaults))
    assert read is not None
    assert [(name.decode(), value) for name, value, _ in read.params] == [(s.name, s.value) for s in listed]
    if defaults:
        assert [(name.decode(), value) for name, value, _ in read.defaults] == [(s.name, s.base) for s in listed]


class Nobody:
    def with_changes(self, values):
        raise AssertionError


BOOK = ParameterStore(
    [
        setting("L_GAIN", 2.5, low=-1.0, high=10.0, default=0.5),
        setting("L_POLE2", -0.5, key="law.poles_1_s", index=1, unit="1/s", default=None, when=TakesEffect.DISARMED),
        setting("L_ON", 1.0, True, unit="", low=0.0, high=1.0, choices=("false", "true"), when=TakesEffect.RESTART),
        setting("L_ACT", 2.0, True, low=0.0, high=2.0, choices=("none", "hold", "surface"), refused=("hold",)),
    ],
    Nobody(),
)


def crc32_by_the_bit(content: bytes) -> int:
    crc = 0
    for byte in content:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xEDB88320 * (crc & 1)
    return crc


@given(st.binary(max_size=200))
def test_the_checksum_begins_with_nothing_and_is_not_inverted(content: bytes) -> None:
    assert metadata.crc32(content) == crc32_by_the_bit(content)


def test_the_general_file_says_where_the_parameters_are_and_their_checksum() -> None:
    files = {name: make() for name, make in metadata.files(BOOK).items()}
    general = json.loads(files["metadata/general.json"])
    parameters = files["metadata/parameter.json"]
    assert general == {
        "version": 1,
        "metadataTypes": [
            {"type": 1, "uri": "mftp:///metadata/parameter.json", "fileCrc": crc32_by_the_bit(parameters)}
        ],
    }
    assert json.loads(parameters)["version"] == 1


def test_a_parameters_metadata_has_unit_bounds_default_choices_and_what_a_person_should_know() -> None:
    gain, pole, on, act = json.loads(metadata.files(BOOK)["metadata/parameter.json"]())["parameters"]
    assert gain == {
        "name": "L_GAIN",
        "type": "Float",
        "shortDesc": "How strong.",
        "longDesc": "law.gain_deg in autopilot.toml.",
        "group": "law",
        "units": "deg",
        "default": 0.5,
        "min": -1.0,
        "max": 10.0,
    }
    assert pole["longDesc"] == "law.poles_1_s[1] in autopilot.toml. It cannot be changed while armed."
    assert "default" not in pole
    assert (on["type"], on["default"], on["min"], on["max"], on["rebootRequired"]) == ("Int32", 1, 0, 1, True)
    assert on["values"] == [{"value": 0, "description": "false"}, {"value": 1, "description": "true"}]
    assert "units" not in on
    assert act["values"] == [{"value": 0, "description": "none"}, {"value": 2, "description": "surface"}]


def test_the_pack_has_the_values_of_the_moment_with_or_without_those_of_the_files() -> None:
    book = ParameterStore(BOOK.settings, Nobody())
    files = metadata.files(book)
    book.settings[0] = replace(book.settings[0], value=7.0)
    plain = MAVFTP.ftp_param_decode(files["@PARAM/param.pck"]())
    both = MAVFTP.ftp_param_decode(files["@PARAM/param.pck?withdefaults=1"]())
    assert plain.params[0][:2] == both.params[0][:2] == (b"L_GAIN", 7.0)
    assert both.defaults[0][:2] == (b"L_GAIN", 2.5)


def test_component_metadata_is_the_message_of_the_standard() -> None:
    files = metadata.files(BOOK)
    frame = metadata.encoder(files)(cycle(250)).pack(mavlink.MAVLink(None, 1, 1))
    uri = b"mftp:///metadata/general.json"
    payload = struct.pack("<II", 2500, crc32_by_the_bit(files["metadata/general.json"]())) + uri
    assert frame[:10] == bytes((0xFD, len(payload), 0, 0, 0, 1, 1)) + (397).to_bytes(3, "little")
    assert frame[10:-2] == payload
    said = "COMPONENT_METADATA uint32_t time_boot_ms uint32_t file_crc char uri "
    extra = mavlink.x25crc(said.encode() + b"\x64").crc
    assert frame[-2:] == struct.pack("<H", mavlink.x25crc(frame[1:-2] + bytes(((extra ^ extra >> 8) & 0xFF,))).crc)


@pytest.mark.parametrize("name", ["metadata/general.json", "metadata/parameter.json"])
def test_a_file_has_the_same_bytes_each_time_or_its_checksum_were_none(name: str) -> None:
    files = metadata.files(BOOK)
    assert files[name]() == files[name]() == metadata.files(BOOK)[name]()
