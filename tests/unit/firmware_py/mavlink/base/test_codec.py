"""Frames in a stream: wherever it is cut, and whatever stands between them."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.base.codec import Codec

MS = 1_000_000
KINDS = st.sampled_from(["v2", "v1", "signed"])


def frame(number: int, kind: str = "v2") -> bytes:
    mav = mavlink.MAVLink(None, 255, 190)
    if kind == "signed":
        mav.signing.secret_key, mav.signing.sign_outgoing = bytes(32), True
    return mavlink.MAVLink_param_set_message(1, 1, b"NAME", float(number), 9).pack(mav, force_mavlink1=kind == "v1")


def fed(codec: Codec, parts: list[bytes], step_ms: int = 1, most: int = 32) -> list[float]:
    values = []
    for i, part in enumerate(parts):
        messages, looked = codec.parse(part, most, i * step_ms * MS)
        assert looked <= most
        assert sum(len(kept) for kept in vars(codec).values() if isinstance(kept, bytes)) < 300
        values += [message.param_value for message in messages if message.get_type() == "PARAM_SET"]
    return values


@given(st.lists(KINDS, max_size=6), st.lists(st.integers(1, 60), min_size=1, max_size=40))
def test_frames_are_found_wherever_the_stream_is_cut(kinds: list[str], sizes: list[int]) -> None:
    stream = b"".join(frame(i, kind) for i, kind in enumerate(kinds))
    parts, at, turn = [], 0, 0
    while at < len(stream):
        parts.append(stream[at : at + sizes[turn % len(sizes)]])
        at, turn = at + len(parts[-1]), turn + 1
    codec = Codec(1, stream=True)
    assert fed(codec, parts) == list(map(float, range(len(kinds))))
    assert codec.malformed == 0


def test_frames_come_byte_by_byte() -> None:
    codec = Codec(1, stream=True)
    assert fed(codec, [bytes([byte]) for byte in frame(1) + frame(2, "v1") + frame(3, "signed")]) == [1.0, 2.0, 3.0]


@given(st.binary(max_size=100), st.binary(max_size=100))
def test_after_noise_the_stream_is_found_again(before: bytes, between: bytes) -> None:
    # However the noise pretends to begin a frame: once what it claims has come, or time has passed, it is seen through.
    codec = Codec(1, stream=True)
    parts = [before + frame(1), between + frame(2), frame(3), frame(4)]
    assert fed(codec, parts, step_ms=300, most=300)[-2:] == [3.0, 4.0]


def test_a_beginning_that_never_goes_on_does_not_swallow_what_comes_later() -> None:
    codec = Codec(1, stream=True)
    assert fed(codec, [b"\xfd\xff\x00\x00", frame(1)], step_ms=500) == [1.0]
    codec = Codec(1, stream=True)
    assert fed(codec, [frame(1)[:20], frame(2)], step_ms=500) == [2.0]


@settings(max_examples=200)
@given(st.lists(st.one_of(st.binary(max_size=300), st.sampled_from([b"\xfd" * 300, b"\xfe" * 300])), max_size=20))
def test_no_stream_raises_or_is_kept_beyond_a_frame(parts: list[bytes]) -> None:
    fed(Codec(1, stream=True), parts)
