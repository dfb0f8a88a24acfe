"""The DVL's lines of JSON: the maker's examples, every field refused in every way."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial import waterlink_json
from firmware_py.wire.serial.stream import SentenceError
from firmware_py.wire.serial.waterlink_dvl import Velocity
from firmware_py.wire.serial.waterlink_json import decode, encode

# The report of the maker's page, with one of its four transducers written out.
BEAM = '{"id":%d,"velocity":0.00010825289791682735,"distance":0.5568,"rssi":-30.494,"nsd":-88.7,"beam_valid":true}'
EXAMPLE = (
    '{"time":106.3935775756836,"vx":-3.713480691658333e-05,"vy":5.703703573090024e-05,"vz":2.4990416932269e-05,'
    '"fom":0.00016016385052353144,"covariance":[[2.4471841442164077e-08,-3.3937477272871774e-09,-1.6659699175747278e-09],'
    "[-3.3937477272871774e-09,1.4654466085062268e-08,4.0409570134514183e-10],"
    "[-1.6659699175747278e-09,4.0409570134514183e-10,1.5971971523143225e-09]],"
    '"altitude":0.4949815273284912,"transducers":[' + ",".join(BEAM % k for k in range(4)) + '],"velocity_valid":true,'
    '"status":0,"format":"json_v3.3","type":"velocity","time_of_validity":1638191471563017,'
    '"time_of_transmission":1638191471752336}'
).encode()
REPORT = Velocity(
    -3.713480691658333e-05,
    5.703703573090024e-05,
    2.4990416932269e-05,
    True,
    0.4949815273284912,
    0.00016016385052353144,
    (
        *(2.4471841442164077e-08, -3.3937477272871774e-09, -1.6659699175747278e-09),
        *(-3.3937477272871774e-09, 1.4654466085062268e-08, 4.0409570134514183e-10),
        *(-1.6659699175747278e-09, 4.0409570134514183e-10, 1.5971971523143225e-09),
    ),
    1638191471563017,
    1638191471752336,
    106.3935775756836,
    0,
)
POSITION = (
    b'{"ts":49056.809,"x":12.4,"y":64.6,"z":1.7,"std":0.002,"roll":0.6,"pitch":0.6,"yaw":0.6,"type":"position_local",'
    b'"status":0,"format":"json_v3.3"}'
)
RESPONSE = (
    b'{"response_to":"set_config","success":true,"error_message":"","result":null,"format":"json_v3.3",'
    b'"type":"response"}'
)
numbers = st.floats(-1e12, 1e12)
times = st.integers(0, 2**63 - 1)


def changed(**fields: Any) -> bytes:
    """Return the example with other fields; one that is ... is missing."""
    content = {**json.loads(EXAMPLE), **fields}
    return json.dumps({name: value for name, value in content.items() if value is not ...}).encode()


def test_the_example_of_the_maker_is_read() -> None:
    assert decode(EXAMPLE) == REPORT
    assert len(EXAMPLE) < waterlink_json.LONGEST_LINE * 0.7


@pytest.mark.parametrize("line", [POSITION, RESPONSE, changed(type="velocity_water"), b'{"type":"news"}'])
def test_other_messages_are_known_and_skipped(line: bytes) -> None:
    assert decode(line) is None


@given(
    st.tuples(numbers, numbers, numbers),
    st.booleans(),
    numbers,
    numbers,
    st.tuples(*[numbers] * 9),
    st.tuples(times, times),
    numbers,
    st.integers(0, 255),
)
def test_what_is_written_is_read_exactly(
    velocity: tuple[float, float, float],
    valid: bool,
    altitude: float,
    fom: float,
    covariance: tuple[float, ...],
    stamps: tuple[int, int],
    time: float,
    status: int,
) -> None:
    report = Velocity(*velocity, valid, altitude, fom, covariance, *stamps, time, status)
    assert decode(encode(report).strip()) == report


@pytest.mark.parametrize(
    "name", ["vx", "vy", "vz", "altitude", "fom", "time", "time_of_validity", "time_of_transmission"]
)
@pytest.mark.parametrize(
    "value", [..., None, "1", True, [1.0], {"a": 1}, 10**400, -(10**400), 1e13], ids=lambda value: str(value)[:9]
)
def test_a_number_that_is_none_is_refused(name: str, value: object) -> None:
    if value == 1e13 and name.startswith("time_of"):
        value = 1.5
    with pytest.raises(SentenceError, match=name):
        decode(changed(**{name: value}))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_json_has_no_number_for_is_refused(value: float) -> None:
    with pytest.raises(SentenceError, match="no number of JSON"):
        decode(encode(REPORT._replace(vy=value)).strip())
    with pytest.raises(SentenceError, match="vx"):
        decode(EXAMPLE.replace(b"-3.713480691658333e-05", b"1e999"))


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        ({"velocity_valid": 1}, "velocity_valid = 1: must be true or false"),
        ({"velocity_valid": "true"}, "velocity_valid"),
        ({"velocity_valid": ...}, "velocity_valid = None"),
        ({"status": -1}, "status"),
        ({"status": 0.5}, "status"),
        ({"time_of_validity": 2**63}, "time_of_validity"),
        ({"covariance": ...}, "three rows"),
        ({"covariance": [1.0] * 9}, "three rows"),
        ({"covariance": [[1.0] * 3] * 4}, "three rows"),
        ({"covariance": [[1.0] * 3, [1.0] * 3, [1.0] * 2]}, "three rows"),
        ({"covariance": [[1.0] * 3, [1.0] * 3, [1.0, 1.0, None]]}, "covariance = None"),
        ({"format": "json_v4.0"}, "'json_v4.0': must be json_v3.x"),
        ({"format": "json_v2"}, "json_v2"),
        ({"format": 3}, "format 3"),
        ({"format": ...}, "format None"),
        ({"type": ...}, "object with a type"),
        ({"type": 1}, "object with a type"),
    ],
)
def test_a_malformed_report_says_why(fields: dict[str, Any], why: str) -> None:
    with pytest.raises(SentenceError, match=why):
        decode(changed(**fields))


@pytest.mark.parametrize("version", ["json_v3", "json_v3.1", "json_v3.17"])
def test_all_minor_versions_are_read(version: str) -> None:
    assert decode(changed(format=version)) == REPORT


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b"", "JSON"),
        (b"[]", "object with a type"),
        (b"7", "object with a type"),
        (b"null", "object with a type"),
        (EXAMPLE[:-1], "JSON"),
        (EXAMPLE + b"}", "JSON"),
        (b"\xff" + EXAMPLE, "JSON"),
        (EXAMPLE.decode().encode("utf-16"), "JSON"),
        (b"\xef\xbb\xbf" + EXAMPLE, "JSON"),
        (b"[" * 2000, "64 brackets"),
        (b'{"a":' * 400, "64 brackets"),
        (b'{"type":"velocity","a":' + b"[" * 60 + b"]" * 60 + b"}", "format None"),
        (b"1" * 2000, "object"),
    ],
    ids=range(13),
)
def test_what_is_no_message_is_refused(line: bytes, why: str) -> None:
    with pytest.raises(SentenceError, match=why):
        decode(line)


def test_what_the_device_does_not_vouch_for_is_not_used() -> None:
    report = decode(changed(velocity_valid=False, altitude=-1))
    assert report is not None
    assert not report.usable
    assert math.isnan(report.bottom)
    assert REPORT.usable
    assert REPORT.bottom == REPORT.altitude


def test_commands_have_the_documented_form() -> None:
    assert waterlink_json.trigger_ping() == b'{"command":"trigger_ping"}\n'
    assert waterlink_json.get_configuration() == b'{"command":"get_config"}\n'
    assert (
        waterlink_json.set_configuration(1480.2) == b'{"command":"set_config","parameters":{"speed_of_sound":1480}}\n'
    )
    both = json.loads(waterlink_json.set_configuration(1500.0, acoustic_enabled=False))
    assert both["parameters"] == {"speed_of_sound": 1500, "acoustic_enabled": False}
    for speed in (999.0, 2001.0, math.nan):
        with pytest.raises(ValueError, match=r"\[1000, 2000\]"):
            waterlink_json.set_configuration(speed)
    with pytest.raises(ValueError, match="nothing to set"):
        waterlink_json.set_configuration()
